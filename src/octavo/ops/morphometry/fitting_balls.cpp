#include "octavo/ops/morphometry/fitting_balls.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/ops/distance/site_shares.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/parallel_sort.h"

namespace octavo {

namespace {

constexpr std::int64_t kBallPlanes = 16;  // of a slab
constexpr double kNear = 0.5;             // voxels behind it: says what form the surface has
constexpr std::int64_t kKeyStride = 1 << 20;  // more than voxels of an axis, on both sides
constexpr double kLongestOfCubes = 1.001;     // in shortest sides
constexpr double kContact = 0.2;          // voxels behind the nearest site: touched as well

// What is left where gaps are known, by the radius: behind planes, sites lie aside of the way; in
// balls, what is around a site bends away. Measured on random planes and balls.
constexpr double kAside = 1.4;
constexpr double kSmeared = 1.1;
constexpr double kGrowsDownTo = 3;  // radius, in smallest spacings: below, that grows no more

/// Planes of sites around a slab.
class SitePlanes {
 public:
  explicit SitePlanes(const Size3& size) : size_(size) {}

  void load(const SiteField& field, std::int64_t begin, std::int64_t end) {
    begin_ = std::max<std::int64_t>(begin, 0);
    end_ = std::min(end, size_.z);
    sites_.resize(static_cast<std::size_t>((end_ - begin_) * size_.x * size_.y));
    field.read(begin_, end_, sites_.data());
  }

  const NearestSite* row(std::int64_t y, std::int64_t z) const {
    return sites_.data() + ((z - begin_) * size_.y + y) * size_.x;
  }
  bool has(const Index3& p) const {
    return p.x >= 0 && p.y >= 0 && p.z >= begin_ && p.x < size_.x && p.y < size_.y && p.z < end_;
  }
  const NearestSite& at(const Index3& p) const { return row(p.y, p.z)[p.x]; }
  const Size3& size() const { return size_; }

 private:
  Size3 size_;
  std::int64_t begin_ = 0;
  std::int64_t end_ = 0;
  std::vector<NearestSite> sites_;
};

/// A site seen from a voxel, in steps of the smallest spacing.
struct SeenSite {
  Point3 way;
  std::uint8_t share;
};

class BallFinder {
 public:
  BallFinder(const ThicknessClass& asked, const Point3& spacing_mm, const SitePlanes& planes)
      : asked_(asked), planes_(planes) {
    unit_ = std::min({spacing_mm[0], spacing_mm[1], spacing_mm[2]});
    steps_ = scaled(spacing_mm, 1 / unit_);
    longest_ = std::max({steps_[0], steps_[1], steps_[2]});
    diagonal_ = std::max(kNear, 0.5 * std::sqrt(dot(steps_, steps_)));
  }

  /// The balls of a plane that are needed.
  std::vector<FittingBall> in_plane(std::int64_t z) const {
    std::vector<FittingBall> balls;
    Index3 p{0, 0, z};
    for (p.y = 0; p.y < planes_.size().y; ++p.y) {
      const NearestSite* const row = planes_.row(p.y, z);
      for (p.x = 0; p.x < planes_.size().x; ++p.x) {
        if (row[p.x].is_inside() == asked_.is_background) continue;
        if (asked_.region != nullptr && !asked_.region->contains(p)) continue;
        if (is_on_ridge(p, row[p.x]) || is_at_end_of_region(p)) balls.push_back(largest_around(p));
      }
    }
    return balls;
  }

 private:
  /// In steps, from the voxel that lies so many voxels away.
  Point3 way_of(const NearestSite& site, const Point3& from) const {
    Point3 way{};
    for (std::size_t a = 0; a < 3; ++a) way[a] = steps_[a] * (site.steps[a] + from[a]);
    return way;
  }

