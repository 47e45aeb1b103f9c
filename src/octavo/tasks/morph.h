// Masks grown and shrunk: dilate, erode, open, close.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/made_by.h"
#include "octavo/core/option_words.h"
#include "octavo/core/volume.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/word_neighbors.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

enum class Morphology : std::uint8_t { dilate, erode, open, close };

constexpr auto option_words(Morphology) {
  return in_order<Morphology>("dilate", "erode", "open", "close");
}

struct MorphOptions {
  Morphology morphology = Morphology::dilate;
  std::string input;  ///< a label map; every voxel but 0 is in the mask
  Output output;
  std::optional<double> mm{};  ///< radius of the ball, between voxel centers; 0 or more
  /// Without a radius: steps from voxel to neighbor, 0 or more.
  std::int64_t steps = 0;
  Connectivity connectivity = Connectivity::faces;  ///< which voxels are neighbors
};

struct MorphResult {
  VolumeDescription volume;  ///< that of the mask
  std::uint64_t voxels = 0;
  std::uint64_t voxels_before = 0;
  std::uint64_t file_bytes = 0;
};

/// The mask that morph writes, in memory.
/// volume   that the mask is of
/// options  their input names the mask in errors
/// Throws  as morph does before it writes, opening apart
MaskTree morphed_mask(const MaskTree& mask, const VolumeDescription& volume,
                      const MorphOptions& options, const TaskContext& context);

/// How morph changed a mask, for the metadata of its file.
MadeBy made_by_morph(const MorphOptions& options);

/// Writes the mask grown, shrunk, opened or closed. Warns when nothing of it is left.
/// Throws  as require_computed, open_mask, Reach and build_file; Error{invalid_argument} for a
///         radius where the spacing is not known; Error{limit_exceeded}
/// Memory  five masks, the table of the ball, and dilation_thread_bytes per thread
MorphResult morph(const MorphOptions& options, const TaskContext& context);

}  // namespace octavo
