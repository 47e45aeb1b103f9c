// octavo export and extract: voxels out, in the formats other programs read.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/options.h"
#include "common/progress_line.h"
#include "common/salvaging.h"
#include "octavo/io/export/export.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kExportText = {
    "export", "Write a volume, or a level or box of it, for other programs.",
    "The format follows the name: .raw .nrrd .nii .nii.gz .mha .mhd, and .tif or a folder\n"
    "(FOLDER/) for a stack. Values are real units (HU) where the format holds them exactly;\n"
    "--stored writes the stored integers; .raw is always stored, in C order z, y, x,\n"
    "little-endian. What nobody knows, the spacing or how the patient lies, is left out where the\n"
    "format can leave it out; elsewhere a warning says so. A damaged file is refused (exit code\n"
    "4), unless --salvage says how to fill what is damaged; everything else then equals the\n"
    "original.\n\n"
    "Examples:\n"
    "  octavo export head.8vo -o head.nii.gz\n"
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

struct Arguments {
  std::string input;
  std::string output;
  int level = 0;
  bool level_given = false;
  std::string box;
  std::string box_mm;
  bool stored = false;
  SalvageArguments salvage;
};

ExportOptions export_options(const Arguments& arguments, const FileReader& reader,
                             const Context& context) {
  check_level(reader.levels(), arguments.level);
  const Size3& size = reader.levels().size(arguments.level);
  ExportOptions options;
  options.level = arguments.level;
  options.stored = arguments.stored;
  options.overwrite = context.force;
  options.threads = context.thread_count();
  if (!arguments.box.empty()) options.box = parse_box(arguments.box, size);
  if (!arguments.box_mm.empty()) {
    require_known_spacing(reader.description(), arguments.input, "--box-mm", "--box");
    const Geometry geometry =
        reader.levels().geometry(reader.description().geometry, arguments.level);
    options.box = parse_box_mm(arguments.box_mm, geometry, size);
  }
  return options;
}

/// "1 mm", "0.5 x 0.5 x 2 mm"
std::string spacing_text(const FileReader& reader, int level) {
  const Point3 mm = reader.levels().geometry(reader.description().geometry, level).spacing_mm;
  const bool is_cube = mm[0] == mm[1] && mm[1] == mm[2];
  return (is_cube ? number_text(mm[0]) : point_text(mm)) + " mm";
}

/// What the file claims though nobody knows it, and what it cannot keep, a warning each.
std::vector<std::string> limit_warnings(const Arguments& arguments, const FileReader& reader,
                                        ExportFormat format, const ExportOptions& options) {
  std::vector<std::string> warnings;
  const ExportLimits limits = export_limits(reader, format, options);
  const auto add = [&](const std::string& text) {
    warnings.push_back(arguments.output + ": " + text);
  };
  if (limits.claims_spacing) {
    add(fmt::format("the spacing of {} is not known; the file says {}, as its format needs a "
                    "number",
                    arguments.input, spacing_text(reader, options.level)));
  }
  if (limits.claims_place) {
    add(fmt::format("how the patient lies is not known in {}; other programs may show letters for "
                    "left and right all the same",
                    arguments.input));
  }
  if (limits.loses_box_start) {
    const Index3& start = options.box->lo;
    add(fmt::format("does not keep that the box begins at voxel {},{},{} of {}, in which how the "
                    "patient lies is not known; .nrrd keeps it",
                    start.x, start.y, start.z, arguments.input));
  }
  return warnings;
}

nlohmann::ordered_json result_json(const ExportResult& result, const Box& box, int level,
                                   const FileReader& reader, const Context& context) {
  return {{"files", result.files},
          {"level", level},
          {"box", {{box.lo.x, box.hi.x}, {box.lo.y, box.hi.y}, {box.lo.z, box.hi.z}}},
          {"type", voxel_type_name(result.type)},
          {"values", result.real_units ? "real" : "stored"},
          {"bytes", result.bytes},
          {"salvaged", salvaged_json(reader)},
          {"warnings", context.warnings}};
}

std::string result_text(const ExportResult& result, const Box& box, int level) {
  std::string files = result.files.empty() ? "" : result.files.front();
  if (result.files.size() == 2) files += " and " + result.files.back();
  if (result.files.size() > 2) {
    files += fmt::format(" .. {} ({} files)", result.files.back(), result.files.size());
  }
  return fmt::format("{}: {} {} of level {}, {} values, {}\n", files, size_text(box.size()),
                     voxel_type_name(result.type), level, result.real_units ? "real" : "stored",
                     bytes_text(result.bytes));
}

int run_export(const Arguments& arguments, Context& context) {
  const ExportFormat format = export_format_of(arguments.output);
  const auto reader =
      salvaging(open_octavo(arguments.input, context), arguments.salvage, context);
  const ExportOptions options = export_options(arguments, *reader, context);
  const std::vector<std::string> warnings = limit_warnings(arguments, *reader, format, options);
  // Where a warning is an error nothing is written; elsewhere it is about what was written.
  if (context.strict && !warnings.empty()) context.warn(warnings.front());
  ExportResult result;
  read_or_hint(arguments.salvage, context, [&] {
    ProgressLine progress(context);
    result = export_volume(*reader, local_storage(), arguments.output, format, options, progress);
  });
  for (const std::string& warning : warnings) context.warn(warning);
  warn_of_salvaged(*reader, context);
  const Box box = options.box.value_or(box_of(reader->levels().size(options.level)));
  if (context.json) print_json(result_json(result, box, options.level, *reader, context));
  else if (!context.quiet) print(result_text(result, box, options.level));
  return kExitDone;
}

int run_extract(const Arguments& arguments, Context& context) {
  if (arguments.box.empty() && arguments.box_mm.empty() && !arguments.level_given) {
    throw Error(ErrorKind::invalid_argument,
                "extract needs --box, --box-mm or --level; export writes the whole volume");
  }
  return run_export(arguments, context);
}

void add_options(Verb verb, const std::shared_ptr<Arguments>& arguments) {
  verb.add_option("file", arguments->input, "An .8vo file or a URL of one")
      ->type_name("FILE")
      ->required();
  verb.add_option("-o,--output", arguments->output, "The file or folder/ to write")
      ->type_name("FILE")
      ->required();
  verb.add_option_function<int>(
          "--level",
          [arguments](int level) {
            arguments->level = level;
            arguments->level_given = true;
          },
          "Level of detail: 0 is the scan, each level halves it")
      ->type_name("K")
      ->default_str("0");
  Option box = verb.add_option("--box", arguments->box,
                                     "x0:x1,y0:y1,z0:z1 in voxels of the level, half-open");
  box->type_name("BOX");
  verb.add_option("--box-mm", arguments->box_mm, "The same in mm: the voxels centered inside")
      ->type_name("BOX")
      ->excludes(box);
  verb.add_flag("--stored", arguments->stored, "Stored integers instead of real units");
  add_salvage_option(verb, arguments->salvage);
}

}  // namespace

void add_export(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kExportText,
                            [arguments, &context] { return run_export(*arguments, context); });
  add_options(verb, arguments);
}

void add_extract(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kExtractText,
                            [arguments, &context] { return run_extract(*arguments, context); });
  add_options(verb, arguments);
}

}  // namespace octavo::cli
