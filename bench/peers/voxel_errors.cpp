#include "bench/peers/voxel_errors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace octavo::bench {

VoxelErrors errors_of(const RawVolume& source, const RawVolume& decoded) {
  VoxelErrors errors;
  double sum = 0;
  with_voxel_type(source.type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t at = 0; at < source.voxels.size(); at += sizeof(T)) {
      T a, b;
      std::memcpy(&a, source.voxels.data() + at, sizeof(T));
      std::memcpy(&b, decoded.voxels.data() + at, sizeof(T));
      const auto error = std::abs(static_cast<std::int64_t>(a) - static_cast<std::int64_t>(b));
      errors.max_error = std::max(errors.max_error, error);
      sum += static_cast<double>(error) * static_cast<double>(error);
    }
  });
  errors.mean_square = sum / static_cast<double>(source.size.voxel_count());
  return errors;
}

double psnr_db(const RawVolume& source, const VoxelErrors& errors) {
  if (errors.mean_square == 0) return std::numeric_limits<double>::infinity();
  const auto peak = static_cast<double>(source.range.max - source.range.min);
  return 10 * std::log10(peak * peak / errors.mean_square);
}

}  // namespace octavo::bench
