#include "octavo/ops/morphometry/fitting_balls.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr std::int64_t kBallPlanes = 16;  // of a slab
constexpr std::int64_t kBallReach = 4;    // voxels that larger balls are looked for in
constexpr double kFlat = 0.35;            // slope of distances below which a center is on a ridge

/// The voxels of a class.
InsideVoxels class_voxels(const ThicknessClass& asked) {
  return {asked.mask.size(), [asked](const Box& box, std::uint8_t* inside) {
            fill_voxels(asked.mask, box, inside);
            if (!asked.is_background) return;
            const std::int64_t count = box.size().voxel_count();
            for (std::int64_t i = 0; i < count; ++i) inside[i] ^= 1;
          }};
}

/// The corners between voxels around which all voxels are of a class.
InsideVoxels class_corners(const InsideVoxels& voxels) {
  const Size3 size = {voxels.size.x + 1, voxels.size.y + 1, voxels.size.z + 1};
  return {size, [voxels](const Box& box, std::uint8_t* inside) {
            const Box wide = intersection(
                {{box.lo.x - 1, box.lo.y - 1, box.lo.z - 1}, box.hi}, box_of(voxels.size));
            const Size3 around = wide.size();
            std::vector<std::uint8_t> is_in(static_cast<std::size_t>(around.voxel_count()));
            voxels.fill(wide, is_in.data());
            const auto all_of = [&](const Index3& corner) {
              const Box part =
                  intersection({{corner.x - 1, corner.y - 1, corner.z - 1},
                                {corner.x + 1, corner.y + 1, corner.z + 1}}, wide);
              for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
                for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
                  const std::int64_t row =
                      ((z - wide.lo.z) * around.y + y - wide.lo.y) * around.x - wide.lo.x;
                  for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) {
                    if (is_in[static_cast<std::size_t>(row + x)] == 0) return false;
                  }
                }
              }
              return true;
            };
            for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
              for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
                for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
                  *inside++ = all_of({x, y, z}) ? 1 : 0;
                }
              }
            }
          }};
}

/// Whether a length is a whole number of steps, which it is where it runs along them.
bool is_in_steps(double mm, double step_mm) {
  const double steps = mm / step_mm;
  return steps > 0.5 && std::abs(steps - std::round(steps)) < 1e-4;
}

/// Whether a voxel is known to be of the other class.
bool is_other(const ThicknessClass& asked, const Index3& voxel) {
  return box_of(asked.mask.size()).contains(voxel) &&
         asked.mask.contains(voxel) == asked.is_background;
}

/// The axis along which a ball of that size meets the other class; -1: none.
/// odd  1: it lies around the center of voxel p, and `mm` leads to a center; 0: around the corner
///      before it, and `mm` leads to a face
int axis_met(const ThicknessClass& asked, const Index3& p, int odd, double mm,
             const Point3& spacing) {
  for (int axis = 0; axis < 3; ++axis) {
    const double step = spacing[static_cast<std::size_t>(axis)];
    if (!is_in_steps(mm, step)) continue;
    const auto steps = static_cast<std::int64_t>(std::llround(mm / step));
    for (int around = 0; around < (odd == 1 ? 1 : 4); ++around) {
      Index3 voxel = p;
      voxel[(axis + 1) % 3] -= around & 1;
      voxel[(axis + 2) % 3] -= around >> 1;
      Index3 before = voxel;
      voxel[axis] += steps;
      before[axis] -= steps + 1 - odd;
      if (is_other(asked, voxel) || is_other(asked, before)) return axis;
    }
  }
  return -1;
}

/// How far before the center that it meets a ball around voxel p ends.
double gap_before(const ThicknessClass& asked, const Index3& p, double mm,
                  const Point3& spacing) {
  if (const int axis = axis_met(asked, p, 1, mm, spacing); axis >= 0) {
    return 0.5 * spacing[static_cast<std::size_t>(axis)];
  }
  if (spacing[0] != spacing[1] || spacing[1] != spacing[2]) return 0;
  for (const double axes : {2.0, 3.0}) {
    const double diagonal = std::sqrt(axes) * spacing[0];
    if (is_in_steps(mm, diagonal)) return 0.5 * diagonal / axes;
  }
  return 0;
}

/// Planes of a field around a slab: how far balls reach, 0 where there is none.
class ReachPlanes {
 public:
  ReachPlanes(const Size3& size, int odd) : size_(size), odd_(odd) {}

