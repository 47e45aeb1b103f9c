// What the regions of a label map measure, and what a grey volume holds beneath them.
//
// Bricks are taken in file order. A brick of one label among bricks of the same label, over grey
// voxels of one value, is settled from the index; others are decoded once, run by run along x.
// Sums are exact, so the result does not depend on the number of threads, nor on that of the parts
// in which a volume is measured.
//
// Source  thesis 1.2
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/core/work_part.h"
#include "octavo/file/reader.h"
#include "octavo/ops/measure/region_sums.h"

namespace octavo {

/// The spread of a region along its own axes, in mm and world space.
struct PrincipalAxes {
  std::array<double, 3> moments_mm2{};  ///< variances, the largest first
  std::array<Point3, 3> axes{};         ///< unit vectors, largest component positive
};

struct RegionMeasureOptions {
  std::vector<double> percentiles = {5, 25, 50, 75, 95};  ///< of 0 .. 100
  bool falls = false;  ///< the scale of grey values does: percentiles count from the largest down
  std::vector<std::int64_t> labels = {};  ///< only these, ascending; none: all but 0
};

/// The regions of all labels but 0 that are asked for and have voxels, ascending; bricks without
/// any of them are not decoded. Uses the threads of the calling task arena.
/// grey  nullptr, or a volume on the same grid
/// Throws what the readers throw, Error{cancelled}; Error{invalid_argument} for a grey volume in
///        place of labels, or of another size
/// Memory  64 bricks and their sums; per label 900 bytes, and per percentile 2 bytes a voxel of it
///         up to 64 KiB
/// Time    one pass over the voxels; with percentiles one more where the values of the volume span
///         over 2^13, and a third where they do 2^26
std::vector<RegionMeasure> measure_regions(const FileReader& labels, const FileReader* grey,
                                           const RegionMeasureOptions& options,
                                           Progress& progress);

/// What a part of a measurement found of a region.
struct PartOfRegion {
  RegionSums sums;
  /// Where percentiles are asked for, how many voxels have which value, by its ValueKeys.
  std::map<std::uint64_t, std::uint64_t> values = {};
};
using PartOfRegions = std::map<std::int64_t, PartOfRegion>;  ///< by label

/// What measure_regions sums over the layers of bricks of one part of the work.
/// Throws  as measure_regions; Error{invalid_argument} of field "percentiles" for those of values
///         that span over more than 2^16, Error{invalid_argument} for a part that cannot be
/// Memory  as measure_regions, 600 bytes per label, and 48 bytes for each value of each region
/// Time    a share of that of measure_regions; two passes where values span over 2^13
PartOfRegions measure_part(const FileReader& labels, const FileReader* grey,
                           const RegionMeasureOptions& options, const WorkPart& part,
                           Progress& progress);

/// Adds what one more part found.
void add_part(const PartOfRegions& part, PartOfRegions& all);

/// What measure_regions gives, of all parts added up.
std::vector<RegionMeasure> joined_regions(const PartOfRegions& all, const FileReader* grey,
                                          const RegionMeasureOptions& options);

/// The principal axes of a region on a grid.
PrincipalAxes principal_axes(const RegionMeasure& region, const Geometry& geometry);

}  // namespace octavo
