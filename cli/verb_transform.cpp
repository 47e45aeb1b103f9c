// octavo transform: volumes moved, turned, scaled, or brought onto another grid.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/affine_file.h"
#include "octavo/tasks/transform.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
#include "text/turn_words.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kTransformText = {
    "transform", "Move, turn, mirror or scale a volume, or bring it onto another grid.",
    "--translate and --translate-mm move the whole volume: its origin changes, its bricks are\n"
    "copied and not decoded. --shift moves the voxels within the grid; what falls out is dropped.\n"
    "--rotate and --mirror move whole voxels, exactly, and may be repeated; the geometry follows,\n"
    "so that every voxel keeps its place in space. Rotations are right-handed in index space:\n"
    "z:90 lays along y what lay along x. --scale 2 makes a finer grid, --scale 1/2 takes the\n"
    "coarser level. With --in-place the direction and the center of the grid stay and the object\n"
    "turns, or grows, instead.\n\n"
    "--affine moves the object: a point p (mm, LPS) goes to M p. With --inverse M leads from the\n"
    "new place to the old one, as transforms of ITK's resampler do. The grid stays, or is that of\n"
    "--grid-of. Labels are taken from the nearest voxel, grey values interpolated. Voxels that\n"
    "come from outside are --fill.\n\n"
    "Examples:\n"
    "  octavo transform head.8vo --translate-mm 0,0,-12.5 -o moved.8vo\n"
    "  octavo transform head.8vo --rotate z:90 --rotate x:180 -o turned.8vo\n"
    "  octavo transform labels.8vo --grid-of head.8vo -o labels-on-head.8vo\n"
    "  octavo transform follow-up.8vo --affine register.txt --grid-of head.8vo -o aligned.8vo\n"
    "  octavo transform head.8vo --scale 1/2 -o half.8vo"};

struct TransformArguments {
  std::string input;
  std::string output;
  std::string translate;
  std::string translate_mm;
  std::string shift;
  std::vector<std::string> rotations;
  std::vector<std::string> mirrors;
  std::string scale;
  std::string affine;
  std::string grid_of;
  bool is_inverse = false;
  bool is_in_place = false;
  std::string interpolation;
  std::string fill;
  std::string preset = "small";
  std::string max_error = "0";
};

/// The one operation, by its option.
std::string operation_of(const TransformArguments& arguments) {
  std::vector<std::string> asked;
  if (!arguments.translate.empty()) asked.emplace_back("translate");
  if (!arguments.translate_mm.empty()) asked.emplace_back("translate-mm");
  if (!arguments.shift.empty()) asked.emplace_back("shift");
  if (!arguments.rotations.empty()) asked.emplace_back("rotate");
  if (!arguments.mirrors.empty()) asked.emplace_back("mirror");
  if (!arguments.scale.empty()) asked.emplace_back("scale");
  if (!arguments.affine.empty()) asked.emplace_back("affine");
  else if (!arguments.grid_of.empty()) asked.emplace_back("grid-of");
  if (asked.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "transform needs one of --translate, --translate-mm, --shift, --rotate, --mirror, "
                "--scale, --affine and --grid-of");
  }
  if (asked.size() > 1) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--{} and --{} are two steps; transform does one at a time", asked[0],
                            asked[1]));
  }
  return asked.front();
}

void require_use(bool is_given, const char* option, bool is_of_use, const char* with) {
  if (!is_given || is_of_use) return;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{} changes nothing here; it goes with {}", option, with));
}

/// Rejects options that the operation would ignore.
void check_options(const TransformArguments& arguments, const std::string& operation) {
  const auto is_one_of = [&](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), operation) != names.end();
  };
  require_use(!arguments.grid_of.empty(), "--grid-of", is_one_of({"affine", "grid-of"}),
              "--affine, or alone");
  require_use(arguments.is_inverse, "--inverse", is_one_of({"affine"}), "--affine");
  require_use(arguments.is_in_place, "--in-place", is_one_of({"rotate", "mirror", "scale"}),
              "--rotate, --mirror and --scale");
  require_use(!arguments.fill.empty(), "--fill", is_one_of({"shift", "affine", "grid-of"}),
              "--shift, --affine and --grid-of");
  require_use(!arguments.interpolation.empty(), "--interpolation",
              is_one_of({"affine", "grid-of"}) ||
                  (is_one_of({"scale"}) && arguments.scale.find('/') == std::string::npos),
              "--affine, --grid-of and --scale N");
  const bool is_copy = is_one_of({"translate", "translate-mm"});
  require_use(arguments.preset != "small", "--preset", !is_copy, "what makes new voxels");
  require_use(arguments.max_error != "0", "--max-error", !is_copy, "what makes new voxels");
}

std::optional<Interpolation> parse_interpolation(const std::string& name) {
  if (name.empty()) return std::nullopt;
  if (name == "nearest") return Interpolation::nearest;
  return name == "linear" ? Interpolation::linear : Interpolation::cubic;
}

std::optional<double> parse_fill(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional(parse_number(text, "--fill"));
}

ResampleStep resample_step(const TransformArguments& arguments) {
  ResampleStep step;
  step.interpolation = parse_interpolation(arguments.interpolation);
  step.fill = parse_fill(arguments.fill);
  if (!arguments.affine.empty()) step.map_mm = read_affine(arguments.affine);
  step.is_inverse = arguments.is_inverse;
  step.grid_of = arguments.grid_of;
  return step;
}

