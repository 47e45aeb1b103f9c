// octavo build: a scan in, one .8vo file out.
#include <optional>

#include "common/build_options.h"
#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/parts/build_in_parts.h"
#include "text/built_words.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kBuildText = {
    "build", "Fold a scan into one .8vo file, losslessly or with a maximum error.",
    "A source is a DICOM folder, a TIFF or PNG stack, a NIfTI, NRRD, MetaImage, VTK or GIPL\n"
    "file, an OME-Zarr image, raw voxels or another .8vo file. Stored voxels are kept as they\n"
    "are, unless --max-error E allows each to end up to E away, in real units; every brick is\n"
    "decoded again and compared.\n\n"
    "float32 voxels are kept bit by bit, NaN and infinities among them: smallest where all are\n"
    "whole multiples of one number (plus another), larger where they are noise to the last bit.\n"
    "A coarse sample is the mean of those of the level below that are finite, NaN where none\n"
    "is, in steps that the first planes and some of the others choose (info shows them): a 32nd\n"
    "of the range of these values at most. Values beyond 2^31 steps count there as 2^31 steps,\n"
    "which is a warning. Masks are far smaller with --labels. --max-error makes far smaller files\n"
    "of noise; with it NaN and infinities are rejected unless --nan and --inf say what takes\n"
    "their place. Where few values take fewer bytes bit by bit, they stay as they are.\n\n"
    "int64, uint64 and float64, which NumPy makes unless told otherwise, become int32, uint32\n"
    "or float32: the first planes choose, and a value that does not fit is rejected with its\n"
    "place. float64 that is no float32 is rounded to it, with a warning.\n\n"
    "A build holds two groups of planes in memory: layers of 64 that reach 32 MiB. Where\n"
    "--max-memory is less, volumes are built in bands of bricks, to the same file: the planes are\n"
    "read twice more, and once for each band. With --max-error and --keep-details the encoded\n"
    "bricks of a layer wait in a file beside the output. Sources that can only be read from their\n"
    "start on (gzip) are rejected then.\n\n"
    "Whoever reads a part of a volume decodes bricks of 64^3 voxels, or quarters of them with\n"
    "--access slices and eighths with --access boxes: up to 3 times as fast, from files that are\n"
    "about 0.5 and 0.9 % larger. Preset fast takes slices unless they cost more than 0.7 %.\n\n"
    "--keep-details K keeps the details of level K (cubes of side 2^K) and of all coarser levels,\n"
    "which come out as those of a lossless file. Finer levels take no bytes and are interpolated:\n"
    "the largest and the RMS error and the PSNR are measured, printed and kept in the metadata.\n"
    "At the same size --max-error keeps more of most scans; this is for previews that share the\n"
    "grid of their scan. Integer grey values only, K from 1 to 5; not with --max-error, nor with\n"
    "--access slices or boxes: level 0 has no bytes to be cut.\n\n"
    "The slices of a DICOM series must make an even, upright stack. Where they do not, --on-gap\n"
    "fill interpolates the planes that an even grid lacks (left empty in a segmentation),\n"
    "--on-gap resample makes planes at the smallest regular step, and --untilt moves the slices\n"
    "of a tilted gantry upright. What was done is reported and kept in the metadata. Numbered\n"
    "TIFF or PNG files whose numbers skip are rejected; --on-gap ignore takes them as\n"
    "neighbors.\n\n"
    "A voxel has one value: --channel and --time take one of colors, channels and times.\n"
    "Both count from 0, as do all positions here; colors also have names.\n\n"
    "Where slices lie further apart than the pixels, --isotropic makes planes in between until\n"
    "voxels are cubes: linear (or cubic, which is smoother and may overshoot at edges: Keys'\n"
    "cubic convolution with a = -0.5, no B-spline) between grey slices, rounded to stored values\n"
    "(where --on-gap fill made a slice, that was rounded before: twice in all); by the shapes of\n"
    "the labels between label slices.\n"
    "It makes planes along z only, and none behind the last slice.\n\n"
    "--label-names gives labels the names and colors of a text file: lines of NUMBER NAME, as\n"
    "atlases have them, with a color R G B or R G B A behind it (FreeSurfer, 3D Slicer), of NAME\n"
    "NUMBER, ITK-SNAP's, Connectome Workbench's, or the table of a GIFTI file. Tables and\n"
    "pictures then show them, and info lists them.\n\n"
    "Names, dates, identifiers and free text of the source stay out of the file, as do names of\n"
    "files; info --metadata lists what was dropped. --keep-identity puts them into the metadata:\n"
    "of DICOM the attributes of the first slice that are text, and the labels of segments, which\n"
    "without it are numbers alone. Exports never hold them.\n\n"
    "--thumbnail puts a PNG of at most 256 x 256 pixels into the file: a coronal plane through\n"
    "the middle, seen from the front; of flat volumes the plane of the longer sides. info\n"
    "--thumbnail writes it, verify proves it, and transform makes it anew.\n\n"
    "With --resume a build that was interrupted (a signal, a full disk, a power cut) continues\n"
    "behind the last whole group of planes, which hold 32 MiB of voxels or somewhat more: what\n"
    "stops in the first group keeps nothing. The scan is read again and must be the same; so is\n"
    "the finished file, byte for byte. Give --resume from the start where work may not be lost.\n\n"
    "--parts N builds in parts that know nothing of each other, side by side on the threads of\n"
    "-j, and joins them: the same file. It is there to try what plan, part and join do on many\n"
    "machines. The parts stand in a hidden folder beside the file until they are joined. --bands\n"
    "N does it with parts of which N share each group of planes, as of octavo plan.\n\n"
    "Examples:\n"
    "  octavo build scans/head/ -o head.8vo\n"
    "  octavo build slices/*.tif --spacing 0.0195 -o bone.8vo\n"
    "  octavo build volume.raw --raw 512,512,300,int16 --spacing 0.8,0.8,1 -o volume.8vo\n"
    "  octavo build aal.nii.gz --labels --label-names aal.nii.txt -o aal.8vo\n"
    "  octavo build cells.tif --channel 1 --time 0 -o cells.8vo\n"
    "  octavo build brain.ome.zarr --channel 0 -o brain.8vo\n"
    "  octavo build scans/tilted/ --untilt --on-gap resample -o upright.8vo\n"
    "  octavo build scans/thick/ --isotropic -o cubes.8vo\n"
    "  octavo build scans/head/ --max-error 2 -o small.8vo\n"
    "  octavo build scans/head/ --keep-details 1 -o preview.8vo\n"
    "  octavo build scans/head/ --parts 4 -o parted.8vo\n"
    "  octavo build density.nii --max-error 0.001 --nan 0 -o density.8vo"};

