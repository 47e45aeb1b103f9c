#include "octavo/render/rays/dense_samples.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace octavo {

namespace {

template <class T>
SampleRange range_in(const T* samples, const Size3& size, const Box& box) {
  SampleRange range = kNoSamples;
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const T* const row = samples + (z * size.y + y) * size.x;
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
        const auto value = static_cast<double>(row[x]);
        if (std::isfinite(value)) range = joined_range(range, {value, value});
      }
    }
  }
  return range;
}

}  // namespace

DenseSamples::DenseSamples(const void* samples, VoxelType type, const Size3& size, int brick_side)
    : samples_(samples), type_(type), size_(size) {
  bricks_ = BrickRanges(size, {brick_side, brick_side, brick_side}, [&](const Index3& brick) {
    const Index3 lo{brick.x * brick_side, brick.y * brick_side, brick.z * brick_side};
    const Box box = intersection(
        box_of(size), {lo, {lo.x + brick_side, lo.y + brick_side, lo.z + brick_side}});
    return with_voxel_type(type, [&](auto id) {
      return range_in(static_cast<const typename decltype(id)::type*>(samples), size, box);
    });
  });
  range_ = bricks_.within(box_of(size), {0, 0});
}

void DenseSamples::read(const Box& box, void* out) const {
  const std::int64_t bytes = bytes_per_voxel(type_);
  const auto row_bytes = static_cast<std::size_t>(box.size().x * bytes);
  auto* to = static_cast<std::byte*>(out);
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const std::int64_t from = ((z * size_.y + y) * size_.x + box.lo.x) * bytes;
      std::memcpy(to, static_cast<const std::byte*>(samples_) + from, row_bytes);
      to += row_bytes;
    }
  }
}

}  // namespace octavo
