// octavo transform: volumes moved, turned, scaled, or brought onto another grid.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <variant>
#include <vector>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/affine_file.h"
#include "octavo/tasks/transform.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
#include "text/turn_words.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kTransformText = {
    "transform", "Move, turn, mirror or scale a volume, or bring it onto another grid.",
    "Steps are done in the order in which they are typed, each as often as it is typed. All\n"
    "become one map: voxels are interpolated once, and only the last grid drops what lies outside\n"
    "of it.\n\n"
    "--translate and --translate-mm move the whole volume: its origin changes; where there is no\n"
    "other step its bricks are copied and not decoded. --shift moves the voxels within the grid;\n"
    "what falls out is dropped.\n\n"
    "--rotate AXIS:DEGREES turns about the center of the grid. The axis is x, y or z of the grid,\n"
    "or X,Y,Z along them, in mm. It is right-handed: z:90 lays along y what lay along x. The grid\n"
    "becomes as large as the turned volume. Quarter turns and --mirror move whole voxels,\n"
    "exactly; other angles interpolate. The geometry follows, so that every voxel keeps its place\n"
    "in space. --scale 2 makes a finer grid, --scale 1/2 takes the coarser level. With --in-place\n"
    "the direction and the center of the grid stay and the object turns, or grows, instead.\n\n"
    "--affine moves the object: a point p (mm, LPS) goes to M p. With --inverse M leads from the\n"
    "new place to the old one, as transforms of ITK's resampler do. The grid stays, or is that of\n"
    "--grid-of, which is the last grid wherever it is typed.\n\n"
    "Labels are taken from the nearest voxel, grey values interpolated: linear, or cubic, which\n"
    "is Keys' cubic convolution with a = -0.5 (Catmull-Rom), not ITK's B-spline. Voxels that come\n"
    "from outside are --fill.\n\n"
    "Examples:\n"
    "  octavo transform head.8vo --translate-mm 0,0,-12.5 -o moved.8vo\n"
    "  octavo transform head.8vo --rotate z:90 --rotate x:180 -o turned.8vo\n"
    "  octavo transform head.8vo --rotate z:-7.5 --mirror x --in-place -o upright.8vo\n"
    "  octavo transform labels.8vo --grid-of head.8vo -o labels-on-head.8vo\n"
    "  octavo transform follow-up.8vo --affine register.txt --grid-of head.8vo -o aligned.8vo\n"
    "  octavo transform head.8vo --scale 1/2 -o half.8vo"};

/// A step as it is typed.
struct TypedStep {
  std::string option;  ///< "--shift"
  std::string text;
};

struct TransformArguments {
  TransformOptions options;      ///< with the steps once they are parsed
  std::vector<TypedStep> steps;  ///< in the order of the command line
  bool is_inverse = false;
  bool is_in_place = false;
};

TransformStep parse_step(const TypedStep& typed, const TransformArguments& arguments) {
  const auto& [option, text] = typed;
  if (option == "--translate") return TranslateStep{parse_index(text, option)};
  if (option == "--translate-mm") return TranslateMmStep{parse_point(text, option)};
  if (option == "--shift") return ShiftStep{parse_index(text, option)};
  if (option == "--rotate") return RotateStep{{parse_rotation(text)}, arguments.is_in_place};
  if (option == "--mirror") return MirrorStep{{parse_mirror(text)}, arguments.is_in_place};
  if (option == "--affine") return AffineStep{read_affine(text), arguments.is_inverse};
  ScaleStep scale = parse_scale(text);
  scale.is_in_place = arguments.is_in_place;
  return scale;
}

/// A rotation that may have to interpolate.
bool is_between_axes(const TransformStep& step) {
  const auto* const rotate = std::get_if<RotateStep>(&step);
  return rotate != nullptr &&
         std::any_of(rotate->rotations.begin(), rotate->rotations.end(), [](const AxisRotation& r) {
           return std::count(r.axis.begin(), r.axis.end(), 0.0) != 2 ||
                  std::fmod(r.degrees, 90) != 0;
         });
}

void require_use(bool is_given, const char* option, bool is_of_use, const char* with) {
  if (!is_given || is_of_use) return;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{} changes nothing here; it goes with {}", option, with));
}