  void load(DistanceField& field, std::int64_t begin, std::int64_t end,
            const ThicknessClass& asked, const Point3& spacing) {
    begin_ = std::max<std::int64_t>(begin, 0);
    end_ = std::min(end, size_.z);
    reaches_.resize(static_cast<std::size_t>((end_ - begin_) * size_.x * size_.y));
    field.read(begin_, end_, reaches_.data());
    for (float& value : reaches_) value = std::max(0.0F, -value);
    if (odd_ == 1) return;
    // Around corners, from the faces that are met to the centers behind them.
    const std::int64_t plane = size_.x * size_.y;
    tbb::parallel_for(begin_, end_, [&](std::int64_t z) {
      for (std::int64_t i = 0; i < plane; ++i) {
        float& value = reaches_[static_cast<std::size_t>((z - begin_) * plane + i)];
        const Index3 p = {i % size_.x, i / size_.x, z};
        const int axis = value > 0 ? axis_met(asked, p, 0, value, spacing) : -1;
        if (axis < 0) {
          value = 0;
          continue;
        }
        Point3 steps = scaled(spacing, 0.5);
        steps[static_cast<std::size_t>(axis)] += value;
        value = static_cast<float>(std::sqrt(dot(steps, steps)));
      }
    });
  }

  /// Of one ball; 0 where it is not known.
  float at(const Index3& p) const {
    const bool is_here = p.x >= 0 && p.y >= 0 && p.z >= begin_ && p.x < size_.x &&
                         p.y < size_.y && p.z < end_;
    return is_here ? reaches_[place(p)] : 0;
  }
  float known_at(const Index3& p) const { return reaches_[place(p)]; }

  const Size3& size() const { return size_; }
  int odd() const { return odd_; }
  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return end_; }

 private:
  std::size_t place(const Index3& p) const {
    return static_cast<std::size_t>(((p.z - begin_) * size_.y + p.y) * size_.x + p.x);
  }

  Size3 size_;
  int odd_;  // 1: centers of voxels, 0: corners
  std::int64_t begin_ = 0;
  std::int64_t end_ = 0;
  std::vector<float> reaches_;
};

class BallFinder {
 public:
  BallFinder(const ThicknessClass& asked, const Point3& spacing_mm, const ReachPlanes& centers,
             const ReachPlanes& corners)
      : asked_(asked), spacing_(spacing_mm), all_{&centers, &corners} {
    const double unit = std::min({spacing_[0], spacing_[1], spacing_[2]});
    step_ = 0.5 * unit;
    tolerance_ = kBallTolerance * unit;
  }

  /// The balls of a plane of centers or corners that are needed.
  std::vector<FittingBall> in_plane(const ReachPlanes& planes, std::int64_t z) const {
    std::vector<FittingBall> balls;
    Index3 p{0, 0, z};
    for (p.y = 0; p.y < planes.size().y; ++p.y) {
      for (p.x = 0; p.x < planes.size().x; ++p.x) {
        const float reach = planes.known_at(p);
        if (reach <= 0 || !is_in_region(p)) continue;
        if (is_within_larger(planes, p, reach)) continue;
        balls.push_back({{half(p.x, planes), half(p.y, planes), half(p.z, planes)},
                         radius_of(planes, p, reach), reach});
      }
    }
    return balls;
  }

 private:
  static std::int32_t half(std::int64_t index, const ReachPlanes& planes) {
    return static_cast<std::int32_t>(2 * index + planes.odd());
  }

