// A small volume with margins, the work space of the grey codec.
//
//      x:  [8 left | up to 64 samples | 8 right]      80 samples per row
//      y:  2 rows above, up to 64, 2 below;  z likewise
//
// Margins repeat the nearest sample, so that neighborhoods need no case at the border of a brick.
// A grid over 64^3 int16 samples takes 740 kB.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "octavo/core/box.h"

namespace octavo {

inline constexpr std::int64_t kBrickSide = 64;

template <class Sample>
class SampleGrid {
 public:
  static constexpr std::int64_t kMarginX = 8;
  static constexpr std::int64_t kMargin = 2;
  static constexpr std::int64_t kRow = kBrickSide + 2 * kMarginX;
  static constexpr std::int64_t kPlane = kRow * (kBrickSide + 2 * kMargin);

  SampleGrid() : samples_(static_cast<std::size_t>(kPlane * (kBrickSide + 2 * kMargin) + 32)) {}

  const Size3& size() const { return size_; }
  void set_size(const Size3& size) { size_ = size; }

  /// Sample (0, y, z); y and z may reach 2 into the margins, x 8.
  Sample* row(std::int64_t y, std::int64_t z) {
    return samples_.data() + (z + kMargin) * kPlane + (y + kMargin) * kRow + kMarginX;
  }
  const Sample* row(std::int64_t y, std::int64_t z) const {
    return const_cast<SampleGrid*>(this)->row(y, z);
  }

  /// Repeats the border samples into the margins.
  void fill_margins() { fill_margins<kMarginX, kMargin>(); }
  /// The same for those margins alone that lie next to samples.
  void fill_nearest_margins() { fill_margins<1, 1>(); }

  void swap(SampleGrid& other) noexcept {
    samples_.swap(other.samples_);
    std::swap(size_, other.size_);
  }

 private:
  template <std::int64_t kReachX, std::int64_t kReach>
  void fill_margins() {
    for (std::int64_t z = 0; z < size_.z; ++z) {
      for (std::int64_t y = 0; y < size_.y; ++y) fill_row_margins<kReachX>(row(y, z));
      for (std::int64_t k = 1; k <= kReach; ++k) {
        copy_row(-k, z, 0, z);
        copy_row(size_.y - 1 + k, z, size_.y - 1, z);
      }
    }
    for (std::int64_t k = 1; k <= kReach; ++k) {
      for (std::int64_t y = -kReach; y < size_.y + kReach; ++y) {
        copy_row(y, -k, y, 0);
        copy_row(y, size_.z - 1 + k, y, size_.z - 1);
      }
    }
  }
  template <std::int64_t kReachX>
  void fill_row_margins(Sample* samples) {
    for (std::int64_t i = 1; i <= kReachX; ++i) {
      samples[-i] = samples[0];
      samples[size_.x - 1 + i] = samples[size_.x - 1];
    }
  }
  void copy_row(std::int64_t to_y, std::int64_t to_z, std::int64_t y, std::int64_t z) {
    std::memcpy(row(to_y, to_z) - kMarginX, row(y, z) - kMarginX,
                static_cast<std::size_t>(size_.x + 2 * kMarginX) * sizeof(Sample));
  }

  Size3 size_;
  std::vector<Sample> samples_;
};

/// Fills `fine` with `coarse` repeated along `axis`; `fine_size` has up to twice the samples there.
template <class Sample>
void repeat_along(const SampleGrid<Sample>& coarse, SampleGrid<Sample>& fine, int axis,
                  const Size3& fine_size) {
  fine.set_size(fine_size);
  for (std::int64_t z = 0; z < fine_size.z; ++z) {
    for (std::int64_t y = 0; y < fine_size.y; ++y) {
      const Sample* in = coarse.row(axis == 1 ? y / 2 : y, axis == 2 ? z / 2 : z);
      Sample* out = fine.row(y, z);
      if (axis == 0) {
        for (std::int64_t x = 0; x < coarse.size().x; ++x) out[2 * x] = out[2 * x + 1] = in[x];
      } else {
        std::memcpy(out, in, static_cast<std::size_t>(fine_size.x) * sizeof(Sample));
      }
    }
  }
  fine.fill_margins();
}

/// Gives `to` the margins of `from`, a grid of the same size.
template <class Sample>
void copy_margins(const SampleGrid<Sample>& from, SampleGrid<Sample>& to) {
  constexpr std::int64_t kX = SampleGrid<Sample>::kMarginX;
  constexpr std::int64_t kYZ = SampleGrid<Sample>::kMargin;
  const Size3& size = from.size();
  for (std::int64_t z = -kYZ; z < size.z + kYZ; ++z) {
    for (std::int64_t y = -kYZ; y < size.y + kYZ; ++y) {
      const Sample* in = from.row(y, z);
      Sample* out = to.row(y, z);
      const bool is_inside = y >= 0 && y < size.y && z >= 0 && z < size.z;
      std::copy(in - kX, in + (is_inside ? 0 : size.x), out - kX);
      std::copy(in + size.x, in + size.x + kX, out + size.x);
    }
  }
}

/// Copies the samples that have no partner along `axis`: the last ones of an odd size.
template <class Sample>
void copy_lone(const SampleGrid<Sample>& coarse, SampleGrid<Sample>& fine, int axis) {
  const Size3& fine_size = fine.size();
  if (fine_size[axis] % 2 == 0) return;
  Box lone{{0, 0, 0}, {fine_size.x, fine_size.y, fine_size.z}};
  lone.lo[axis] = fine_size[axis] - 1;
  for (std::int64_t z = lone.lo.z; z < lone.hi.z; ++z) {
    for (std::int64_t y = lone.lo.y; y < lone.hi.y; ++y) {
      const Sample* in = coarse.row(axis == 1 ? y / 2 : y, axis == 2 ? z / 2 : z);
      Sample* out = fine.row(y, z);
      for (std::int64_t x = lone.lo.x; x < lone.hi.x; ++x) out[x] = in[axis == 0 ? x / 2 : x];
    }
  }
}

}  // namespace octavo