  /// Whether no neighbor lies deeper, or one has its site elsewhere and is as far away from there
  /// as this voxel is.
  bool is_on_ridge(const Index3& p, const NearestSite& site) const {
    const Point3 way = way_of(site, {});
    const double squared = dot(way, way);
    bool is_deepest = true;
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2;
      const auto a = static_cast<std::size_t>(axis);
      const std::int64_t step = side % 2 == 0 ? -1 : 1;
      Index3 q = p;
      q[axis] += step;
      if (!planes_.has(q)) continue;
      const NearestSite& other = planes_.at(q);
      if (other.is_inside() == asked_.is_background) continue;
      Point3 from{};
      from[a] = static_cast<double>(step);
      const Point3 other_way = way_of(other, from);
      const Point3 own_of_other = way_of(other, {});
      is_deepest = is_deepest && dot(own_of_other, own_of_other) <= squared;
      const Point3 apart = difference(other_way, way);
      if (dot(apart, apart) <= apart_limit(squared)) continue;
      // Half way to the neighbor.
      Point3 half{};
      half[a] = 0.5 * from[a] * steps_[a];
      const Point3 to_own = difference(way, half);
      const Point3 to_other = difference(other_way, half);
      if (dot(to_other, to_other) <= dot(to_own, to_own)) return true;
    }
    return is_deepest;
  }

  /// Whether the class goes on beyond the region.
  bool is_at_end_of_region(const Index3& p) const {
    if (asked_.region == nullptr) return false;
    for (int side = 0; side < 6; ++side) {
      Index3 q = p;
      q[side / 2] += side % 2 == 0 ? -1 : 1;
      if (planes_.has(q) && planes_.at(q).is_inside() != asked_.is_background &&
          !asked_.region->contains(q)) {
        return true;
      }
    }
    return false;
  }

  /// How far apart sites of neighbors may be, squared, where one surface alone is near: behind a
  /// plane, the nearest center is the farther aside the farther away the plane is.
  static double apart_limit(double squared) { return 4 * std::sqrt(squared) + 1; }

