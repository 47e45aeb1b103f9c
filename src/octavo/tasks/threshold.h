// A mask, or a label map of classes, from the values of a volume.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"
#include "octavo/tasks/value_ranges.h"

namespace octavo {

/// Values that get a label.
struct ValueClass {
  std::int64_t label = 1;  ///< 1 to 255
  AskedRange range;
};

struct ThresholdOptions {
  std::string input;  ///< an .8vo file or a URL of one
  Output output{};
  /// Ranges of the one label 1; they add up with the tissues.
  std::vector<AskedRange> ranges{};
  std::vector<std::string> tissues{};
  AskedLabels labels{};  ///< of a label map; they add up with the ranges
  /// In place of both: a label map. Where classes overlap the one named first counts.
  std::vector<ValueClass> classes{};
  bool is_stored = false;  ///< ranges are stored values instead of real ones
};

struct LabelVolume {
  std::int64_t label = 1;
  std::uint64_t voxels = 0;
};

struct ThresholdResult {
  VolumeDescription volume;          ///< that the values came from
  std::vector<LabelVolume> objects;  ///< that have voxels; of a mask always label 1
  std::uint64_t file_bytes = 0;
};

/// The planes that `threshold` writes: of one mask, or of classes.
/// Throws  as threshold does before it writes, the name of the output apart
ComputedVolume threshold_planes(const ThresholdOptions& options, const TaskContext& context);

/// The mask that `threshold` writes, in memory. Bricks whose minimum and maximum decide are not
/// decoded. Warns of an empty mask.
/// options  without classes; their input names `reader` in errors
/// Throws  as threshold does before it writes; Error{invalid_argument} for classes
/// Memory  that of the mask
ComputedMask threshold_mask(const FileReader& reader, const ThresholdOptions& options,
                            const TaskContext& context);

/// Writes the voxels whose values lie in the ranges. Bricks whose minimum and maximum decide are
/// not decoded. Warns of an empty mask.
/// Throws  as open_volume, require_computed, mask_of_file and build_file; Error{invalid_argument}
///         without any range, label or class, for a label out of range, for tissues where values
///         are not in HU
/// Memory  that of the mask; of classes that of a build
ThresholdResult threshold(const ThresholdOptions& options, const TaskContext& context);

}  // namespace octavo