  /// Half of the thickness that a ball stands for.
  float radius_of(const ReachPlanes& planes, const Index3& p, float reach) const {
    if (planes.odd() == 1) {
      return static_cast<float>(reach - gap_before(asked_, p, reach, spacing_));
    }
    // Around a corner, the way to the face that is met.
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      double squared = static_cast<double>(reach) * static_cast<double>(reach);
      for (std::size_t other = 0; other < 3; ++other) {
        if (other != a) squared -= 0.25 * spacing_[other] * spacing_[other];
      }
      const double face = std::sqrt(std::max(0.0, squared)) - 0.5 * spacing_[a];
      if (axis_met(asked_, p, 0, face, spacing_) == axis) return static_cast<float>(face);
    }
    return 0;
  }

  bool is_in_region(const Index3& p) const {
    if (asked_.region == nullptr) return true;
    const Size3& size = asked_.mask.size();
    return asked_.region->contains({std::min(p.x, size.x - 1), std::min(p.y, size.y - 1),
                                    std::min(p.z, size.z - 1)});
  }

  bool is_within_larger(const ReachPlanes& planes, const Index3& p, float reach) const {
    // Where they grow.
    Point3 slope{};
    for (int axis = 0; axis < 3; ++axis) {
      Index3 before = p;
      Index3 behind = p;
      const std::int64_t first = axis == 2 ? planes.begin() : 0;
      const std::int64_t end = axis == 2 ? planes.end() : planes.size()[axis];
      before[axis] = std::max(p[axis] - 1, first);
      behind[axis] = std::min(p[axis] + 1, end - 1);
      const auto a = static_cast<std::size_t>(axis);
      const std::int64_t apart = std::max<std::int64_t>(behind[axis] - before[axis], 1);
      const auto steps = static_cast<double>(apart);
      slope[a] = static_cast<double>(planes.known_at(behind) - planes.known_at(before)) /
                 (steps * spacing_[a]);
    }
    const double length = std::sqrt(dot(slope, slope));
    if (length < kFlat) return false;
    const Point3 up = scaled(slope, 1 / length);

    // The centers and corners nearest to places on the way up.
    for (int k = 2; k <= 2 * kBallReach; ++k) {
      for (const ReachPlanes* other : all_) {
        Index3 q;
        double squared = 0;
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          const auto from = static_cast<double>(half(p[axis], planes));
          const double to = from + k * step_ * up[a] / (0.5 * spacing_[a]);
          q[axis] = static_cast<std::int64_t>(std::floor(0.5 * (to - other->odd()) + 0.5));
          const double mm = (static_cast<double>(half(q[axis], *other)) - from) * 0.5 * spacing_[a];
          squared += mm * mm;
        }
        if (squared == 0) continue;
        if (other->at(q) >= reach + std::sqrt(squared) - tolerance_) return true;
      }
    }
    return false;
  }

  const ThicknessClass& asked_;
  Point3 spacing_;
  std::array<const ReachPlanes*, 2> all_;
  double step_;
  double tolerance_;
};

}  // namespace

std::vector<FittingBall> fitting_balls(const ThicknessClass& asked, const Point3& spacing_mm,
                                       const BallRoom& room, Progress& progress) {
  const InsideVoxels voxels = class_voxels(asked);
  const InsideVoxels between = class_corners(voxels);
  constexpr double kNoLimit = std::numeric_limits<double>::infinity();
  // From centers to centers; from corners to those of the other class, which lie in its faces.
  const auto field_of = [&](const InsideVoxels& places) {
    const DistanceSettings settings{DistanceTo::centers, spacing_mm};
    return make_distance_field(
        places, settings, kNoLimit,
        plan_distance_field(places.size, settings, kNoLimit, room.max_bytes / 2), room.storage,
        room.folder, progress);
  };
  const auto center_field = field_of(voxels);
  const auto corner_field = field_of(between);

  ReachPlanes centers(voxels.size, 1);
  ReachPlanes corners(between.size, 0);
  std::vector<FittingBall> all;
  for (std::int64_t z = 0; z < between.size.z; z += kBallPlanes) {
    const std::int64_t end = z + kBallPlanes;
    centers.load(*center_field, z - kBallReach - 1, end + kBallReach + 1, asked, spacing_mm);
    corners.load(*corner_field, z - kBallReach - 1, end + kBallReach + 1, asked, spacing_mm);
    const BallFinder finder(asked, spacing_mm, centers, corners);
    std::vector<std::vector<FittingBall>> found(static_cast<std::size_t>(2 * kBallPlanes));
    tbb::parallel_for(std::int64_t{0}, 2 * kBallPlanes, [&](std::int64_t i) {
      if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const ReachPlanes& planes = i % 2 == 0 ? centers : corners;
      const std::int64_t plane = z + i / 2;
      if (plane < planes.size().z) {
        found[static_cast<std::size_t>(i)] = finder.in_plane(planes, plane);
      }
    });
    for (const std::vector<FittingBall>& part : found) {
      all.insert(all.end(), part.begin(), part.end());
    }
  }
  tbb::parallel_sort(all.begin(), all.end(), [](const FittingBall& a, const FittingBall& b) {
    return a.radius_mm != b.radius_mm ? a.radius_mm > b.radius_mm : a.half_index < b.half_index;
  });
  return all;
}

}  // namespace octavo
