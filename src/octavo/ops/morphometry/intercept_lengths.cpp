#include "octavo/ops/morphometry/intercept_lengths.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/octree/mask_accessor.h"
#include "octavo/ops/measure/measure.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr int kLineDirections = 300;
constexpr int kLinesAcross = 40;  // of the sphere around the volume

/// Directions spread evenly over half a sphere.
Point3 direction_at(int i) {
  constexpr double kGolden = 2.399963229728653;  // the golden angle
  const double z = (i + 0.5) / kLineDirections;
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(kGolden * i), r * std::sin(kGolden * i), z};
}

/// Follows lines of one direction.
class LineSampler {
 public:
  LineSampler(const MaskAccessor& mask, const MaskAccessor* region, const Size3& size,
              const Point3& spacing)
      : mask_(mask), region_(region), size_(size), spacing_(spacing) {
    step_ = std::max({spacing[0], spacing[1], spacing[2]});
    for (std::size_t a = 0; a < 3; ++a) {
      extent_[a] = spacing[a] * static_cast<double>(size[static_cast<int>(a)]);
    }
    radius_ = 0.5 * std::sqrt(dot(extent_, extent_));
  }

  /// Intercepts per mm; a negative number where no line passes through the region.
  double intercepts_per_mm(const Point3& u) const {
    const Point3 other = std::abs(u[2]) < 0.9 ? Point3{0, 0, 1} : Point3{1, 0, 0};
    const Point3 a = unit(cross(u, other));
    const Point3 b = cross(u, a);
    const double apart = 2 * radius_ / kLinesAcross;
    std::int64_t steps = 0;
    std::int64_t intercepts = 0;
    for (int i = 0; i < kLinesAcross; ++i) {
      for (int j = 0; j < kLinesAcross; ++j) {
        const double along_a = -radius_ + (i + 0.5) * apart;
        const double along_b = -radius_ + (j + 0.5) * apart;
        const Point3 across = sum(scaled(a, along_a), scaled(b, along_b));
        const Point3 middle = sum(scaled(extent_, 0.5), across);
        follow(middle, u, steps, intercepts);
      }
    }
    return steps == 0 ? -1 : static_cast<double>(intercepts) / (static_cast<double>(steps) * step_);
  }

 private:
  void follow(const Point3& middle, const Point3& u, std::int64_t& steps,
              std::int64_t& intercepts) const {
    // The part of the line within the volume.
    double lo = -2 * radius_;
    double hi = 2 * radius_;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(u[axis]) < 1e-12) {
        if (middle[axis] < 0 || middle[axis] >= extent_[axis]) return;
        continue;
      }
      const double t0 = -middle[axis] / u[axis];
      const double t1 = (extent_[axis] - middle[axis]) / u[axis];
      lo = std::max(lo, std::min(t0, t1));
      hi = std::min(hi, std::max(t0, t1));
    }
    bool was_sampled = false;
    bool was_inside = false;
    for (double t = lo + 0.5 * step_; t < hi; t += step_) {
      const Point3 p = sum(middle, scaled(u, t));
      const Index3 voxel = {static_cast<std::int64_t>(p[0] / spacing_[0]),
                            static_cast<std::int64_t>(p[1] / spacing_[1]),
                            static_cast<std::int64_t>(p[2] / spacing_[2])};
      const bool is_sampled = box_of(size_).contains(voxel) &&
                              (region_ == nullptr || region_->contains(voxel));
      const bool is_inside = is_sampled && mask_.contains(voxel);
      if (is_sampled && was_sampled) {
        ++steps;
        intercepts += is_inside != was_inside ? 1 : 0;
      }
      was_sampled = is_sampled;
      was_inside = is_inside;
    }
  }

  const MaskAccessor& mask_;
  const MaskAccessor* region_;
  Size3 size_;
  Point3 spacing_;
  Point3 extent_{};
  double step_ = 0;
  double radius_ = 0;
};

using Row6 = std::array<double, 6>;

/// Solves a symmetric positive system by elimination with pivots; false where it has no solution.
bool solve(std::array<Row6, 6>& rows, Row6& right) {
  for (std::size_t k = 0; k < 6; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < 6; ++i) {
      if (std::abs(rows[i][k]) > std::abs(rows[pivot][k])) pivot = i;
    }
    if (std::abs(rows[pivot][k]) < 1e-12) return false;
    std::swap(rows[k], rows[pivot]);
    std::swap(right[k], right[pivot]);
    for (std::size_t i = k + 1; i < 6; ++i) {
      const double factor = rows[i][k] / rows[k][k];
      for (std::size_t j = k; j < 6; ++j) rows[i][j] -= factor * rows[k][j];
      right[i] -= factor * right[k];
    }
  }
  for (std::size_t k = 6; k-- > 0;) {
    for (std::size_t j = k + 1; j < 6; ++j) right[k] -= rows[k][j] * right[j];
    right[k] /= rows[k][k];
  }
  return true;
}

/// The tensor M: xx, yy, zz, xy, xz, yz.
bool fit_tensor(const std::vector<double>& per_mm, Row6& tensor) {
  std::array<Row6, 6> rows{};
  Row6 right{};
  for (int i = 0; i < kLineDirections; ++i) {
    const double value = per_mm[static_cast<std::size_t>(i)];
    if (value < 0) continue;
    const Point3 u = direction_at(i);
    const Row6 terms = {u[0] * u[0],     u[1] * u[1],     u[2] * u[2],
                        2 * u[0] * u[1], 2 * u[0] * u[2], 2 * u[1] * u[2]};
    for (std::size_t a = 0; a < 6; ++a) {
      for (std::size_t b = 0; b < 6; ++b) rows[a][b] += terms[a] * terms[b];
      right[a] += terms[a] * value * value;
    }
  }
  if (!solve(rows, right)) return false;
  tensor = right;
  return true;
}

}  // namespace

std::optional<Anisotropy> anisotropy(const MaskTree& mask, const MaskTree* region,
                                     const Point3& spacing_mm, Progress& progress) {
  const MaskAccessor in_mask(mask);
  std::optional<MaskAccessor> in_region;
  if (region != nullptr) in_region.emplace(*region);
  const LineSampler sampler(in_mask, in_region ? &*in_region : nullptr, mask.size(), spacing_mm);
  std::vector<double> per_mm(kLineDirections);
  parallel_for(0, kLineDirections, [&](int i) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    per_mm[static_cast<std::size_t>(i)] = sampler.intercepts_per_mm(direction_at(i));
    progress.advance(1);
  });
  Row6 tensor{};
  const bool is_any = std::any_of(per_mm.begin(), per_mm.end(), [](double v) { return v > 0; });
  if (!is_any || !fit_tensor(per_mm, tensor)) return std::nullopt;

  RegionMeasure shape;
  shape.covariance = tensor;
  const PrincipalAxes axes = principal_axes(shape, Geometry{});
  Anisotropy result;
  result.degree = 1 - axes.moments_mm2[2] / axes.moments_mm2[0];
  // The largest eigenvalue belongs to the shortest axis.
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = axes.moments_mm2[2 - i];
    result.lengths_mm[i] = value > 0 ? 1 / std::sqrt(value) : 0;
    result.axes[i] = axes.axes[2 - i];
  }
  return result;
}

}  // namespace octavo
