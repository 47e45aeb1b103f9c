#include "octavo/codec/brick_codec.h"

#include <cstring>

namespace octavo {

void BrickCodec::decode_box(const BrickShape& shape, VoxelType type, const ValueRange& range,
                            std::span<const ByteSpan> segments, const LevelBox& wanted) const {
  const Size3& all = shape.size[static_cast<std::size_t>(wanted.level)];
  const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(type));
  Bytes voxels(static_cast<std::size_t>(all.voxel_count()) * voxel_bytes);
  decode(shape, type, range, segments, wanted.level, voxels.data());
  const Box& box = wanted.box;
  const Size3 size = box.size();
  const auto place = [&](std::int64_t at) { return static_cast<std::size_t>(at) * voxel_bytes; };
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      const std::int64_t from = ((z + box.lo.z) * all.y + y + box.lo.y) * all.x + box.lo.x;
      const std::int64_t to = z * wanted.out.plane_stride + y * wanted.out.row_stride;
      std::memcpy(static_cast<std::byte*>(wanted.out.voxels) + place(to),
                  voxels.data() + place(from), place(size.x));
    }
  }
}

}  // namespace octavo
