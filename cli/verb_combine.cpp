// octavo combine: set operations on masks.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/combine.h"
#include "octavo/tasks/volume_facts.h"
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

struct CombineArguments {
  std::vector<std::string> inputs;
  std::string output;
  bool is_union = false;
  bool is_intersection = false;
  bool is_difference = false;
  bool is_xor = false;
  bool is_complement = false;
  bool is_resampling = false;
};

CombineOptions options_of(const CombineArguments& arguments, const Context& context) {
  CombineOptions options;
  options.inputs = arguments.inputs;
  options.output = {arguments.output, context.force};
  options.combination = arguments.is_union          ? Combination::unite
                        : arguments.is_intersection ? Combination::intersect
                        : arguments.is_difference   ? Combination::subtract
                        : arguments.is_xor          ? Combination::exclusive_or
                                                    : Combination::complement;
  options.is_resampling = arguments.is_resampling;
  return options;
}

int run_combine(const CombineArguments& arguments, Context& context) {
  const CombineOptions options = options_of(arguments, context);
  const CombineResult result = run_task(combine, options, context);
  print_result(context,
               {{"output", arguments.output},
                {"operation", combination_name(options.combination)},
                {"voxels", result.voxels},
                {"mm3", optional_json(mm3_of(result.voxels, result.volume))},
                {"resampled", result.resampled},
                {"file_bytes", result.file_bytes}},
               fmt::format("{}: {}\n", arguments.output,
                           volume_text(result.voxels, result.volume)));
  return kExitDone;
}

}  // namespace

void add_combine(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<CombineArguments>();
  Verb verb = add_verb(app, context, kCombineText,
                            [arguments, &context] { return run_combine(*arguments, context); });
  verb.add_option("masks", arguments->inputs, "Label maps, .8vo")->type_name("FILE")->required();
  verb.add_output(arguments->output, "The .8vo mask to write");
  Option resample = verb.add_flag("--resample", arguments->is_resampling,
                                  "Bring further masks onto the grid of the first");
  Verb operation = verb.add_choice("Operation");
  operation.add_flag("--union", arguments->is_union, "Voxels that are in any mask");
  operation.add_flag("--intersect", arguments->is_intersection, "Voxels that are in all masks");
  operation.add_flag("--subtract", arguments->is_difference,
                      "Voxels of the first mask that are in no other");
  operation.add_flag("--xor", arguments->is_xor, "Voxels that are in an odd number of masks");
  operation.add_flag("--complement", arguments->is_complement, "Voxels that are not in the mask")
      ->excludes(resample);
}

}  // namespace octavo::cli