  /// The largest ball whose center lies in voxel p, among the sites of all voxels around it.
  FittingBall largest_around(const Index3& p) const {
    std::array<SeenSite, 27> sites;
    std::array<std::int64_t, 27> keys;
    std::ptrdiff_t count = 0;
    for (int i = 0; i < 27; ++i) {
      const Index3 step{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
      const Index3 q{p.x + step.x, p.y + step.y, p.z + step.z};
      if (!planes_.has(q)) continue;
      // A voxel of the other class is a site itself.
      const NearestSite& site = planes_.at(q);
      const bool is_other = site.is_inside() == asked_.is_background;
      std::array<std::int64_t, 3> voxels = {step.x, step.y, step.z};
      if (!is_other) {
        for (std::size_t a = 0; a < 3; ++a) voxels[a] += site.steps[a];
      }
      const std::int64_t key = (voxels[2] * kKeyStride + voxels[1]) * kKeyStride + voxels[0];
      if (std::find(keys.begin(), keys.begin() + count, key) != keys.begin() + count) continue;
      Point3 way{};
      for (std::size_t a = 0; a < 3; ++a) way[a] = steps_[a] * static_cast<double>(voxels[a]);
      const auto place = static_cast<std::size_t>(count++);
      keys[place] = key;
      sites[place] = {way, is_other ? site.own_share() : site.site_share};
    }
    const std::span<const SeenSite> seen(sites.data(), static_cast<std::size_t>(count));

    if (is_cubic()) {
      const Point3 center = deepest_place(seen, [](const Point3& way) { return dot(way, way); });
      return ball_at(p, center, around(center, seen));
    }
    // Where voxels are not cubic, a site along their long side has the surface farther before it.
    // That says where the middle between flat faces is; centers of sites, which a round surface
    // just passes, say it elsewhere.
    const Point3 between_faces = deepest_place(seen, [this](const Point3& way) {
      return std::sqrt(dot(way, way)) - 0.5 * voxel_along(way);
    });
    const Surroundings flat = around(between_faces, seen);
    if (flat.is_flat()) return ball_at(p, between_faces, flat);
    const Point3 center = deepest_place(seen, [](const Point3& way) { return dot(way, way); });
    return ball_at(p, center, around(center, seen));
  }

  bool is_cubic() const { return longest_ == 1; }

  /// The length of a voxel, seen along a way.
  double voxel_along(const Point3& way) const {
    if (is_cubic()) return 1;
    double squared = 0;
    for (std::size_t a = 0; a < 3; ++a) squared += way[a] * way[a] * steps_[a] * steps_[a];
    return std::sqrt(squared / dot(way, way));
  }

  /// The place in a voxel whose nearest site is the farthest: away from the nearest one, by ever
  /// smaller steps that reach all of the voxel.
  template <class Depth>
  Point3 deepest_place(std::span<const SeenSite> seen, Depth depth_of) const {
    Point3 center{};
    Point3 best{};
    double best_depth = -HUGE_VAL;
    for (double step = 0.32 * longest_; step > 0.01; step *= 0.8) {
      const SeenSite* nearest = nullptr;
      double depth = HUGE_VAL;
      for (const SeenSite& one : seen) {
        const double depth_of_one = depth_of(difference(one.way, center));
        if (depth_of_one < depth) {
          depth = depth_of_one;
          nearest = &one;
        }
      }
      if (depth > best_depth) {
        best_depth = depth;
        best = center;
      }
      const Point3 away = difference(center, nearest->way);
      center = sum(center, scaled(away, step / std::sqrt(dot(away, away))));
      for (std::size_t a = 0; a < 3; ++a) {
        center[a] = std::clamp(center[a], -0.5 * steps_[a], 0.5 * steps_[a]);
      }
    }
    return best;
  }

  /// Sites around a center, in steps.
  struct Surroundings {
    double reach = 0;    // to the nearest one
    double clear = 0;    // to the nearest face of a voxel
    int contacts = 0;    // sites that the ball touches
    int flat = 0;        // of these, before which the surface is flat
    double lengths = 0;  // to the surface before contacts where it is not flat, in all
    double flat_lengths = 0;  // where it is
    double along = 0;    // squared voxels, seen along the ways to contacts, in all
    int near = 0;                    // sites whose directions are known
    std::array<double, 6> tensor{};  // of directions: xx, yy, zz, xy, yz, zx

    bool is_flat() const { return flat == contacts; }
  };

  Surroundings around(const Point3& center, std::span<const SeenSite> seen) const {
    Surroundings all;
    double nearest = HUGE_VAL;
    for (const SeenSite& one : seen) {
      const Point3 way = difference(one.way, center);
      nearest = std::min(nearest, dot(way, way));
    }
    all.reach = std::sqrt(nearest);
    const double near = (all.reach + kNear) * (all.reach + kNear);
    const double with_face = (all.reach + diagonal_) * (all.reach + diagonal_);
    double clear = nearest;
    for (const SeenSite& one : seen) {
      const Point3 way = difference(one.way, center);
      const double squared = dot(way, way);
      if (squared > with_face) continue;
      Point3 to_face{};
      for (std::size_t a = 0; a < 3; ++a) {
        to_face[a] = std::max(std::abs(way[a]) - 0.5 * steps_[a], 0.0);
      }
      clear = std::min(clear, dot(to_face, to_face));
      if (squared > near) continue;
      const double length = std::sqrt(squared);
      const Point3 n = scaled(way, 1 / length);
      for (std::size_t a = 0; a < 3; ++a) {
        all.tensor[a] += n[a] * n[a];
        all.tensor[3 + a] += n[a] * n[(a + 1) % 3];
      }
      ++all.near;
      if (length > all.reach + kContact) continue;
      const double voxel = voxel_along(way);
      const bool is_flat = one.share == kFlatShare;
      (is_flat ? all.flat_lengths : all.lengths) += length - surface_gap(one.share) * voxel;
      all.along += voxel * voxel;
      ++all.contacts;
      if (is_flat) ++all.flat;
    }
    all.clear = std::sqrt(clear);
    return all;
  }

  FittingBall ball_at(const Index3& p, const Point3& center, const Surroundings& sites) const {
    FittingBall ball;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      ball.center[a] =
          static_cast<float>(static_cast<double>(p[axis]) + 0.5 + center[a] / steps_[a]);
    }
    const double radius = sites.is_flat() ? sites.clear : radius_before(sites);
    // Of flat voxels, a site may lie far behind the surface.
    const double reach =
        is_cubic() ? sites.reach : std::min(sites.reach, radius + 0.5 * longest_);
    ball.radius_mm = static_cast<float>(unit_ * radius);
    ball.reach_mm = static_cast<float>(unit_ * reach);
    return ball;
  }

