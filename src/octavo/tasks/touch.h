// Whether two masks overlap or touch, and which labels of a label map lie side by side.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/ops/label/label_adjacency.h"
#include "octavo/ops/mask/interference.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct TouchMasksOptions {
  std::string a;  ///< label maps on one grid; every voxel but 0 is in the mask
  std::string b;
  Connectivity connectivity = Connectivity::faces;  ///< which voxels are neighbors
};

struct TouchMasksResult {
  VolumeDescription volume;  ///< the grid
  Interference found;
};

struct TouchLabelsOptions {
  std::string labels;  ///< a label map
  Connectivity connectivity = Connectivity::faces;
};

struct TouchLabelsResult {
  VolumeDescription volume;  ///< that of the labels
  std::vector<LabelContact> contacts;  ///< ascending
};

/// The area of faces across x, y and z, mm2; nothing where the spacing is not known.
std::optional<double> area_mm2(const std::array<std::uint64_t, 3>& faces,
                               const VolumeDescription& volume);

/// How two masks meet.
/// Throws  as open_mask; Error{invalid_argument} for grids that differ
/// Memory  two masks
TouchMasksResult touch_masks(const TouchMasksOptions& options, const TaskContext& context);

/// The pairs of labels but 0 that are neighbors.
/// Throws  as open_labels and label_contacts
/// Memory  as label_contacts, 12 MiB per thread
TouchLabelsResult touch_labels(const TouchLabelsOptions& options, const TaskContext& context);

}  // namespace octavo