TransformStep step_of(const TransformArguments& arguments, const std::string& operation) {
  if (operation == "translate") {
    return TranslateStep{parse_index(arguments.translate, "--translate")};
  }
  if (operation == "translate-mm") {
    return TranslateMmStep{parse_point(arguments.translate_mm, "--translate-mm")};
  }
  if (operation == "shift") {
    return ShiftStep{parse_index(arguments.shift, "--shift"), parse_fill(arguments.fill)};
  }
  if (operation == "rotate") {
    RotateStep step{{}, arguments.is_in_place};
    for (const std::string& text : arguments.rotations) {
      step.rotations.push_back(parse_rotation(text));
    }
    return step;
  }
  if (operation == "mirror") {
    MirrorStep step{{}, arguments.is_in_place};
    for (const std::string& text : arguments.mirrors) step.axes.push_back(parse_mirror(text));
    return step;
  }
  if (operation == "scale") {
    ScaleStep step = parse_scale(arguments.scale);
    step.is_in_place = arguments.is_in_place;
    step.interpolation = parse_interpolation(arguments.interpolation);
    return step;
  }
  return resample_step(arguments);
}

TransformOptions options_of(const TransformArguments& arguments, const Context& context) {
  const std::string operation = operation_of(arguments);
  check_options(arguments, operation);
  TransformOptions options;
  options.input = arguments.input;
  options.output = {arguments.output, context.force};
  options.step = step_of(arguments, operation);
  options.preset = arguments.preset == "fast" ? Preset::fast : Preset::small;
  options.max_error = parse_number(arguments.max_error, "--max-error");
  if (options.max_error < 0) {
    throw Error(ErrorKind::invalid_argument, "--max-error: must not be negative");
  }
  return options;
}

/// " of 1 x 1 x 2 mm, origin 0, 0, 0 mm"
std::string grid_text(const VolumeDescription& volume) {
  if (!is_spacing_known(volume)) return " (spacing not known)";
  return fmt::format(" of {} mm, origin {} mm", point_text(volume.geometry.spacing_mm),
                     point_text(volume.geometry.origin_mm, ", "));
}

nlohmann::ordered_json report_json(const TransformArguments& arguments,
                                   const TransformResult& result, const Context& context) {
  const VolumeDescription& volume = result.volume;
  const auto if_in_mm = [&](const Point3& value) {
    return is_spacing_known(volume) ? nlohmann::ordered_json(value)
                                    : nlohmann::ordered_json(nullptr);
  };
  return {{"output", arguments.output},
          {"operation", result.operation},
          {"bricks", result.is_copied ? "copied" : "made"},
          {"size", {volume.size.x, volume.size.y, volume.size.z}},
          {"spacing_mm", if_in_mm(volume.geometry.spacing_mm)},
          {"origin_mm", if_in_mm(volume.geometry.origin_mm)},
          {"direction", volume.geometry.direction},
          {"file_bytes", result.file_bytes},
          {"warnings", context.warnings}};
}

int run_transform(const TransformArguments& arguments, Context& context) {
  const TransformResult result = run_task(transform, options_of(arguments, context), context);
  if (context.json) {
    print_json(report_json(arguments, result, context));
  } else if (!context.quiet) {
    print(fmt::format("{}: {} voxels{}; {}\n", arguments.output, size_text(result.volume.size),
                      grid_text(result.volume), result.summary));
  }
  return kExitDone;
}

}  // namespace

void add_transform(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<TransformArguments>();
  Verb verb = add_verb(app, context, kTransformText,
                            [arguments, &context] { return run_transform(*arguments, context); });
  const auto add = [&](const char* name, std::string& value, const char* text, const char* type) {
    return verb.add_option(name, value, text)->type_name(type);
  };
  add("file", arguments->input, "An .8vo file or a URL of one", "FILE")->required();
  add("-o,--output", arguments->output, "The .8vo file to write", "FILE")->required();
  const char* const kOperation = "Operation";
  add("--translate", arguments->translate, "Move the volume by x,y,z voxels: its origin", "X,Y,Z")
      ->group(kOperation);
  add("--translate-mm", arguments->translate_mm, "Move the volume by x,y,z mm (LPS): its origin",
      "X,Y,Z")
      ->group(kOperation);
  add("--shift", arguments->shift, "Move the voxels by x,y,z within the grid", "X,Y,Z")
      ->group(kOperation);
  verb.add_option("--rotate", arguments->rotations, "Quarter turns about an index axis")
      ->type_name("AXIS:DEGREES")
      ->allow_extra_args(false)
      ->group(kOperation);
  verb.add_option("--mirror", arguments->mirrors, "Reverse an index axis: x, y or z")
      ->type_name("AXIS")
      ->allow_extra_args(false)
      ->group(kOperation);
  add("--scale", arguments->scale, "A grid N times as fine, or 1/N: a coarser level", "N")
      ->group(kOperation);
  add("--affine", arguments->affine, "Move the object by a 4 x 4 matrix in a text file (mm, LPS)",
      "FILE")
      ->group(kOperation);
  add("--grid-of", arguments->grid_of, "Resample onto the grid of this .8vo file", "FILE")
      ->group(kOperation);
  verb.add_flag("--inverse", arguments->is_inverse, "Take the inverse of the matrix");
  verb.add_flag("--in-place", arguments->is_in_place,
                "Keep direction and center of the grid: the object turns or grows");
  add("--interpolation", arguments->interpolation,
      "nearest, linear or cubic (default: linear; labels: nearest)", "NAME")
      ->check(one_of({"nearest", "linear", "cubic"}));
  add("--fill", arguments->fill,
      "Real value from outside (default: the least of the volume; labels: 0)", "V");
  add("--preset", arguments->preset, "small: fewest bytes; fast: several times faster", "NAME")
      ->check(one_of({"small", "fast"}))
      ->capture_default_str();
  add("--max-error", arguments->max_error, "Every new voxel within E of what was computed", "E")
      ->capture_default_str();
}

}  // namespace octavo::cli
