#include "octavo/ops/morphometry/surface_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "octavo/core/vectors.h"
#include "octavo/ops/morphometry/slab_sums.h"

namespace octavo {

namespace {

constexpr std::int64_t kShapeReach = 3;  // of an average, to each side
constexpr std::int64_t kFieldRim = 2;    // planes of averages beside those that faces stand in

/// The planes of a slab, with the averages of the mask around them.
class ShapeSlab {
 public:
  ShapeSlab(const MaskTree& mask, const MaskTree* region, const Point3& spacing_mm,
            std::int64_t begin, std::int64_t end)
      : size_(mask.size()),
        plane_(size_.x * size_.y),
        spacing_(spacing_mm),
        begin_(begin),
        end_(end),
        shown_end_(std::min(end + 1, size_.z)),
        field_begin_(std::max<std::int64_t>(begin - kFieldRim, 0)),
        field_end_(std::min(shown_end_ + kFieldRim, size_.z)) {
    const double volume = spacing_[0] * spacing_[1] * spacing_[2];
    for (std::size_t a = 0; a < 3; ++a) face_mm2_[a] = volume / spacing_[a];
    fill_field(mask);
    if (region != nullptr) {
      region_.resize(static_cast<std::size_t>((shown_end_ - begin_) * plane_));
      fill_voxels(*region, {{0, 0, begin_}, {size_.x, size_.y, shown_end_}}, region_.data());
    }
  }

  SurfaceShape measure() const {
    SurfaceShape sums;
    for (std::int64_t z = begin_; z < end_; ++z) {
      for (std::int64_t y = 0; y < size_.y; ++y) {
        for (std::int64_t x = 0; x < size_.x; ++x) add_voxel({x, y, z}, sums);
      }
    }
    return sums;
  }

 private:
  void fill_field(const MaskTree& mask) {
    const std::int64_t lo = std::max<std::int64_t>(field_begin_ - kShapeReach, 0);
    const std::int64_t hi = std::min(field_end_ + kShapeReach, size_.z);
    std::vector<std::uint8_t> inside(static_cast<std::size_t>((hi - lo) * plane_));
    fill_voxels(mask, {{0, 0, lo}, {size_.x, size_.y, hi}}, inside.data());
    const auto* const shown = inside.data() + (begin_ - lo) * plane_;
    inside_.assign(shown, shown + (shown_end_ - begin_) * plane_);

    // Sums of 7 x 7 in each plane, then of 7 planes; beyond the border voxels repeat.
    std::vector<std::uint8_t> rows(static_cast<std::size_t>(plane_));
    for (std::int64_t z = lo; z < hi; ++z) {
      std::uint8_t* const voxels = inside.data() + (z - lo) * plane_;
      for (std::int64_t y = 0; y < size_.y; ++y) {
        sum_row(voxels + y * size_.x, rows.data() + y * size_.x);
      }
      std::fill(voxels, voxels + plane_, std::uint8_t{0});
      for (std::int64_t y = 0; y < size_.y; ++y) {
        for (std::int64_t d = -kShapeReach; d <= kShapeReach; ++d) {
          const std::int64_t from = std::clamp<std::int64_t>(y + d, 0, size_.y - 1);
          add_row(rows.data() + from * size_.x, voxels + y * size_.x, size_.x);
        }
      }
    }
    field_.assign(static_cast<std::size_t>((field_end_ - field_begin_) * plane_), 0);
    for (std::int64_t z = field_begin_; z < field_end_; ++z) {
      for (std::int64_t d = -kShapeReach; d <= kShapeReach; ++d) {
        const std::int64_t from = std::clamp<std::int64_t>(z + d, 0, size_.z - 1);
        add_row(inside.data() + (from - lo) * plane_, field_.data() + (z - field_begin_) * plane_,
                plane_);
      }
    }
  }

  void sum_row(const std::uint8_t* row, std::uint8_t* sums) const {
    const auto at = [&](std::int64_t x) {
      return row[std::clamp<std::int64_t>(x, 0, size_.x - 1)];
    };
    int sum = 0;
    for (std::int64_t x = -kShapeReach; x < kShapeReach; ++x) sum += at(x);
    for (std::int64_t x = 0; x < size_.x; ++x) {
      sum += at(x + kShapeReach);
      sums[x] = static_cast<std::uint8_t>(sum);
      sum -= at(x - kShapeReach);
    }
  }

  template <class From, class To>
  static void add_row(const From* from, To* to, std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) to[i] = static_cast<To>(to[i] + from[i]);
  }

