#include "octavo/ops/label/label_block.h"

namespace octavo {

LabelBlock::LabelBlock(const FileReader& reader, const Box& box) {
  const Size3& volume = reader.levels().size(0);
  const Box wide{{box.lo.x - 1, box.lo.y - 1, box.lo.z - 1},
                 {box.hi.x + 1, box.hi.y + 1, box.hi.z + 1}};
  const Box part = intersection(wide, box_of(volume));
  const Size3 size = wide.size();
  row_ = size.x;
  plane_ = size.x * size.y;
  labels_.assign(static_cast<std::size_t>(size.voxel_count()), kOutside);
  with_voxel_type(reader.description().type, [&](auto id) {
    using T = typename decltype(id)::type;
    const Size3 read = part.size();
    std::vector<T> voxels(static_cast<std::size_t>(read.voxel_count()));
    reader.read(part, 0, voxels.data());
    for (std::int64_t z = 0; z < read.z; ++z) {
      for (std::int64_t y = 0; y < read.y; ++y) {
        const T* const from = voxels.data() + (z * read.y + y) * read.x;
        std::int64_t* const to =
            row(y + part.lo.y - box.lo.y, z + part.lo.z - box.lo.z) + part.lo.x - box.lo.x;
        for (std::int64_t x = 0; x < read.x; ++x) to[x] = static_cast<std::int64_t>(from[x]);
      }
    }
  });
}

std::uint64_t LabelBlock::surface_of(std::int64_t lo, std::int64_t hi, std::int64_t y,
                                     std::int64_t z) {
  const std::int64_t* const here = row(y, z);
  const std::int64_t label = here[lo];
  std::uint64_t count = 0;
  for (std::int64_t x = lo; x < hi; ++x) {
    const bool is_surface = here[x - 1] != label || here[x + 1] != label ||
                            here[x - row_] != label || here[x + row_] != label ||
                            here[x - plane_] != label || here[x + plane_] != label;
    count += is_surface ? 1 : 0;
  }
  return count;
}

}  // namespace octavo
