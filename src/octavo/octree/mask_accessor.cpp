#include "octavo/octree/mask_accessor.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMinTableBytes = std::uint64_t{1} << 20;

std::uint64_t entries_along(std::int64_t size, int shift) {
  return static_cast<std::uint64_t>(((size - 1) >> shift) + 1);
}

std::uint64_t entry_count(const Size3& size, int shift) {
  return entries_along(size.x, shift) * entries_along(size.y, shift) *
         entries_along(size.z, shift);
}

}  // namespace

MaskAccessor::MaskAccessor(const MaskTree& mask)
    : mask_(mask),
      words_(mask.words().data()),
      width_(static_cast<std::uint64_t>(mask.size().x)),
      height_(static_cast<std::uint64_t>(mask.size().y)),
      depth_(static_cast<std::uint64_t>(mask.size().z)) {
  // The finest rank whose table is not too large
  const std::uint64_t most =
      std::max(kMinTableBytes, mask.memory_bytes()) / sizeof(std::uint32_t);
  const int top = mask.rank_count() - 1;
  while (rank_ < top && entry_count(mask.size(), shift_) > most) {
    ++rank_;
    shift_ += 2;
  }
  cubes_ = mask.cubes(rank_).data();
  if (mask.cubes(rank_).size() > std::numeric_limits<std::uint32_t>::max() - kFirstStored) {
    throw Error(ErrorKind::limit_exceeded, "a mask of too many cubes for a table");
  }
  columns_ = static_cast<std::int64_t>(entries_along(mask.size().x, shift_));
  rows_ = static_cast<std::int64_t>(entries_along(mask.size().y, shift_));
  table_.assign(entry_count(mask.size(), shift_), 0);

  // Entries of a box
  const Box volume = box_of(mask.size());
  const auto fill = [&](const Box& box, std::uint32_t entry) {
    const Box part = intersection(box, volume);
    for (std::int64_t z = part.lo.z >> shift_; z << shift_ < part.hi.z; ++z) {
      for (std::int64_t y = part.lo.y >> shift_; y << shift_ < part.hi.y; ++y) {
        const auto row = static_cast<std::size_t>((z * rows_ + y) * columns_);
        for (std::int64_t x = part.lo.x >> shift_; x << shift_ < part.hi.x; ++x) {
          table_[row + static_cast<std::size_t>(x)] = entry;
        }
      }
    }
  };
  // Stored cubes of the rank, and the full children of those above it.
  visit_items(mask, volume, [&](int rank, std::uint64_t place, const Index3& corner) {
    if (rank == rank_) {
      const std::int64_t side = child_side(rank + 1);
      fill({corner, {corner.x + side, corner.y + side, corner.z + side}},
           static_cast<std::uint32_t>(place) + kFirstStored);
    } else if (rank > rank_) {
      for (std::uint64_t full = mask.cubes(rank)[place].full; full != 0; full &= full - 1) {
        fill(child_box(corner, std::countr_zero(full), child_side(rank)), kFull);
      }
    }
  });
}

bool MaskAccessor::contains_below(std::uint32_t place, const Index3& voxel) const noexcept {
  const std::uint64_t code = interleave(voxel);
  const MaskCube* cube = cubes_ + place;
  for (int rank = rank_;; --rank) {
    const auto bit = static_cast<int>(code >> 6 * (rank + 1) & 63);
    if ((cube->mixed >> bit & 1) == 0) return (cube->full >> bit & 1) != 0;
    const std::uint64_t below = cube->place_of(bit);
    if (rank == 0) return (words_[below] >> (code & 63) & 1) != 0;
    cube = mask_.cubes(rank - 1).data() + below;
  }
}

}  // namespace octavo
