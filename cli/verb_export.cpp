// octavo export and extract: voxels out, in the formats other programs read.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/failure.h"
#include "common/options.h"
#include "common/salvage_option.h"
#include "common/task_run.h"
#include "octavo/tasks/files/export_part.h"
#include "octavo/tasks/files/export_zarr_image.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kExportText = {
    "export", "Write a volume, or a level or box of it, for other programs.",
    "The format follows the name: .raw .nrrd .nii .nii.gz .mha .mhd, and .tif or a folder\n"
    "(FOLDER/) for a stack. Values are real units (HU) where integers hold them, or where the\n"
    "format has a slope that all programs apply (NIfTI); elsewhere the stored integers, with a\n"
    "warning. --real writes real units as float32, --stored the stored integers; .raw is stored\n"
    "unless --real is given, in C order z, y, x, little-endian. What nobody knows, the spacing\n"
    "or how the patient lies, is left out where the format can leave it out; elsewhere a warning\n"
    "says so. A damaged file is rejected (exit code 4), unless --salvage says how to fill what is\n"
    "damaged; everything else then equals the original.\n\n"
    ".ome.zarr (a folder) and .ozx (one zip file) are OME-Zarr 0.5 images: all levels from\n"
    "--level on as sharded zarr v3 arrays, stored values; the whole geometry, slope and intercept\n"
    "stand in an attribute.\n\n"
    "Examples:\n"
    "  octavo export head.8vo -o head.nii.gz\n"
    "  octavo export head.8vo -o head.ome.zarr\n"
    "  octavo export head.8vo --level 2 -o preview.nrrd\n"
    "  octavo export head.8vo -o slices/\n"
    "  octavo export damaged.8vo --salvage coarse -o rescued.nii.gz"};

constexpr VerbText kExtractText = {
    "extract", "Write a box or a level of a volume: export of a part.",
    "The same as export, but --box, --box-mm or --level must say which part.\n\n"
    "Examples:\n"
    "  octavo extract head.8vo --box 64:192,64:192,40:80 -o box.nrrd\n"
    "  octavo extract head.8vo --level 1 --box :,:,20:21 -o plane.tif\n"
    "  octavo extract https://example.org/head.8vo --box-mm=-40:40,-40:40,0:60 -o box.nii.gz"};

struct ExportArguments {
  ExportPartOptions part;
  std::optional<int> level;
  std::optional<ZarrCompression> compression;
};

nlohmann::ordered_json result_json(const ExportPartResult& result, int level) {
  return {{"files", result.written.files},
          {"level", level},
          {"box", box_json(result.box)},
          {"type", voxel_type_name(result.written.type)},
          {"values", result.written.real_units ? "real" : "stored"},
          {"bytes", result.written.bytes},
          {"salvaged", salvaged_json(result.salvaged)}};
}

std::string result_text(const ExportResult& result, const Box& box, int level) {
  std::string files = result.files.empty() ? "" : shown_path(result.files.front());
  if (result.files.size() == 2) files += " and " + shown_path(result.files.back());
  if (result.files.size() > 2) {
    files += fmt::format(" .. {} ({} files)", shown_path(result.files.back()),
                         result.files.size());
  }
  return fmt::format("{}: {} {} of level {}, {} values, {}\n", files, size_text(box.size()),
                     voxel_type_name(result.type), level, result.real_units ? "real" : "stored",
                     bytes_text(result.bytes));
}

/// All levels from one on, as an OME-Zarr image.
int run_zarr_export(const ExportArguments& arguments, Context& context) {
  const ExportPartOptions& part = arguments.part;
  if (part.box || part.box_mm || part.values == ExportValues::real || part.salvage) {
    throw Error(ErrorKind::invalid_argument,
                "OME-Zarr images are whole volumes of stored values: --box, --box-mm, --real and "
                "--salvage are of other formats",
                part.output.path);
  }
  const ZarrImageOptions options{
      .input = part.input,
      .output = part.output,
      .level = part.level,
      .compression = arguments.compression.value_or(ZarrCompression::zstd)};
  const ZarrImageResult result = run_task(export_zarr_image, options, context);
  print_result(
      context,
      {{"output", part.output.path},
       {"levels", result.written.levels},
       {"files", result.written.files},
       {"bytes", result.written.bytes}},
      fmt::format("{}: {} in {}, {}\n", shown_path(part.output.path),
                  count_of(static_cast<std::uint64_t>(result.written.levels), "level"),
                  count_of(result.written.files, "file"), bytes_text(result.written.bytes)));
  return kExitDone;
}

int run_export(const ExportArguments& arguments, Context& context) {
  const ExportPartOptions& options = arguments.part;
  if (is_zarr_path(options.output.path)) return run_zarr_export(arguments, context);
  if (arguments.compression) {
    throw Error(ErrorKind::invalid_argument, "--compression is of .ome.zarr and .ozx",
                options.output.path);
  }
  const ExportPartResult result = run_task(export_part, options, context);
  print_result(context, result_json(result, options.level),
               result_text(result.written, result.box, options.level));
  return kExitDone;
}

int run_extract(const ExportArguments& arguments, Context& context) {
  if (!arguments.part.box && !arguments.part.box_mm && !arguments.level) {
    throw Error(ErrorKind::invalid_argument,
                "extract needs --box, --box-mm or --level; export writes the whole volume");
  }
  return run_export(arguments, context);
}

void add_options(Verb verb, ExportArguments& arguments) {
  ExportPartOptions& options = arguments.part;
  verb.add_input(options.input);
  verb.add_output(options.output, "The file or folder/ to write");
  verb.add_option("--level K", arguments.level,
                  "Level of detail: 0 is the scan, each level halves it")
      .default_str("0");
  verb.before_run([&arguments] { arguments.part.level = arguments.level.value_or(0); });
  Option box = verb.add_parsed("--box BOX", options.box, parse_box,
                               "x0:x1,y0:y1,z0:z1 in voxels of the level, half-open");
  verb.add_parsed("--box-mm BOX", options.box_mm, parse_box_mm,
                  "The same in mm: the voxels centered inside; on an oblique grid the box of "
                  "voxels around them")
      .excludes(box);
  Option stored = verb.add_flag_of("--stored", options.values, ExportValues::stored,
                                   "Stored integers instead of real units");
  verb.add_flag_of("--real", options.values, ExportValues::real,
                   "Real units as float32, in every format")
      .excludes(stored);
  verb.add_word("--compression NAME", arguments.compression, "Of OME-Zarr: zstd, blosc or none");
  add_salvage_option(verb, options.salvage);
}

}  // namespace

void add_export(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kExportText, run_export);
  add_options(verb, arguments);
}

void add_extract(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kExtractText, run_extract);
  add_options(verb, arguments);
}

}  // namespace octavo::cli
