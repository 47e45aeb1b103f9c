// octavo build: a scan in, one .8vo file out.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "common/failure.h"
#include "common/isotropic_option.h"
#include "common/options.h"
#include "common/scan_arguments.h"
#include "common/task_run.h"
#include "octavo/tasks/files/build_scan.h"
#include "text/built_words.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kBuildText = {
    "build", "Fold a scan into one .8vo file, losslessly or with a maximum error.",
    "A source is a DICOM folder, a TIFF or PNG stack, a NIfTI, NRRD, MetaImage, VTK or GIPL\n"
    "file, raw voxels or another .8vo file. Stored voxels are kept as they are, unless\n"
    "--max-error E allows each to end up to E away, in real units; every brick is decoded again\n"
    "and compared.\n\n"
    "float32 voxels are kept bit by bit, NaN and infinities among them: smallest where all are\n"
    "whole multiples of one number (plus another), larger where they are noise to the last bit.\n"
    "A coarse sample is the mean of those of the level below that are finite, NaN where none\n"
    "is, in steps that the first planes and some of the others choose: values beyond 2^31 steps\n"
    "count there as 2^31 steps, which is a warning. --max-error makes far smaller files of noise;\n"
    "with it NaN and infinities are rejected unless --nan and --inf say what takes their place.\n"
    "Where few different values take fewer bytes bit by bit, they stay as they are.\n\n"
    "int64, uint64 and float64, which NumPy makes unless told otherwise, become int32, uint32\n"
    "or float32: the first planes choose, and a value that does not fit is rejected with its\n"
    "place. float64 that is no float32 is rounded to it, with a warning.\n\n"
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
    "cubic convolution with a = -0.5, no B-spline) between grey slices, rounded to stored values;\n"
    "by the shapes of the labels between label slices.\n"
    "It makes planes along z only, and none behind the last slice.\n\n"
    "--label-names gives labels the names and colors of a text file: lines of NUMBER NAME, as\n"
    "atlases have them, with a color R G B or R G B A behind it (FreeSurfer, 3D Slicer), of NAME\n"
    "NUMBER, or ITK-SNAP's. Tables and pictures then show them, and info lists them.\n\n"
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
    "Examples:\n"
    "  octavo build scans/head/ -o head.8vo\n"
    "  octavo build slices/*.tif --spacing 0.0195 -o bone.8vo\n"
    "  octavo build volume.raw --raw 512,512,300,int16 --spacing 0.8,0.8,1 -o volume.8vo\n"
    "  octavo build aal.nii.gz --labels --label-names aal.nii.txt -o aal.8vo\n"
    "  octavo build cells.tif --channel 1 --time 0 -o cells.8vo\n"
    "  octavo build scans/tilted/ --untilt --on-gap resample -o upright.8vo\n"
    "  octavo build scans/thick/ --isotropic -o cubes.8vo\n"
    "  octavo build scans/head/ --max-error 2 -o small.8vo\n"
    "  octavo build scans/head/ --keep-details 1 -o preview.8vo\n"
    "  octavo build density.nii --max-error 0.001 --nan 0 -o density.8vo"};

struct BuildArguments {
  std::vector<std::string> inputs;
  std::string output;
  bool labels = false;
  bool grey = false;
  std::string label_names;
  bool resume = false;
  bool thumbnail = false;
  std::string preset = "small";
  std::string access;
  std::string max_error = "0";
  int keep_details = 0;
  std::string nan;
  std::string infinity;
  std::string isotropic;
  ScanArguments scan;
};

std::optional<float> parse_float(const std::string& text, const std::string& what) {
  if (text.empty()) return std::nullopt;
  const auto value = static_cast<float>(parse_number(text, what));
  if (std::isfinite(value)) return value;
  throw Error(ErrorKind::invalid_argument, what + ": '" + escaped(text) + "' is beyond float32");
}

