// Set operations on masks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/option_words.h"
#include "octavo/core/volume.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

enum class Combination : std::uint8_t { unite, intersect, subtract, exclusive_or, complement };

constexpr auto option_words(Combination) {
  return in_order<Combination>("union", "intersect", "subtract", "xor", "complement");
}

struct CombineOptions {
  std::vector<std::string> inputs;  ///< label maps: one for the complement, else two or more
  Output output{};
  Combination combination = Combination::unite;
  /// Further masks are brought onto the grid of the first, by nearest voxels.
  bool is_resampling = false;
};

struct CombineResult {
  VolumeDescription volume;  ///< the grid, that of the first mask
  std::uint64_t voxels = 0;
  std::vector<std::string> resampled = {};  ///< inputs that lay on another grid
  std::uint64_t file_bytes = 0;
};

/// The planes that `combine` writes, of masks on one grid.
/// Throws  as combine does before it writes, the name of the output apart; Error{invalid_argument}
///         for masks that are to be resampled
/// Memory  a layer of bricks of each mask
ComputedVolume combined_planes(const CombineOptions& options, const TaskContext& context);

/// What is left of one mask or two, in memory, on the grid of the first.
/// b  null for the complement
/// Throws  Error{invalid_argument} for a wrong count of masks
/// Requires masks of one grid
ComputedMask combined_mask(const ComputedMask& a, const ComputedMask* b, Combination combination,
                           const TaskContext& context);

/// Writes what is left of the masks, taken from left to right. Notes which were resampled; warns as
/// open_mask_on does.
/// Throws  as require_computed, open_mask and build_file; Error{invalid_argument} for a wrong count
///         of masks, and for grids that differ where masks are not resampled
/// Memory  three masks
CombineResult combine(const CombineOptions& options, const TaskContext& context);

}  // namespace octavo
