// Volumes, places, shapes and grey values of the regions of a label map.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"
#include "octavo/core/volume.h"
#include "octavo/core/work_part.h"
#include "octavo/ops/measure/measure.h"
#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct MeasureOptions {
  std::string labels;  ///< a label map
  std::string grey;    ///< the volume to measure under the labels, on the same grid; or nothing
  std::vector<double> percentiles = {5, 25, 50, 75, 95};  ///< of 0 .. 100
  AskedLabels asked = {};                                 ///< only these; with none: all but 0
};

/// What a region measures in mm.
struct RegionInMm {
  double mm3 = 0;
  Point3 centroid{};
  PrincipalAxes axes;
  std::optional<double> integrated;  ///< grey values times mm3
};

struct MeasuredRegion {
  RegionMeasure region;             ///< in voxels; grey values are real ones, percentiles rise
  std::optional<RegionInMm> in_mm;  ///< nothing where the spacing is not known
};

struct MeasureResult {
  std::vector<MeasuredRegion> regions;  ///< of the labels that have voxels, ascending
  std::vector<double> percentiles;      ///< that the grey statistics hold, ascending
  LabelNames names;                     ///< of the labels
  std::string unit;                     ///< of the grey values; empty where none is known
};

struct MeasurePartOptions {
  MeasureOptions measure;
  WorkPart part;
  Output output;  ///< what the part found
};

struct JoinMeasuredOptions {
  MeasureOptions measure;          ///< those of the parts
  std::vector<std::string> parts;  ///< what measure_volume_part wrote
};

/// Measures regions. Warns where the spacing is not known, and of labels without voxels that are
/// asked for.
/// Throws  as open_volume and measure_regions; Error{invalid_argument} for grey values in place of
///         labels, labels in place of grey values, grids that differ, percentiles out of range
/// Memory  as measure_regions, and 12 MiB per thread
MeasureResult measure(const MeasureOptions& options, const TaskContext& context);

/// Sums up the regions in the layers of bricks of one part, and writes that. Returns how many
/// regions it has met.
/// Throws  as measure, measure_part and write_part_result
std::size_t measure_volume_part(const MeasurePartOptions& options, const TaskContext& context);

/// What measure gives, every digit of it, of the parts of one measurement.
/// Throws  as measure and read_part_result; Error{invalid_argument} for parts that are missing,
///         there twice, or of other files, labels or percentiles
MeasureResult join_measured(const JoinMeasuredOptions& options, const TaskContext& context);

}  // namespace octavo
