#include "octavo/ops/morphometry/surface_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/vectors.h"
#include "octavo/ops/morphometry/slab_sums.h"

namespace octavo {

namespace {

constexpr std::int64_t kShapeReach = 3;  // of an average, to each side

// Weights of voxels so far away; sums fit 16 bits. Even ones say best how a surface lies, but find
// none in what is thinner than half of their reach. Where the middle counts most, averages fall
// outward at the surface of anything. Near ones look past nothing, but follow the steps of voxels.
// Along voxels that are long beside the others all reach alike: one that reached as far would take
// in all of a structure, a nearer one would follow its steps.
using ShapeWeights = std::array<std::uint16_t, 4>;
enum ShapeField : std::size_t { kEven = 0, kPeaked = 1, kClosest = 2, kShapeFields = 3 };
constexpr std::array<ShapeWeights, kShapeFields> kShapeWeights = {
    {{1, 1, 1, 1}, {6, 5, 5, 4}, {6, 4, 1, 0}}};
constexpr ShapeWeights kLongWeights = {6, 5, 4, 0};
constexpr double kLong = 2;  // times the shortest side

// Near normals take the place of others where a face is less steep than a flat one, from all to
// none between these, and turned by more than 16 degrees, from none to all by 28: where structures
// meet, or lie so close that averages run into the next one. Plates and rods turn less, however
// thin. Chosen on random fields, plates, rods, balls, gyroids and crossing walls.
constexpr double kNearSteepness[] = {0.85, 1.0};
constexpr double kNearTurn[] = {0.96, 0.88};  // cosines

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
    const double shortest = std::min({spacing_[0], spacing_[1], spacing_[2]});
    for (std::size_t a = 0; a < 3; ++a) {
      face_mm2_[a] = volume / spacing_[a];
      for (const ShapeField which : {kEven, kPeaked, kClosest}) {
        const ShapeWeights& own = spacing_[a] >= kLong * shortest ? kLongWeights
                                                                  : kShapeWeights[which];
        weights_[which][a] = own;
        sums_[which] *= own[0] + 2 * (own[1] + own[2] + own[3]);
      }
    }
    fill_fields(mask);
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
  void fill_fields(const MaskTree& mask) {
    const std::int64_t lo = std::max<std::int64_t>(field_begin_ - kShapeReach, 0);
    const std::int64_t hi = std::min(field_end_ + kShapeReach, size_.z);
    std::vector<std::uint8_t> inside(static_cast<std::size_t>((hi - lo) * plane_));
    fill_voxels(mask, {{0, 0, lo}, {size_.x, size_.y, hi}}, inside.data());
    const auto* const shown = inside.data() + (begin_ - lo) * plane_;
    inside_.assign(shown, shown + (shown_end_ - begin_) * plane_);

    for (const ShapeField which : {kEven, kPeaked, kClosest}) fill_field(inside, lo, which);
  }

  /// Sums along rows, over rows of each plane, then over planes; beyond the border voxels repeat.
  void fill_field(const std::vector<std::uint8_t>& inside, std::int64_t lo, ShapeField which) {
    const auto weight = [&](std::size_t axis, std::int64_t away) {
      return weights_[which][axis][static_cast<std::size_t>(std::abs(away))];
    };
    std::vector<std::uint16_t>& field = fields_[which];
    field.assign(static_cast<std::size_t>((field_end_ - field_begin_) * plane_), 0);
    std::vector<std::uint16_t> rows(static_cast<std::size_t>(plane_));
    std::vector<std::uint16_t> sums(static_cast<std::size_t>(plane_));
    const std::int64_t hi = lo + static_cast<std::int64_t>(inside.size()) / plane_;
    for (std::int64_t z = lo; z < hi; ++z) {
      const std::uint8_t* const voxels = inside.data() + (z - lo) * plane_;
      for (std::int64_t y = 0; y < size_.y; ++y) {
        for (std::int64_t x = 0; x < size_.x; ++x) {
          int sum = 0;
          for (std::int64_t d = -kShapeReach; d <= kShapeReach; ++d) {
            const std::int64_t from = std::clamp<std::int64_t>(x + d, 0, size_.x - 1);
            sum += weight(0, d) * voxels[y * size_.x + from];
          }
          rows[static_cast<std::size_t>(y * size_.x + x)] = static_cast<std::uint16_t>(sum);
        }
      }
      std::fill(sums.begin(), sums.end(), std::uint16_t{0});
      for (std::int64_t y = 0; y < size_.y; ++y) {
        for (std::int64_t d = -kShapeReach; d <= kShapeReach; ++d) {
          const std::int64_t from = std::clamp<std::int64_t>(y + d, 0, size_.y - 1);
          add_row(rows.data() + from * size_.x, weight(1, d), size_.x,
                  sums.data() + y * size_.x);
        }
      }
      const std::int64_t first = std::max(field_begin_, z - kShapeReach);
      const std::int64_t last = std::min(field_end_ - 1, z + kShapeReach);
      for (std::int64_t to = first; to <= last; ++to) {
        std::uint16_t share = 0;
        for (std::int64_t d = -kShapeReach; d <= kShapeReach; ++d) {
          if (std::clamp<std::int64_t>(to + d, 0, size_.z - 1) == z) share += weight(2, d);
        }
        add_row(sums.data(), share, plane_, field.data() + (to - field_begin_) * plane_);
      }
    }
  }