/// Rejects options that none of the steps heeds.
void check_options(const TransformArguments& arguments) {
  const TransformOptions& options = arguments.options;
  const std::vector<TransformStep>& steps = options.steps;
  const bool has_grid = !options.grid_of.empty();
  if (steps.empty() && !has_grid) {
    throw Error(ErrorKind::invalid_argument,
                "transform needs one of --translate, --translate-mm, --shift, --rotate, --mirror, "
                "--scale, --affine and --grid-of");
  }
  const auto has_one = [&](const auto& is_such) {
    return std::any_of(steps.begin(), steps.end(), is_such);
  };
  const auto is_a = []<class... Steps>() {
    return [](const TransformStep& step) { return (std::holds_alternative<Steps>(step) || ...); };
  };
  const bool has_affine = has_one(is_a.operator()<AffineStep>());
  const bool has_scale_up = has_one([](const TransformStep& step) {
    const auto* const scale = std::get_if<ScaleStep>(&step);
    return scale != nullptr && scale->is_finer;
  });
  const bool is_resampled = has_affine || has_grid || has_one(is_between_axes);
  require_use(arguments.is_inverse, "--inverse", has_affine, "--affine");
  require_use(arguments.is_in_place, "--in-place",
              has_one(is_a.operator()<RotateStep, MirrorStep, ScaleStep>()),
              "--rotate, --mirror and --scale");
  require_use(options.fill.has_value(), "--fill",
              is_resampled || has_one(is_a.operator()<ShiftStep>()),
              "--shift, --affine, --grid-of and --rotate by other angles than quarter turns");
  require_use(options.interpolation.has_value(), "--interpolation", is_resampled || has_scale_up,
              "--affine, --grid-of, --scale N and --rotate by other angles than quarter turns");
  const bool is_copy =
      !has_grid && std::all_of(steps.begin(), steps.end(),
                               is_a.operator()<TranslateStep, TranslateMmStep>());
  require_use(options.preset != Preset::small, "--preset", !is_copy, "what makes new voxels");
  require_use(options.max_error != 0, "--max-error", !is_copy, "what makes new voxels");
}

/// " of 1 x 1 x 2 mm, origin 0, 0, 0 mm"
std::string grid_text(const VolumeDescription& volume) {
  if (!is_spacing_known(volume)) return " (spacing not known)";
  return fmt::format(" of {} mm, origin {} mm", point_text(volume.geometry.spacing_mm),
                     point_text(volume.geometry.origin_mm, ", "));
}

nlohmann::ordered_json report_json(const TransformOptions& options, const TransformResult& result) {
  const VolumeDescription& volume = result.volume;
  return {{"output", options.output.path},
          {"operation", result.operation},
          {"bricks", result.is_copied ? "copied" : "made"},
          {"size", size_json(volume.size)},
          {"spacing_mm", if_in_mm(volume, volume.geometry.spacing_mm)},
          {"origin_mm", if_in_mm(volume, volume.geometry.origin_mm)},
          {"direction", volume.geometry.direction},
          {"file_bytes", result.file_bytes}};
}

int run_transform(const TransformArguments& arguments, Context& context) {
  check_options(arguments);
  const TransformOptions& options = arguments.options;
  const TransformResult result = run_task(transform, options, context);
  print_result(
      context, report_json(options, result),
      fmt::format("{}: {} voxels{}; {}\n", shown_path(options.output.path),
                  size_text(result.volume.size), grid_text(result.volume), result.summary));
  return kExitDone;
}

}  // namespace

void add_transform(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kTransformText, run_transform);
  TransformOptions& options = arguments.options;
  verb.add_input(options.input);
  verb.add_output(options.output, "The .8vo file to write");
  auto add = [verb = verb, &steps = arguments.steps](const char* name, const char* help) mutable {
    verb.add_option_in_order(name, help,
                             [&steps](const std::string& text, const std::string& option) {
                               steps.push_back({option, text});
                             })
        .group("Steps, in the order in which they are typed");
  };
  add("--translate X,Y,Z", "Move the volume by x,y,z voxels: its origin");
  add("--translate-mm X,Y,Z", "Move the volume by x,y,z mm (LPS): its origin");
  add("--shift X,Y,Z", "Move the voxels by x,y,z within the grid");
  add("--rotate AXIS:DEGREES", "Turn about an axis of the grid, or X,Y,Z: z:90, x:-12.5, 1,1,0:30");
  add("--mirror AXIS", "Reverse an index axis: x, y or z");
  add("--scale N", "A grid N times as fine, or 1/N: a coarser level");
  add("--affine FILE", "Move the object by a 4 x 4 matrix in a text file (mm, LPS)");
  verb.before_run([&arguments = arguments] {
    for (const TypedStep& typed : arguments.steps) {
      add_step(parse_step(typed, arguments), arguments.options.steps);
    }
  });
  verb.add_option("--grid-of FILE", options.grid_of, "Resample onto the grid of this .8vo file");
  verb.add_flag("--inverse", arguments.is_inverse, "Take the inverse of the matrices");
  verb.add_flag("--in-place", arguments.is_in_place,
                "Keep direction and center of the grid: the object turns or grows");
  verb.add_word("--interpolation NAME", options.interpolation,
                "nearest, linear or cubic: Keys, a = -0.5 (default: linear; labels: nearest)");
  verb.add_parsed(
      "--fill V", options.fill, parse_number,
      "Real value from outside (default: the minimum, of lossless floats near it; labels: 0)");
  add_preset(verb, options.preset);
  verb.add_parsed("--max-error E", options.max_error, parse_max_error,
                  "Every new voxel within E of what was computed")
      .default_str("0");
}

}  // namespace octavo::cli
