#include "octavo/tasks/combine.h"

#include <array>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/tasks/masks.h"

namespace octavo {

namespace {

constexpr std::array kNames = {"union", "intersect", "subtract", "xor", "complement"};

SetOperation operation_of(Combination combination) {
  switch (combination) {
    case Combination::unite: return SetOperation::unite;
    case Combination::intersect: return SetOperation::intersect;
    case Combination::subtract: return SetOperation::subtract;
    default: return SetOperation::exclusive_or;
  }
}

void require_masks(const CombineOptions& options) {
  const std::string name = combination_name(options.combination);
  const std::size_t count = options.inputs.size();
  const bool is_complement = options.combination == Combination::complement;
  if (is_complement ? count == 1 : count >= 2) return;
  throw Error(ErrorKind::invalid_argument,
              name + (is_complement ? " takes one mask, got " : " takes two masks or more, got ") +
                  std::to_string(count));
}

/// A further mask on the grid of the first.
MaskTree further_mask(const std::string& path, const OpenedMask& first,
                      const CombineOptions& options, CombineResult& result,
                      const TaskContext& context) {
  if (!options.is_resampling) {
    OpenedMask next = open_mask(path, context);
    require_same_grid(first.volume(), first.path, next.volume(), next.path, "is_resampling");
    return std::move(next.tree);
  }
  MaskOnGrid next = open_mask_on(first.volume(), first.path, path, context);
  if (next.is_resampled) {
    result.resampled.push_back(path);
    context.note(path + ": brought onto the grid of " + first.path + " by nearest voxels");
  }
  return std::move(next.tree);
}

MadeBy made_by(const CombineOptions& options, const CombineResult& result) {
  MadeBy made(combination_name(options.combination));
  made.set("masks", options.inputs.size());
  if (!result.resampled.empty()) made.set("resampled", result.resampled.size());
  return made;
}

}  // namespace

const char* combination_name(Combination combination) {
  return kNames[static_cast<std::size_t>(combination)];
}

CombineResult combine(const CombineOptions& options, const TaskContext& context) {
  require_masks(options);
  require_computed(options.output, options.inputs);
  OpenedMask first = open_mask(options.inputs.front(), context);
  CombineResult result{.volume = first.volume()};

  MaskTree mask = std::move(first.tree);
  if (options.combination == Combination::complement) {
    context.on_threads([&] { mask = complement(mask); });
  }
  for (std::size_t i = 1; i < options.inputs.size(); ++i) {
    const MaskTree next = further_mask(options.inputs[i], first, options, result, context);
    const SetOperation operation = operation_of(options.combination);
    context.on_threads([&] { mask = combine(mask, next, operation); });
  }

  result.voxels = mask.voxel_count();
  result.file_bytes = write_mask(mask, result.volume, made_by(options, result), options.output,
                                 "combine", context)
                          .file_bytes;
  return result;
}

}  // namespace octavo
