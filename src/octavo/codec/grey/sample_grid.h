// A small volume with margins, the work space of the grey codec.
//
//      x:  [8 left | up to 64 samples | 8 right]      80 samples per row
//      y:  2 rows above, up to 64, 2 below;  z likewise
//
// Margins at the border of a brick repeat the nearest sample, so that neighborhoods need no case
// there. Beyond the inner faces of a part (grey_parts.h) they hold the means around it.
// A grid over 64^3 int16 samples takes 740 kB.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>

#include "octavo/core/box.h"

namespace octavo {

inline constexpr std::int64_t kBrickSide = 64;

/// Faces of a box: bit 2 a stands for the one at the low end of axis a, bit 2 a + 1 for the high
/// end.
using Faces = unsigned;
inline constexpr Faces kAllFaces = 63;
constexpr bool has_low_face(Faces faces, int axis) { return (faces >> 2 * axis & 1) != 0; }
constexpr bool has_high_face(Faces faces, int axis) { return (faces >> 2 * axis & 2) != 0; }

/// How much of the margins is looked at.
enum class Margins {
  near,  ///< two samples deep
  all
};

struct FreeRoom {
  void operator()(void* room) const noexcept { std::free(room); }
};
template <class T>
using Room = std::unique_ptr<T[], FreeRoom>;

/// Room for numbers, 0 where none was written: vectors reach beyond the ends of rows. Of large
/// room, the system gives what is written to, so that small parts take little of it.
template <class T>
Room<T> cleared_room(std::size_t count) {
  static_assert(std::is_arithmetic_v<T>);
  auto* const room = static_cast<T*>(std::calloc(count, sizeof(T)));
  if (room == nullptr) throw std::bad_alloc();
  return Room<T>(room);
}

template <class Sample>
class SampleGrid {
 public:
  static constexpr std::int64_t kMarginX = 8;
  static constexpr std::int64_t kMargin = 2;
  static constexpr std::int64_t kRow = kBrickSide + 2 * kMarginX;
  static constexpr std::int64_t kPlane = kRow * (kBrickSide + 2 * kMargin);

  SampleGrid()
      : samples_(cleared_room<Sample>(
            static_cast<std::size_t>(kPlane * (kBrickSide + 2 * kMargin) + 32))) {}

  const Size3& size() const { return size_; }
  void set_size(const Size3& size) { size_ = size; }

  /// Sample (0, y, z); y and z may reach 2 into the margins, x 8.
  Sample* row(std::int64_t y, std::int64_t z) {
    return samples_.get() + (z + kMargin) * kPlane + (y + kMargin) * kRow + kMarginX;
  }
  const Sample* row(std::int64_t y, std::int64_t z) const {
    return const_cast<SampleGrid*>(this)->row(y, z);
  }

  /// Repeats the border samples into the margins beyond some faces.
  void fill_margins(Margins reach = Margins::all, Faces faces = kAllFaces) {
    if (reach == Margins::all) fill_margins<kMarginX, kMargin>(faces);
    else fill_margins<2, 2>(faces);
  }

  void swap(SampleGrid& other) noexcept {
    samples_.swap(other.samples_);
    std::swap(size_, other.size_);
  }

 private:
  template <std::int64_t kReachX, std::int64_t kReach>
  void fill_margins(Faces faces) {
    for (std::int64_t z = 0; z < size_.z; ++z) {
      for (std::int64_t y = 0; y < size_.y; ++y) fill_row_margins<kReachX>(row(y, z), faces);
      for (std::int64_t k = 1; k <= kReach; ++k) {
        if (has_low_face(faces, 1)) copy_row(-k, z, 0, z);
        if (has_high_face(faces, 1)) copy_row(size_.y - 1 + k, z, size_.y - 1, z);
      }
    }
    for (std::int64_t k = 1; k <= kReach; ++k) {
      for (std::int64_t y = -kReach; y < size_.y + kReach; ++y) {
        if (has_low_face(faces, 2)) copy_row(y, -k, y, 0);
        if (has_high_face(faces, 2)) copy_row(y, size_.z - 1 + k, y, size_.z - 1);
      }
    }
  }
  template <std::int64_t kReachX>
  void fill_row_margins(Sample* samples, Faces faces) {
    for (std::int64_t i = 1; i <= kReachX; ++i) {
      if (has_low_face(faces, 0)) samples[-i] = samples[0];
      if (has_high_face(faces, 0)) samples[size_.x - 1 + i] = samples[size_.x - 1];
    }
  }
  void copy_row(std::int64_t to_y, std::int64_t to_z, std::int64_t y, std::int64_t z) {
    std::memcpy(row(to_y, to_z) - kMarginX, row(y, z) - kMarginX,
                static_cast<std::size_t>(size_.x + 2 * kMarginX) * sizeof(Sample));
  }