  std::size_t shown_place(const Index3& p) const {
    return static_cast<std::size_t>((p.z - begin_) * plane_ + p.y * size_.x + p.x);
  }

  double field_at(const Index3& p) const {
    return field_[static_cast<std::size_t>((p.z - field_begin_) * plane_ + p.y * size_.x + p.x)];
  }

  /// The voxels beside one along an axis, where there are any, and how far they lie apart.
  struct Beside {
    Index3 before;
    Index3 behind;
    double apart_mm;
  };
  Beside beside(const Index3& p, int axis) const {
    Beside both{p, p, 0};
    both.before[axis] = std::max<std::int64_t>(p[axis] - 1, 0);
    both.behind[axis] = std::min(p[axis] + 1, size_[axis] - 1);
    const auto steps = static_cast<double>(both.behind[axis] - both.before[axis]);
    both.apart_mm = std::max(steps, 1.0) * spacing_[static_cast<std::size_t>(axis)];
    return both;
  }

  Point3 gradient(const Index3& p) const {
    Point3 g{};
    for (int axis = 0; axis < 3; ++axis) {
      const Beside both = beside(p, axis);
      g[static_cast<std::size_t>(axis)] =
          (field_at(both.behind) - field_at(both.before)) / both.apart_mm;
    }
    return g;
  }

  /// A part of the unit normal, outward.
  double normal(const Index3& p, int axis) const {
    const Point3 g = gradient(p);
    const double length = std::sqrt(dot(g, g));
    return length > 0 ? -g[static_cast<std::size_t>(axis)] / length : 0;
  }

  double divergence(const Index3& p) const {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const Beside both = beside(p, axis);
      sum += (normal(both.behind, axis) - normal(both.before, axis)) / both.apart_mm;
    }
    return sum;
  }

  bool is_in_region(const Index3& p) const {
    return region_.empty() || region_[shown_place(p)] != 0;
  }

  void add_voxel(const Index3& p, SurfaceShape& sums) const {
    const bool is_inside = inside_[shown_place(p)] != 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double face = face_mm2_[static_cast<std::size_t>(axis)];
      if (is_inside && is_in_region(p)) {
        if (p[axis] == 0) sums.cut_mm2 += face;
        if (p[axis] == size_[axis] - 1) sums.cut_mm2 += face;
      }
      Index3 q = p;
      if (++q[axis] == size_[axis]) continue;
      const bool is_next_inside = inside_[shown_place(q)] != 0;
      if (!is_in_region(p) || !is_in_region(q)) {
        const bool is_cut = is_in_region(p) ? is_inside : is_in_region(q) && is_next_inside;
        if (is_cut) sums.cut_mm2 += face;
      } else if (is_inside != is_next_inside) {
        add_face(p, q, axis, sums);
      }
    }
  }

  void add_face(const Index3& p, const Index3& q, int axis, SurfaceShape& sums) const {
    const auto a = static_cast<std::size_t>(axis);
    Point3 g = scaled(sum(gradient(p), gradient(q)), 0.5);
    g[a] = (field_at(q) - field_at(p)) / spacing_[a];
    const double length = std::sqrt(dot(g, g));
    const double share = length > 0 ? std::abs(g[a]) / length : 1;
    const double patch = share * face_mm2_[a];
    sums.area_mm2 += patch;
    sums.growth_mm += patch * 0.5 * (divergence(p) + divergence(q));
  }

  Size3 size_;
  std::int64_t plane_;
  Point3 spacing_;
  std::int64_t begin_;
  std::int64_t end_;
  std::int64_t shown_end_;  // faces between planes need one more
  std::int64_t field_begin_;
  std::int64_t field_end_;
  Point3 face_mm2_{};
  std::vector<std::uint8_t> inside_;
  std::vector<std::uint8_t> region_;
  std::vector<std::uint16_t> field_;
};

}  // namespace

SurfaceShape& SurfaceShape::operator+=(const SurfaceShape& other) {
  area_mm2 += other.area_mm2;
  growth_mm += other.growth_mm;
  cut_mm2 += other.cut_mm2;
  return *this;
}

SurfaceShape surface_shape(const MaskTree& mask, const MaskTree* region, const Point3& spacing_mm,
                           Progress& progress) {
  return sum_of_slabs<SurfaceShape>(
      mask.size().z, progress, [&](std::int64_t begin, std::int64_t end) {
        return ShapeSlab(mask, region, spacing_mm, begin, end).measure();
      });
}

}  // namespace octavo
