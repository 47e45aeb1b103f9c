// What regions measure, by name, as every face shows it.
#pragma once

#include <string>
#include <vector>

#include "octavo/tasks/components.h"
#include "octavo/tasks/measure.h"
#include "octavo/tasks/result_facts.h"

namespace octavo {

/// What belongs together: one value of an object, and a column for each number of it in a table.
struct RegionField {
  Fact fact;
  std::string columns;  ///< "box_[x y z]_[lo hi]" is called box_x_lo, box_x_hi, box_y_lo, ...
};
using RegionRow = std::vector<RegionField>;

/// Positions are x, y, z: in mm in LPS, else in voxels; a box has both ends of each axis,
/// half-open.
RegionRow region_row(const MeasuredRegion& measured, const MeasureResult& result);
RegionRow region_row(const ComponentRow& component);

/// As an object of JSON has them.
Facts facts_of(const RegionRow& row);

/// As CSV and Python have them: single values. What is not known has its columns all the same.
Facts columns_of(const RegionRow& row);

}  // namespace octavo
