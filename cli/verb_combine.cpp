// octavo combine: set operations on masks.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/options.h"
#include "octavo/ops/mask/set_operations.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "combine", "Unite, intersect or subtract masks.",
    "A mask is every voxel of a label map that is not 0. The volumes must share one grid: size,\n"
    "spacing, origin and direction; --resample brings every further mask onto the grid of the\n"
    "first, by nearest voxels. Three and more masks are taken from left to right.\n\n"
    "Examples:\n"
    "  octavo combine skull.8vo teeth.8vo --subtract -o bare.8vo\n"
    "  octavo combine left.8vo right.8vo --union -o both.8vo\n"
    "  octavo combine tumor.8vo tumor-mr.8vo --resample --intersect -o agreed.8vo\n"
    "  octavo combine bone.8vo --complement -o rest.8vo"};

struct Arguments {
  std::vector<std::string> inputs;
  std::string output;
  bool is_union = false;
  bool is_intersection = false;
  bool is_difference = false;
  bool is_xor = false;
  bool is_complement = false;
  bool is_resampling = false;
};

std::optional<SetOperation> operation_of(const Arguments& arguments) {
  if (arguments.is_union) return SetOperation::unite;
  if (arguments.is_intersection) return SetOperation::intersect;
  if (arguments.is_difference) return SetOperation::subtract;
  if (arguments.is_xor) return SetOperation::exclusive_or;
  return std::nullopt;
}

const char* name_of(const Arguments& arguments) {
  return arguments.is_union          ? "union"
         : arguments.is_intersection ? "intersect"
         : arguments.is_difference   ? "subtract"
         : arguments.is_xor          ? "xor"
                                     : "complement";
}

void check_arguments(const Arguments& arguments) {
  if (!arguments.is_complement && !operation_of(arguments)) {
    throw Error(ErrorKind::invalid_argument,
                "combine needs one of --union, --intersect, --subtract, --xor and --complement");
  }
  if (arguments.is_complement && arguments.inputs.size() != 1) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--complement takes one mask, got {}", arguments.inputs.size()));
  }
  if (arguments.is_complement && arguments.is_resampling) {
    throw Error(ErrorKind::invalid_argument,
                "--resample changes nothing with --complement, which takes one mask");
  }
  if (!arguments.is_complement && arguments.inputs.size() < 2) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--{} takes two masks or more, got one", name_of(arguments)));
  }
}

/// A further mask on the grid of the first.
MaskTree further_mask(const std::string& path, const OpenedMask& first, const Arguments& arguments,
                      std::vector<std::string>& resampled, Context& context) {
  if (!arguments.is_resampling) {
    OpenedMask next = open_mask(path, context);
    require_same_grid(first.volume(), first.path, next.volume(), next.path,
                      "--resample brings it onto that of the first");
    return std::move(next.tree);
  }
  MaskOnGrid next = open_mask_on(first.volume(), first.path, path, context);
  if (next.is_resampled) {
    resampled.push_back(path);
    context.note(path + ": brought onto the grid of " + first.path + " by nearest voxels");
  }
  return std::move(next.tree);
}

int run_combine(const Arguments& arguments, Context& context) {
  check_arguments(arguments);
  require_computed_output(arguments.output, arguments.inputs, context);
  OpenedMask first = open_mask(arguments.inputs.front(), context);
  MaskTree result = std::move(first.tree);
  std::vector<std::string> resampled;
  if (arguments.is_complement) {
    on_threads(context, [&] { result = complement(result); });
  }
  for (std::size_t i = 1; i < arguments.inputs.size(); ++i) {
    const MaskTree next =
        further_mask(arguments.inputs[i], first, arguments, resampled, context);
    on_threads(context, [&] { result = combine(result, next, *operation_of(arguments)); });
  }
  const std::uint64_t voxels = result.voxel_count();
  nlohmann::ordered_json made_by = {{"operation", name_of(arguments)},
                                    {"masks", arguments.inputs.size()}};
  if (!resampled.empty()) made_by["resampled"] = resampled.size();
  const BuildResult built =
      write_mask(result, first.volume(), made_by, arguments.output, context);
  if (context.json) {
    print_json({{"output", arguments.output},
                {"operation", name_of(arguments)},
                {"voxels", voxels},
                {"mm3", mm3_json(voxels, first.volume())},
                {"resampled", resampled},
                {"file_bytes", built.file_bytes},
                {"warnings", context.warnings}});
  } else if (!context.quiet) {
    print(fmt::format("{}: {}\n", arguments.output, volume_text(voxels, first.volume())));
  }
  return kExitDone;
}

}  // namespace

void add_combine(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_combine(*arguments, context); });
  verb.add_option("masks", arguments->inputs, "Label maps, .8vo")->type_name("FILE")->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo mask to write")
      ->type_name("FILE")
      ->required();
  verb.add_flag("--resample", arguments->is_resampling,
                "Bring further masks onto the grid of the first");
  Verb operation = verb.add_choice("Operation");
  operation.add_flag("--union", arguments->is_union, "Voxels that are in any mask");
  operation.add_flag("--intersect", arguments->is_intersection, "Voxels that are in all masks");
  operation.add_flag("--subtract", arguments->is_difference,
                      "Voxels of the first mask that are in no other");
  operation.add_flag("--xor", arguments->is_xor, "Voxels that are in an odd number of masks");
  operation.add_flag("--complement", arguments->is_complement, "Voxels that are not in the mask");
}

}  // namespace octavo::cli
