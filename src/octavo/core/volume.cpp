#include "octavo/core/volume.h"

#include <cmath>
#include <limits>

namespace octavo {

bool is_valid(const Rescale& rescale, VoxelType type) noexcept {
  constexpr double kHighest = std::numeric_limits<float>::max();
  double low = -kHighest;
  double high = kHighest;
  if (is_integer(type)) {
    const ValueRange range = value_range(type);
    low = static_cast<double>(range.min);
    high = static_cast<double>(range.max);
  }
  return rescale.slope != 0 && std::isfinite(rescale.to_real(low)) &&
         std::isfinite(rescale.to_real(high));
}

std::uint64_t plane_bytes(const VolumeDescription& description) {
  return static_cast<std::uint64_t>(description.size.x * description.size.y *
                                    bytes_per_voxel(description.type));
}

}  // namespace octavo
