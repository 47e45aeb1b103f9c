// octavo combine: set operations on masks.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/combine.h"
#include "octavo/tasks/volume_facts.h"
#include "text/fact_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kCombineText = {
    "combine", "Unite, intersect or subtract masks.",
    "A mask is every voxel of a label map that is not 0. The volumes must share one grid: size,\n"
    "spacing, origin and direction; --resample brings every further mask onto the grid of the\n"
    "first, by nearest voxels. Three and more masks are taken from left to right.\n\n"
    "Examples:\n"
    "  octavo combine skull.8vo teeth.8vo --subtract -o bare.8vo\n"
    "  octavo combine left.8vo right.8vo --union -o both.8vo\n"
    "  octavo combine tumor.8vo tumor-mr.8vo --resample --intersect -o agreed.8vo\n"
    "  octavo combine bone.8vo --complement -o rest.8vo"};

int run_combine(const CombineOptions& options, Context& context) {
  const CombineResult result = run_task(combine, options, context);
  print_result(
      context,
      {{"output", options.output.path},
       {"operation", word_of(options.combination)},
       {"voxels", result.voxels},
       {"mm3", json_of(mm3_of(result.voxels, result.volume))},
       {"resampled", result.resampled},
       {"file_bytes", result.file_bytes}},
      fmt::format("{}: {}\n", shown_path(options.output.path),
                  volume_text(result.voxels, result.volume)));
  return kExitDone;
}

}  // namespace

void add_combine(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kCombineText, run_combine);
  verb.add_option("masks FILE", options.inputs, "Label maps, .8vo").required();
  verb.add_output(options.output, "The .8vo mask to write");
  Option resample = verb.add_flag("--resample", options.is_resampling,
                                  "Bring further masks onto the grid of the first");
  Verb operation = verb.add_choice("Operation");
  const auto add = [&, &made = options.combination](const char* name, Combination combination,
                                                    const char* help) {
    return operation.add_flag_of(name, made, combination, help);
  };
  add("--union", Combination::unite, "Voxels that are in any mask");
  add("--intersect", Combination::intersect, "Voxels that are in all masks");
  add("--subtract", Combination::subtract, "Voxels of the first mask that are in no other");
  add("--xor", Combination::exclusive_or, "Voxels that are in an odd number of masks");
  add("--complement", Combination::complement, "Voxels that are not in the mask")
      .excludes(resample);
}

}  // namespace octavo::cli
