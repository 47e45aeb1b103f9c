// octavo distance: how far every voxel is from the surface of a mask.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/distance.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kDistanceText = {
    "distance", "Write the signed distance of every voxel from the surface of a mask, in mm.",
    "Below 0 inside the mask, above 0 outside, from the center of each voxel; exact whatever the\n"
    "spacing. With --to faces, voxels are cubes and distances end at the faces between the mask\n"
    "and the rest; with --to centers, at the center of the nearest voxel on the other side. What\n"
    "lies beyond the volume is not known: no distance ends there. Voxels are float32, or with\n"
    "--steps or --step MM int16 that count steps: the smallest power of two that reaches all.\n\n"
    "Memory is bounded: what does not fit lies in a scratch file beside the output, and with\n"
    "--max-mm only planes that near are held.\n\n"
    "Examples:\n"
    "  octavo distance skull.8vo -o distance.8vo\n"
    "  octavo distance bone.8vo --max-mm 5 --step 0.01 -o near.8vo"};

struct DistanceArguments {
  std::string input;
  std::string output;
  std::string to = "faces";
  std::optional<double> max_mm;
  std::optional<double> step_mm;
  bool steps = false;
};

const char* hold_word(DistanceHold hold) {
  switch (hold) {
    case DistanceHold::memory: return "memory";
    case DistanceHold::disk: return "disk";
    case DistanceHold::window: break;
  }
  return "window";
}

int run_distance(const DistanceArguments& arguments, Context& context) {
  DistanceOptions options;
  options.input = arguments.input;
  options.output = {arguments.output, context.force};
  options.to = arguments.to == "faces" ? DistanceTo::faces : DistanceTo::centers;
  options.max_mm = arguments.max_mm;
  options.is_in_steps = arguments.steps || arguments.step_mm.has_value();
  options.step_mm = arguments.step_mm;
  const DistanceResult result = run_task(distance, options, context);
  const std::string steps =
      options.is_in_steps ? fmt::format(", in steps of {} mm", result.volume.rescale.slope) : "";
  print_result(context,
               {{"output", arguments.output},
                {"to", arguments.to},
                {"smallest_mm", result.smallest_mm},
                {"largest_mm", result.largest_mm},
                {"step_mm", options.is_in_steps
                                ? nlohmann::ordered_json(result.volume.rescale.slope)
                                : nlohmann::ordered_json(nullptr)},
                {"held_in", hold_word(result.hold)},
                {"file_bytes", result.file_bytes}},
               fmt::format("{}: {:.6g} to {:.6g} mm{}\n", escaped(arguments.output),
                           result.smallest_mm, result.largest_mm, steps));
  return kExitDone;
}

}  // namespace

void add_distance(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<DistanceArguments>();
  Verb verb = add_verb(app, context, kDistanceText, [arguments, &context] {
    return run_distance(*arguments, context);
  });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_output(arguments->output, "The .8vo file to write");
  verb.add_option("--to", arguments->to, "Where distances end: faces (the default) or centers")
      ->type_name("WHERE")
      ->check(one_of({"faces", "centers"}));
  verb.add_option("--max-mm", arguments->max_mm, "Larger distances become this one, either sign")
      ->type_name("MM")
      ->check(above_zero());
  Option step = verb.add_option("--step", arguments->step_mm, "int16 voxels of so many mm");
  step->type_name("MM")->check(above_zero());
  verb.add_flag("--steps", arguments->steps, "int16 voxels, of the step that reaches all")
      ->excludes(step);
}

}  // namespace octavo::cli
