#include "octavo/core/volume.h"

namespace octavo {

std::uint64_t plane_bytes(const VolumeDescription& description) {
  return static_cast<std::uint64_t>(description.size.x * description.size.y *
                                    bytes_per_voxel(description.type));
}

}  // namespace octavo
