#include "octavo/mesh/formats/polygon_triangles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr std::size_t kMostConcaveCorners = std::size_t{1} << 16;
// Corners looked at for each one of a polygon: a spiral of long arms asks for far more.
constexpr std::size_t kMostLooks = std::size_t{1} << 10;

/// Above 0 where the way from a over b to c turns left; twice the area between them.
double left_turn(const FlatPoint& a, const FlatPoint& b, const FlatPoint& c) {
  return (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
}

Point3 from_first(std::span<const MeshPoint> points, std::span<const std::uint32_t> corners,
                  std::size_t i) {
  Point3 place;
  for (std::size_t a = 0; a < 3; ++a) {
    place[a] = static_cast<double>(points[corners[i]][a]) -
               static_cast<double>(points[corners[0]][a]);
  }
  return place;
}

/// slack  any turn is a left one up to so much, as a share of its two sides and of the reach of all
bool is_convex(const std::vector<FlatPoint>& flat, double slack = 0) {
  double reach = 0;
  for (const FlatPoint& p : flat) reach = std::max({reach, std::abs(p.x), std::abs(p.y)});
  const std::size_t count = flat.size();
  for (std::size_t i = 0; i < count; ++i) {
    const FlatPoint& a = flat[i];
    const FlatPoint& b = flat[(i + 1) % count];
    const FlatPoint& c = flat[(i + 2) % count];
    const double sides = std::hypot(b.x - a.x, b.y - a.y) + std::hypot(c.x - b.x, c.y - b.y);
    if (!(left_turn(a, b, c) > -slack * reach * sides)) return false;
  }
  return true;
}

/// The ring of corners that are left, and the dents among them, which alone can lie in an ear.
class EarCutter {
 public:
  explicit EarCutter(const std::vector<FlatPoint>& flat)
      : flat_(flat),
        looks_left_(kMostLooks * flat.size()),
        before_(flat.size()),
        behind_(flat.size()),
        is_dent_(flat.size()) {
    const std::size_t count = flat.size();
    for (std::size_t i = 0; i < count; ++i) {
      before_[i] = (i + count - 1) % count;
      behind_[i] = (i + 1) % count;
    }
    for (std::size_t i = 0; i < count; ++i) {
      is_dent_[i] = !(turn(i) > 0);
      if (is_dent_[i]) dents_.push_back(i);
    }
    std::sort(dents_.begin(), dents_.end(),
              [&](std::size_t a, std::size_t b) { return flat_[a].x < flat_[b].x; });
  }

  /// Visits the triangles as three places in the ring.
  template <class Visit>
  void cut(Visit&& visit) {
    std::size_t left = flat_.size();
    std::size_t at = behind_[0];
    // Once around without an ear: there is none.
    std::size_t seen = 0;
    while (left > 3 && seen < left) {
      if (!is_ear(at)) {
        at = behind_[at];
        ++seen;
        continue;
      }
      visit(before_[at], at, behind_[at]);
      const std::size_t next = behind_[at];
      drop(at);
      --left;
      seen = 0;
      // Not beside the last one: ears around one corner would be ever narrower.
      at = behind_[next];
    }
    const std::size_t first = before_[at];
    for (std::size_t i = at; left >= 3; i = behind_[i], --left) visit(first, i, behind_[i]);
  }

 private:
  double turn(std::size_t i) const {
    return left_turn(flat_[before_[i]], flat_[i], flat_[behind_[i]]);
  }

  void drop(std::size_t at) {
    const std::size_t a = before_[at];
    const std::size_t b = behind_[at];
    behind_[a] = b;
    before_[b] = a;
    for (const std::size_t i : {a, b}) is_dent_[i] = is_dent_[i] && !(turn(i) > 0);
  }

  void look() {
    if (looks_left_-- > 0) return;
    throw Error(ErrorKind::limit_exceeded,
                "a polygon of the mesh is too winding to be cut into triangles");
  }

  bool is_ear(std::size_t at) {
    look();
    if (is_dent_[at] || !(turn(at) > 0)) return false;
    const FlatPoint& a = flat_[before_[at]];
    const FlatPoint& b = flat_[at];
    const FlatPoint& c = flat_[behind_[at]];
    const double low = std::min({a.x, b.x, c.x});
    const double high = std::max({a.x, b.x, c.x});
    auto dent = std::lower_bound(dents_.begin(), dents_.end(), low,
                                 [&](std::size_t i, double x) { return flat_[i].x < x; });
    for (; dent != dents_.end() && flat_[*dent].x <= high; ++dent) {
      look();
      const FlatPoint& p = flat_[*dent];
      if (!is_dent_[*dent] || p == a || p == b || p == c) continue;
      const bool is_in = left_turn(a, b, p) >= 0 && left_turn(b, c, p) >= 0 &&
                         left_turn(c, a, p) >= 0;
      if (is_in) return false;
    }
    return true;
  }

  const std::vector<FlatPoint>& flat_;
  std::size_t looks_left_;
  std::vector<std::size_t> before_;
  std::vector<std::size_t> behind_;
  std::vector<bool> is_dent_;
  std::vector<std::size_t> dents_;  // by x; with those that are none any more
};

}  // namespace

/// The corners turn left as they are seen. False where there is no normal.
bool PolygonCutter::see_along_normal(std::span<const MeshPoint> points,
                                     std::span<const std::uint32_t> corners) {
  Point3 normal{};
  Point3 place = from_first(points, corners, 0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point3 next = from_first(points, corners, (i + 1) % corners.size());
    normal = sum(normal, cross(place, next));
    place = next;
  }
  if (!(dot(normal, normal) > 0)) return false;
  normal = unit(normal);
  Point3 aside{};
  std::size_t smallest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(normal[i]) < std::abs(normal[smallest])) smallest = i;
  }
  aside[smallest] = 1;
  const Point3 across = unit(cross(aside, normal));
  const Point3 up = cross(normal, across);
  flat_.clear();
  flat_.reserve(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point3 seen = from_first(points, corners, i);
    flat_.push_back({dot(seen, across), dot(seen, up)});
  }
  return true;
}

std::span<const MeshTriangle> PolygonCutter::cut(std::span<const MeshPoint> points,
                                                 std::span<const std::uint32_t> corners) {
  triangles_.clear();
  triangles_.reserve(corners.size());
  if (corners.size() > 3 && see_along_normal(points, corners)) {
    // Corners of binary32 on a circle may turn right by their rounding.
    constexpr double kRounding = 4 * std::numeric_limits<float>::epsilon();
    const bool is_large = corners.size() > kMostConcaveCorners;
    if (!is_convex(flat_, is_large ? kRounding : 0)) {
      if (is_large) {
        throw Error(ErrorKind::limit_exceeded,
                    "a polygon of the mesh is not convex and has more than 65536 corners");
      }
      EarCutter(flat_).cut([&](std::size_t a, std::size_t b, std::size_t c) {
        triangles_.push_back({corners[a], corners[b], corners[c]});
      });
      return triangles_;
    }
  }
  for (std::size_t i = 2; i < corners.size(); ++i) {
    triangles_.push_back({corners[0], corners[i - 1], corners[i]});
  }
  return triangles_;
}

}  // namespace octavo