  /// How far the surface is where it is not flat.
  double radius_before(const Surroundings& sites) const {
    // Of so many directions: 1 between two planes, 2 in a rod, 3 in a ball.
    double squares = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      squares += sites.tensor[a] * sites.tensor[a] + 2 * sites.tensor[3 + a] * sites.tensor[3 + a];
    }
    const double directions = sites.near * sites.near / squares;
    const double round = std::clamp(0.5 * (directions - 1), 0.0, 1.0);
    // A surface that bends in all of them but its normal, smeared over voxels.
    double across = -sites.along / sites.contacts;
    for (std::size_t a = 0; a < 3; ++a) {
      across += directions * sites.tensor[a] / sites.near * steps_[a] * steps_[a];
    }
    const double smeared =
        kSmeared * std::max(0.5 * across, 0.0) / std::max(sites.reach, kGrowsDownTo);
    const double aside = kAside * (1 - round) / sites.reach;
    // The caps of round surfaces look flat, and are where these just pass centers.
    const double counted = std::clamp(2 - directions, 0.0, 1.0);
    const double length = (sites.lengths + counted * sites.flat_lengths) /
                          (sites.contacts - sites.flat + counted * sites.flat);
    return std::clamp(length + smeared - aside, sites.clear, sites.reach);
  }

  const ThicknessClass& asked_;
  const SitePlanes& planes_;
  double unit_ = 1;
  Point3 steps_{};  // the spacing in units
  double longest_ = 1;
  double diagonal_ = 1;  // half of that of a voxel: no face lies farther before its center
};

}  // namespace

Point3 thickness_spacing(const Point3& spacing_mm) {
  const auto [shortest, longest] = std::minmax({spacing_mm[0], spacing_mm[1], spacing_mm[2]});
  if (longest >= kLongestOfCubes * shortest) return spacing_mm;
  if (longest == shortest) return spacing_mm;
  const double side = std::cbrt(spacing_mm[0] * spacing_mm[1] * spacing_mm[2]);
  return {side, side, side};
}

std::vector<FittingBall> fitting_balls(const ThicknessClass& asked, const Point3& spacing_mm,
                                       const SiteField& field, Progress& progress) {
  const Size3 size = asked.mask.size();
  SitePlanes planes(size);
  std::vector<FittingBall> all;
  for (std::int64_t z = 0; z < size.z; z += kBallPlanes) {
    const std::int64_t end = std::min(z + kBallPlanes, size.z);
    planes.load(field, z - 1, end + 1);
    const BallFinder finder(asked, spacing_mm, planes);
    std::vector<std::vector<FittingBall>> found(static_cast<std::size_t>(end - z));
    parallel_for(z, end, [&](std::int64_t plane) {
      if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      found[static_cast<std::size_t>(plane - z)] = finder.in_plane(plane);
    });
    for (const std::vector<FittingBall>& part : found) {
      all.insert(all.end(), part.begin(), part.end());
    }
    progress.advance(end - z);
  }
  parallel_sort(all, [](const FittingBall& a, const FittingBall& b) {
    return a.radius_mm != b.radius_mm ? a.radius_mm > b.radius_mm : a.center < b.center;
  });
  return all;
}

}  // namespace octavo
