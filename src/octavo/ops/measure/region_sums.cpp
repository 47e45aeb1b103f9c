#include "octavo/ops/measure/region_sums.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

/// The sum of the squares of the distances of integers from their mean, times their count: of whole
/// numbers, and rounded once.
long double squared_distances(__int128 sum, __int128 squares, std::uint64_t count) {
  using Bits = unsigned __int128;  // may overflow
  const auto all = static_cast<__int128>(count);
  // From the whole part of the mean, which leaves small numbers
  const __int128 mean = sum / all;
  const __int128 rest = sum % all;
  const auto about_mean = static_cast<__int128>(
      static_cast<Bits>(squares) - static_cast<Bits>(mean) * static_cast<Bits>(sum + rest));
  // all * about_mean - rest^2
  __int128 product;
  __int128 distances;
  if (!__builtin_mul_overflow(all, about_mean, &product) &&
      !__builtin_sub_overflow(product, rest * rest, &distances)) {
    return static_cast<long double>(std::max<__int128>(distances, 0));
  }
  // So large that the square of less than the count is a small part of it
  const auto fraction = static_cast<long double>(rest);
  return std::max(0.0L, static_cast<long double>(all) * static_cast<long double>(about_mean) -
                            fraction * fraction);
}

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
  const long double mean = sum / voxels;
  result.mean = static_cast<double>(mean + first);
  result.sum = static_cast<double>(sum + voxels * first);
  result.deviation =
      static_cast<double>(
          std::sqrt(squared_distances(sums.whole_sum, sums.whole_squares, count)) / voxels);
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