std::optional<Access> parse_access(const std::string& text) {
  const auto* const name = std::find(kAccessNames.begin(), kAccessNames.end(), text);
  if (name == kAccessNames.end()) return std::nullopt;
  return static_cast<Access>(name - kAccessNames.begin());
}

BuildScanOptions options_of(const BuildArguments& arguments, const Context& context) {
  BuildScanOptions options;
  options.inputs = arguments.inputs;
  options.output = {arguments.output, context.force, arguments.thumbnail};
  if (arguments.labels) options.kind = VolumeKind::labels;
  if (arguments.grey) options.kind = VolumeKind::grey;
  options.label_names = arguments.label_names;
  options.preset = arguments.preset == "fast" ? Preset::fast : Preset::small;
  options.access = parse_access(arguments.access);
  options.max_error = parse_number(arguments.max_error, "--max-error");
  if (options.max_error < 0) {
    throw Error(ErrorKind::invalid_argument, "--max-error: must not be negative");
  }
  options.keep_details = arguments.keep_details;
  options.repair.nan = parse_float(arguments.nan, "--nan");
  options.repair.infinity = parse_float(arguments.infinity, "--inf");
  options.between = isotropic_method(arguments.isotropic);
  options.is_resuming = arguments.resume;
  options.scan = scan_options(arguments.scan);
  return options;
}

int run_build(const BuildArguments& arguments, Context& context) {
  const BuiltVolume built = run_task(build_scan, options_of(arguments, context), context);
  print_built(built, arguments.output, context);
  return kExitDone;
}

}  // namespace

void add_build(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<BuildArguments>();
  Verb verb = add_verb(app, context, kBuildText,
                            [arguments, &context] { return run_build(*arguments, context); });
  verb.add_option("inputs", arguments->inputs, "One folder or file, or the files of a stack")
      ->type_name("SOURCE")
      ->required();
  verb.add_output(arguments->output, "The file to write");
  Option labels =
      verb.add_flag("--labels", arguments->labels, "A mask or label map: numbers are names");
  verb.add_flag("--grey", arguments->grey,
                "Measured values (default; labels are told by their name)")
      ->excludes(labels);
  verb.add_option("--label-names", arguments->label_names,
                  "A text file with names and colors of the labels")
      ->type_name("FILE");
  verb.add_option("--preset", arguments->preset, "small: fewest bytes; fast: several times faster")
      ->type_name("NAME")
      ->check(one_of({"small", "fast"}))
      ->capture_default_str();
  verb.add_option("--access", arguments->access,
                  "What of a brick of 64^3 voxels decodes alone: none, slices (64 x 32 x 32) or "
                  "boxes (32^3). Default: slices in fast, none in small")
      ->type_name("NAME")
      ->check(one_of({kAccessNames.begin(), kAccessNames.end()}));
  verb.add_option("--max-error", arguments->max_error,
                  "How far a voxel may end up from its source, real units; 0: lossless")
      ->type_name("E")
      ->capture_default_str();
  verb.add_option("--keep-details", arguments->keep_details,
                  "The finest level whose details are kept; finer ones are interpolated. Not with "
                  "--max-error, nor with --access slices or boxes")
      ->type_name("K")
      ->check(whole_within(1, 5));
  verb.add_option("--nan", arguments->nan, "float32: what takes the place of NaN")
      ->type_name("VALUE");
  verb.add_option("--inf", arguments->infinity,
                  "float32: what takes the place of +infinity; of -infinity its negative")
      ->type_name("VALUE");
  verb.add_flag("--keep-identity", arguments->scan.keep_identity,
                "Keep names, dates and free text of the source in the metadata");
  verb.add_flag("--thumbnail", arguments->thumbnail,
                "Put a small picture into the file, for file managers and viewers");
  add_isotropic_option(verb, arguments->isotropic);
  verb.add_flag("--resume", arguments->resume,
                "Continue an interrupted build of FILE, and keep this one if it is interrupted");
  add_scan_options(verb, arguments->scan);
}

}  // namespace octavo::cli