struct BuildArguments {
  BuildScanOptions scan;
  std::optional<std::int64_t> parts;
  std::optional<std::int64_t> bands;
};

int run_build(const BuildArguments& arguments, Context& context) {
  const BuildScanOptions& options = arguments.scan;
  const bool is_in_parts = arguments.parts || arguments.bands;
  const BuildInPartsOptions in_parts{options, arguments.parts.value_or(1), arguments.bands};
  const BuiltVolume built = is_in_parts ? run_task(build_in_parts, in_parts, context)
                                        : run_task(build_scan, options, context);
  print_built(built, options.output.path, context);
  return kExitDone;
}

}  // namespace

void add_build(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kBuildText, run_build);
  add_build_options(verb, arguments.scan).required();
  verb.add_output(arguments.scan.output, "The file to write");
  Option resume = verb.add_flag(
      "--resume", arguments.scan.is_resuming,
      "Continue an interrupted build of FILE, and keep this one if it is interrupted");
  Option parts = verb.add_option("--parts N", arguments.parts, "Build in N parts, and join them")
                     .check(whole_within(1))
                     .excludes(resume);
  verb.add_option("--bands N", arguments.bands,
                  "Build in parts of which N share each group of planes, and join them")
      .check(whole_within(1))
      .excludes(resume)
      .excludes(parts);
}

}  // namespace octavo::cli
