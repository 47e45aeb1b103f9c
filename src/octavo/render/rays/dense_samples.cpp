#include "octavo/render/rays/dense_samples.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

namespace octavo {

namespace {

/// Row under row, so that samples side by side are joined at once.
template <class T>
SampleRange range_in(const T* samples, const Size3& size, const Box& box) {
  const auto width = static_cast<std::size_t>(box.size().x);
  std::vector<T> low(width, std::numeric_limits<T>::max());
  std::vector<T> high(width, std::numeric_limits<T>::lowest());
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const T* const row = samples + (z * size.y + y) * size.x + box.lo.x;
      for (std::size_t x = 0; x < width; ++x) {
        if constexpr (std::is_floating_point_v<T>) {
          if (!std::isfinite(row[x])) continue;
        }
        low[x] = std::min(low[x], row[x]);
        high[x] = std::max(high[x], row[x]);
      }
    }
  }
  SampleRange range = kNoSamples;
  for (std::size_t x = 0; x < width; ++x) {
    if (low[x] > high[x]) continue;  // no finite one
    range = joined_range(range, {static_cast<double>(low[x]), static_cast<double>(high[x])});
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