  Size3 size_;
  Room<Sample> samples_;
};

/// Repeats a row of `coarse` along `axis` into samples first .. last - 1 of row (y, z) of `fine`,
/// where an odd number along x may write one more.
template <class Sample>
void repeat_row(const SampleGrid<Sample>& coarse, SampleGrid<Sample>& fine, int axis,
                std::int64_t y, std::int64_t z, std::int64_t first, std::int64_t last) {
  const Sample* const in = coarse.row(axis == 1 ? y >> 1 : y, axis == 2 ? z >> 1 : z);
  Sample* const out = fine.row(y, z);
  if (axis != 0) {
    std::copy(in + first, in + last, out + first);
    return;
  }
  if ((first & 1) != 0) {
    out[first] = in[first >> 1];
    ++first;
  }
  // Of different grids: compilers make vectors of that.
  const Sample* __restrict const from = in + (first >> 1);
  Sample* __restrict const to = out + first;
  const std::int64_t count = (last - first + 1) >> 1;
  for (std::int64_t i = 0; i < count; ++i) {
    to[2 * i] = from[i];
    to[2 * i + 1] = from[i];
  }
}

/// Fills `fine` with `coarse` repeated along `axis`, margins included; `fine_size` has up to twice
/// the samples there.
template <class Sample>
void repeat_along(const SampleGrid<Sample>& coarse, SampleGrid<Sample>& fine, int axis,
                  const Size3& fine_size) {
  constexpr std::int64_t kX = SampleGrid<Sample>::kMarginX;
  constexpr std::int64_t kYZ = SampleGrid<Sample>::kMargin;
  fine.set_size(fine_size);
  for (std::int64_t z = -kYZ; z < fine_size.z + kYZ; ++z) {
    for (std::int64_t y = -kYZ; y < fine_size.y + kYZ; ++y) {
      repeat_row(coarse, fine, axis, y, z, -kX, fine_size.x + kX);
    }
  }
}

/// The same for the margins alone, those beyond `faces` at least. Near ones are those in front of
/// the faces: what lies beyond two of them is left as it is.
template <class Sample>
void repeat_margins_along(const SampleGrid<Sample>& coarse, SampleGrid<Sample>& fine, int axis,
                          Margins reach, Faces faces) {
  constexpr std::int64_t deep = SampleGrid<Sample>::kMargin;
  const bool is_near = reach == Margins::near;
  const std::int64_t wide = is_near ? deep : SampleGrid<Sample>::kMarginX;
  const std::int64_t beside = is_near ? 0 : wide;
  const Size3& size = fine.size();
  for (std::int64_t z = -deep; z < size.z + deep; ++z) {
    const bool is_plane_inside = z >= 0 && z < size.z;
    for (std::int64_t y = -deep; y < size.y + deep; ++y) {
      const bool is_row_inside = y >= 0 && y < size.y;
      if (is_near && !is_plane_inside && !is_row_inside) continue;
      if (!is_plane_inside || !is_row_inside) {
        repeat_row(coarse, fine, axis, y, z, -beside, size.x + beside);
        continue;
      }
      if (has_low_face(faces, 0)) repeat_row(coarse, fine, axis, y, z, -wide, 0);
      if (has_high_face(faces, 0)) {
        repeat_row(coarse, fine, axis, y, z, size.x, size.x + wide);
      }
    }
  }
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
