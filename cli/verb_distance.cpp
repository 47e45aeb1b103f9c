// octavo distance: how far every voxel is from the surface of a mask.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/distance.h"
#include "text/fact_json.h"
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
    "With --within MM a voxel may end up that far from its distance, which is proven: files are\n"
    "far smaller, since cubes that the coarser levels foretell so well take no bytes.\n\n"
    "Memory is bounded: what does not fit lies in a scratch file beside the output, and with\n"
    "--max-mm only planes that near are held.\n\n"
    "Examples:\n"
    "  octavo distance skull.8vo -o distance.8vo\n"
    "  octavo distance bone.8vo --max-mm 5 --step 0.01 -o near.8vo\n"
    "  octavo distance bone.8vo --within 0.01 -o small.8vo"};

const char* hold_word(DistanceHold hold) {
  switch (hold) {
    case DistanceHold::memory: return "memory";
    case DistanceHold::disk: return "disk";
    case DistanceHold::window: break;
  }
  return "window";
}

int run_distance(const DistanceOptions& options, Context& context) {
  const DistanceResult result = run_task(distance, options, context);
  const double step_mm = result.volume.rescale.slope;
  print_result(
      context,
      {{"output", options.output.path},
       {"to", word_of(options.to)},
       {"smallest_mm", result.smallest_mm},
       {"largest_mm", result.largest_mm},
       {"step_mm", json_of(options.is_in_steps ? std::optional(step_mm) : std::nullopt)},
       {"max_error_mm", result.max_error_mm},
       {"held_in", hold_word(result.hold)},
       {"file_bytes", result.file_bytes}},
      fmt::format("{}: {:.6g} to {:.6g} mm{}\n", shown_path(options.output.path),
                  result.smallest_mm, result.largest_mm,
                  options.is_in_steps ? fmt::format(", in steps of {} mm", step_mm) : ""));
  return kExitDone;
}

}  // namespace

void add_distance(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kDistanceText, run_distance);
  add_mask_input(verb, options.input);
  verb.add_output(options.output, "The .8vo file to write");
  verb.add_word("--to WHERE", options.to, "Where distances end: faces or centers");
  verb.add_option("--max-mm MM", options.max_mm, "Larger distances become this one, either sign")
      .check(above_zero());
  Option step = verb.add_option("--step MM", options.step_mm, "int16 voxels of so many mm")
                    .check(above_zero());
  verb.add_option("--within MM", options.within_mm, "How far a voxel may be off: smaller files")
      .check(above_zero());
  verb.add_flag("--steps", options.is_in_steps, "int16 voxels, of the step that reaches all")
      .excludes(step);
  verb.before_run([&made = options] { made.is_in_steps |= made.step_mm.has_value(); });
}

}  // namespace octavo::cli
