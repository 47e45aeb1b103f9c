// What is connected in a mask: a table of its components, and a label map of them.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/volume.h"
#include "octavo/octree/label_tree.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/word_neighbors.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct ComponentsOptions {
  std::string input;               ///< a label map; every voxel but 0 is in the mask
  std::optional<Output> output{};  ///< nothing: no label map is written
  Connectivity connectivity = Connectivity::faces;
  std::int64_t keep_largest = 0;  ///< so many are kept; 0: all
  double min_mm3 = 0;             ///< smaller ones are not kept
  /// Rows of the result, at most, and the bytes that the caller takes for one, which count against
  /// the memory limit.
  std::size_t max_rows = std::numeric_limits<std::size_t>::max();
  std::uint64_t bytes_per_row = 0;
};

struct ComponentRow {
  std::int64_t label = 1;  ///< from 1, the largest component first
  std::uint64_t voxels = 0;
  std::optional<double> mm3;  ///< nothing, as all in mm, where the spacing is not known
  Point3 centroid{};          ///< in index space
  std::optional<Point3> centroid_mm;
  Box box;
};

struct ComponentsResult {
  VolumeDescription volume;  ///< that of the mask
  std::size_t found = 0;
  std::size_t kept = 0;
  std::vector<ComponentRow> rows = {};  ///< of those kept, the largest ones
  std::uint64_t file_bytes = 0;         ///< of the label map; 0 where none is written
};

/// The components of a mask and the label map of those kept, in memory.
struct LabeledMask {
  ComponentsResult table;
  LabelTree labels;
  VolumeDescription volume;  ///< that the file of the label map would have
};

/// What `components` writes.
/// volume   that the mask is of
/// options  their input names the mask in errors
/// Throws  as components does before it writes, opening apart
LabeledMask labeled_components(const MaskTree& mask, const VolumeDescription& volume,
                               const ComponentsOptions& options, const TaskContext& context);

/// Finds the components of a mask, and writes those kept as labels 1, 2, ... by their rows.
/// Throws  as open_mask, Components, require_computed and build_file; Error{invalid_argument} for a
///         smallest volume where the spacing is not known; Error{limit_exceeded} when the rows take
///         more than the memory limit
/// Memory  that of the mask, of Components and of the rows
ComponentsResult components(const ComponentsOptions& options, const TaskContext& context);

}  // namespace octavo
