#include "octavo/ops/measure/region_sums.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

void set_mean(const RegionSums& sums, std::uint64_t count, const FileReader& grey,
              GreyStatistics& result) {
  const auto voxels = static_cast<long double>(count);
  if (!is_integer(grey.description().type)) {
    const long double sum = sums.floats.sum();
    result.mean = static_cast<double>(sum / voxels);
    result.sum = static_cast<double>(sum);
    result.deviation =
        static_cast<double>(std::sqrt(sums.floats.squared_distances(count)) / voxels);
    return;
  }
  const auto first = static_cast<long double>(grey.range().min);
  const auto sum = static_cast<long double>(sums.whole_sum);
  const auto squares = static_cast<long double>(sums.whole_squares);
  const long double mean = sum / voxels;
  result.mean = static_cast<double>(mean + first);
  result.sum = static_cast<double>(sum + voxels * first);
  result.deviation =
      static_cast<double>(std::sqrt(std::max(0.0L, squares / voxels - mean * mean)));
}

GreyStatistics grey_of(const RegionSums& sums, const FileReader& grey) {
  GreyStatistics result;
  result.not_finite = sums.not_finite;
  if (sums.moments.count == sums.not_finite) {
    result.minimum = result.maximum = result.mean = result.deviation = result.sum = std::nan("");
    return result;
  }
  result.minimum = sums.minimum;
  result.maximum = sums.maximum;
  set_mean(sums, sums.moments.count - sums.not_finite, grey, result);
  return result;
}

}  // namespace

void RegionSums::add(const RegionSums& other) {
  moments.add(other.moments);
  surface += other.surface;
  not_finite += other.not_finite;
  minimum = std::min(minimum, other.minimum);
  maximum = std::max(maximum, other.maximum);
  whole_sum += other.whole_sum;
  whole_squares += other.whole_squares;
  floats.add(other.floats);
}

RegionMeasure measured_by(std::int64_t label, const RegionSums& sums, const FileReader* grey) {
  RegionMeasure region;
  region.label = label;
  region.voxel_count = sums.moments.count;
  region.surface_voxel_count = sums.surface;
  region.box = sums.moments.box;
  region.centroid = sums.moments.centroid();
  region.covariance = sums.moments.covariance();
  if (grey != nullptr) region.grey = grey_of(sums, *grey);
  return region;
}

}  // namespace octavo