  static void add_row(const std::uint16_t* from, std::uint16_t share, std::int64_t count,
                      std::uint16_t* to) {
    for (std::int64_t i = 0; i < count; ++i) {
      to[i] = static_cast<std::uint16_t>(to[i] + share * from[i]);
    }
  }

  std::size_t shown_place(const Index3& p) const {
    return static_cast<std::size_t>((p.z - begin_) * plane_ + p.y * size_.x + p.x);
  }

  double field_at(ShapeField which, const Index3& p) const {
    return fields_[which][static_cast<std::size_t>((p.z - field_begin_) * plane_ + p.y * size_.x +
                                                   p.x)];
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

  Point3 gradient(ShapeField which, const Index3& p) const {
    Point3 g{};
    for (int axis = 0; axis < 3; ++axis) {
      const Beside both = beside(p, axis);
      g[static_cast<std::size_t>(axis)] =
          (field_at(which, both.behind) - field_at(which, both.before)) / both.apart_mm;
    }
    return g;
  }

  /// Second derivatives: along x, y, z, then along y and z, z and x, x and y. Beside the border
  /// those of the voxel next to it.
  std::array<double, 6> bending(ShapeField which, const Index3& p) const {
    std::array<double, 6> bends{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      if (size_[axis] < 3) continue;
      Index3 middle = p;
      middle[axis] = std::clamp<std::int64_t>(p[axis], 1, size_[axis] - 2);
      const Beside both = beside(middle, axis);
      bends[a] = (field_at(which, both.before) - 2 * field_at(which, middle) +
                  field_at(which, both.behind)) /
                 (spacing_[a] * spacing_[a]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      const int first = (axis + 1) % 3;
      const int second = (axis + 2) % 3;
      const Beside both = beside(p, first);
      const Beside before = beside(both.before, second);
      const Beside behind = beside(both.behind, second);
      bends[static_cast<std::size_t>(3 + axis)] =
          (field_at(which, behind.behind) - field_at(which, behind.before) -
           field_at(which, before.behind) + field_at(which, before.before)) /
          (both.apart_mm * before.apart_mm);
    }
    return bends;
  }

  Point3 face_gradient(ShapeField which, const Index3& p, const Index3& q, int axis) const {
    const auto a = static_cast<std::size_t>(axis);
    Point3 g = scaled(sum(gradient(which, p), gradient(which, q)), 0.5 / sums_[which]);
    g[a] = (field_at(which, q) - field_at(which, p)) / (spacing_[a] * sums_[which]);
    return g;
  }

  /// The derivatives of averages at a face, as shares of the mask.
  struct FaceBend {
    Point3 gradient{};
    std::array<double, 6> bends{};

    /// So much of another one in place of this.
    void mix(const FaceBend& other, double share) {
      gradient = sum(scaled(gradient, 1 - share), scaled(other.gradient, share));
      for (std::size_t i = 0; i < bends.size(); ++i) {
        bends[i] += share * (other.bends[i] - bends[i]);
      }
    }
  };
  FaceBend face_bend(ShapeField which, const Index3& p, const Index3& q, int axis) const {
    const double sum_of_all = sums_[which];
    FaceBend face;
    face.gradient = face_gradient(which, p, q, axis);
    const std::array<double, 6> here = bending(which, p);
    const std::array<double, 6> there = bending(which, q);
    for (std::size_t i = 0; i < here.size(); ++i) {
      face.bends[i] = (here[i] + there[i]) * 0.5 / sum_of_all;
    }
    return face;
  }

  /// How steeply averages fall at a face, over how they do at a flat one of something thick.
  double steepness(const FaceBend& face) const {
    double squared = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const ShapeWeights& own = weights_[kEven][a];
      const double flat = own[0] / (own[0] + 2.0 * (own[1] + own[2] + own[3]));
      const double of_voxel = face.gradient[a] * spacing_[a] / flat;
      squared += of_voxel * of_voxel;
    }
    return std::sqrt(squared);
  }

  /// The normal of the surface at a face of so steep averages, of which `n` is the normal, or 0.
  Point3 surface_normal(const Point3& n, double steep, const Index3& p, const Index3& q,
                        int axis) const {
    const auto share = [](double value, const double (&range)[2]) {
      return std::clamp((range[1] - value) / (range[1] - range[0]), 0.0, 1.0);
    };
    const double less_steep = share(steep, kNearSteepness);
    if (less_steep <= 0) return n;
    const Point3 near = unit_or_face(face_gradient(kClosest, p, q, axis), axis);
    const double turned = 1 - share(dot(n, near), {kNearTurn[0], kNearTurn[1]});
    const double all = less_steep * turned;
    return unit_or_face(sum(scaled(n, 1 - all), scaled(near, all)), axis);
  }

  /// Of length 1; that of the face where there is none.
  static Point3 unit_or_face(const Point3& v, int axis) {
    if (dot(v, v) > 0) return unit(v);
    Point3 face{};
    face[static_cast<std::size_t>(axis)] = 1;
    return face;
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
    FaceBend face = face_bend(kEven, p, q, axis);
    const double steep = steepness(face);
    const double thin = std::clamp(3 - 4 * steep, 0.0, 1.0);
    if (thin > 0) face.mix(face_bend(kPeaked, p, q, axis), thin);
    const double length = std::sqrt(dot(face.gradient, face.gradient));
    const Point3 n = length > 0 ? scaled(face.gradient, 1 / length) : Point3{};
    const double patch = face_mm2_[a] * std::abs(surface_normal(n, steep, p, q, axis)[a]);
    sums.area_mm2 += patch;
    if (length <= 0) return;

    // How a surface of equal averages bends across its normal. It is followed inward where the
    // average falls inward, as it may between structures that lie closer than it reaches.
    double across = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      across += face.bends[i] * (1 - n[i] * n[i]);
      across -= 2 * face.bends[3 + i] * n[(i + 1) % 3] * n[(i + 2) % 3];
    }
    const bool falls_outward = (face.gradient[a] < 0) == (inside_[shown_place(p)] != 0);
    const double bend = (falls_outward ? -across : across) / length;
    // No ball is smaller than a voxel.
    const double most = 2 / spacing_[(a + 1) % 3] + 2 / spacing_[(a + 2) % 3];
    sums.growth_mm += patch * std::clamp(bend, -most, most);
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
  std::array<std::array<ShapeWeights, 3>, kShapeFields> weights_{};  // of fields, along axes
  std::array<double, kShapeFields> sums_{1, 1, 1};                   // of all weights
  std::vector<std::uint8_t> inside_;
  std::vector<std::uint8_t> region_;
  std::array<std::vector<std::uint16_t>, kShapeFields> fields_;
};

}  // namespace

SurfaceShape& SurfaceShape::operator+=(const SurfaceShape& other) {
  area_mm2 += other.area_mm2;
  growth_mm += other.growth_mm;
  cut_mm2 += other.cut_mm2;
  return *this;
}

std::uint64_t surface_shape_bytes(const Size3& size) {
  constexpr std::uint64_t kBytesPerVoxel = 210;
  return checked_mul(static_cast<std::uint64_t>(size.x * size.y), kBytesPerVoxel, "a plane");
}

SurfaceShape surface_shape(const MaskTree& mask, const MaskTree* region, const Point3& spacing_mm,
                           Progress& progress) {
  return sum_of_slabs<SurfaceShape>(
      mask.size().z, progress, [&](std::int64_t begin, std::int64_t end) {
        return ShapeSlab(mask, region, spacing_mm, begin, end).measure();
      });
}

}  // namespace octavo
