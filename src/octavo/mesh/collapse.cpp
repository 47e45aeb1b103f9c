#include "octavo/mesh/collapse.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_shape.h"

namespace octavo {

namespace {

/// Numbers of a part are its own: no check of bounds in the innermost loops.
template <class T>
T& item(std::vector<T>& items, int number) {
  return items.data()[number];
}
template <class T>
const T& item(const std::vector<T>& items, int number) {
  return items.data()[number];
}

bool has_corner(const CollapseTriangle& t, int vertex) {
  return t.corners[0] == vertex || t.corners[1] == vertex || t.corners[2] == vertex;
}

double squared_length(const Point3& v) { return dot(v, v); }

}  // namespace

void CollapsePart::clear() {
  vertices.clear();
  triangles.clear();
  points.clear();
}

void CollapsePart::run(double tolerance, const Progress& progress) {
  squared_tolerance_ = tolerance * tolerance;
  marks_.assign(vertices.size(), 0);
  mark_ = 0;
  find_fans();
  heap_.clear();
  candidates_.clear();
  for (const CollapseTriangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t.corners[k];
      const int b = t.corners[(k + 1) % 3];
      if (a < b) push(a, b);
    }
  }
  for (std::size_t i = 0; !heap_.is_empty(); ++i) {
    stop_now_and_then(i, progress);
    const Candidate best = candidates_.data()[heap_.pop()];
    if (item(fans_, best.a).stamp != best.a_stamp || item(fans_, best.b).stamp != best.b_stamp) {
      continue;
    }
    collapse(best.a, best.b);
  }
}

void CollapsePart::find_fans() {
  fans_.assign(vertices.size(), {});
  for (const CollapseTriangle& t : triangles) {
    for (const int vertex : t.corners) ++item(fans_, vertex).count;
  }
  std::size_t first = 0;
  for (Fan& fan : fans_) {
    fan.first = first;
    first += std::exchange(fan.count, 0);
  }
  around_.resize(first);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const int vertex : triangles[i].corners) {
      Fan& fan = item(fans_, vertex);
      around_.data()[fan.first + fan.count++] = static_cast<int>(i);
    }
  }
}

/// Where the vertex would lie that takes the place of two, and what that costs; false where it must
/// not be.
bool CollapsePart::find_place(int a, int b, Point3& place, double& cost) const {
  const CollapseVertex& first = item(vertices, a);
  const CollapseVertex& second = item(vertices, b);
  if (first.is_locked && second.is_locked) return false;
  Quadric quadric = first.quadric;
  quadric.add(second.quadric);
  const double squared_side = squared_length(difference(first.place, second.place));
  if (first.is_locked) {
    place = first.place;
  } else if (second.is_locked) {
    place = second.place;
  } else {
    const Point3 middle = scaled(sum(first.place, second.place), 0.5);
    place = quadric.lowest_place(middle);
    // Far away the planes say nothing any more.
    if (!(squared_length(difference(place, middle)) < 4 * squared_side)) place = middle;
  }
  cost = quadric.at(place);
  if (cost > squared_tolerance_ * quadric.weight()) return false;
  cost += 1e-6 * quadric.weight() * squared_side;
  return true;
}

void CollapsePart::push(int a, int b) {
  if (a > b) std::swap(a, b);
  Point3 place;
  double cost = 0;
  if (!find_place(a, b, place, cost)) return;
  heap_.push(static_cast<float>(cost), static_cast<std::uint32_t>(candidates_.size()));
  candidates_.push_back({a, b, item(fans_, a).stamp, item(fans_, b).stamp});
}

bool CollapsePart::collapse(int a, int b) {
  Point3 place;
  double cost = 0;
  if (!find_place(a, b, place, cost)) return false;
  const int keep = item(vertices, b).is_locked ? b : a;
  const int gone = keep == a ? b : a;
  find_star(keep, gone);
  if (!keeps_topology(keep, gone) || !keeps_shapes(keep, gone, place) || !keeps_points()) {
    return false;
  }
  commit(keep, gone, place);
  return true;
}

void CollapsePart::find_star(int keep, int gone) {
  star_.clear();
  lost_.clear();
  for (const int vertex : {keep, gone}) {
    const Fan& fan = item(fans_, vertex);
    for (std::size_t i = 0; i < fan.count; ++i) {
      const int triangle = around_.data()[fan.first + i];
      const CollapseTriangle& t = item(triangles, triangle);
      if (!has_corner(t, keep) || !has_corner(t, gone)) star_.push_back(triangle);
      else if (vertex == keep) lost_.push_back(triangle);
    }
  }
}

int CollapsePart::opposite(int triangle, int a, int b) const {
  for (const int vertex : item(triangles, triangle).corners) {
    if (vertex != a && vertex != b) return vertex;
  }
  return -1;
}

bool CollapsePart::keeps_topology(int keep, int gone) {
  if (lost_.size() != 2) return false;
  sides_ = {opposite(lost_[0], keep, gone), opposite(lost_[1], keep, gone)};
  if (sides_[0] == sides_[1]) return false;
  for (const int side : sides_) {
    if (item(fans_, side).count <= 3 && !item(vertices, side).is_locked) return false;
  }
  // Neighbors of both ends are just the two sides. Beside a locked vertex edges may lie in other
  // parts, so that a locked neighbor of one counts as one of both.
  const auto visit_neighbors = [&](int vertex, auto visit) {
    const Fan& fan = item(fans_, vertex);
    for (std::size_t i = 0; i < fan.count; ++i) {
      for (const int other : item(triangles, around_.data()[fan.first + i]).corners) visit(other);
    }
  };
  ++mark_;
  visit_neighbors(keep, [&](int vertex) { item(marks_, vertex) = mark_; });
  int common = 0;
  visit_neighbors(gone, [&](int vertex) {
    if (vertex == keep || vertex == gone) return;
    const bool is_shared = item(marks_, vertex) == mark_;
    const bool may_be_shared = item(vertices, keep).is_locked &&
                               item(vertices, vertex).is_locked && vertex != sides_[0] &&
                               vertex != sides_[1];
    if (!is_shared && !may_be_shared) return;
    item(marks_, vertex) = 0;
    ++common;
  });
  return common == 2;
}

bool CollapsePart::keeps_shapes(int keep, int gone, const Point3& place) {
  const ShapeRule rule(std::sqrt(squared_tolerance_));
  const auto places_before = [&](const CollapseTriangle& t) {
    TrianglePlaces places;
    for (std::size_t k = 0; k < 3; ++k) places[k] = item(vertices, t.corners[k]).place;
    return places;
  };
  const auto around = [&] {
    Point3 normal = {0, 0, 0};
    for (const int triangle : star_) {
      normal = sum(normal, TriangleShape(places_before(item(triangles, triangle))).normal);
    }
    return normal;
  };
  renewed_.clear();
  for (const int triangle : star_) {
    const CollapseTriangle& t = item(triangles, triangle);
    const TrianglePlaces before = places_before(t);
    TrianglePlaces after = before;
    for (std::size_t k = 0; k < 3; ++k) {
      if (t.corners[k] == keep || t.corners[k] == gone) after[k] = place;
    }
    const std::optional<Point3> normal = rule.renewed(before, after, around);
    if (!normal) return false;
    renewed_.push_back({after, *normal});
  }
  return true;
}

/// Finds a new triangle for a point; false where none is near enough.
/// own  the place in star_ of the triangle it is attached to now; -1: that one is lost
bool CollapsePart::take_point(int point, int own) {
  constexpr double kNearEnough = 0.64;  // of the squared tolerance: no nearer one is looked for
  const AttachedPoint& p = item(points, point);
  double best = std::numeric_limits<double>::infinity();
  int best_place = -1;
  if (own >= 0) {
    best = squared_distance(p.place, item(renewed_, own).places);
    best_place = own;
  }
  const auto count = static_cast<int>(renewed_.size());
  for (int i = 0; i < count && best >= kNearEnough * p.squared_tolerance; ++i) {
    if (i == own) continue;
    const NewTriangle& t = item(renewed_, i);
    const double height = dot(t.normal, difference(p.place, t.places[0]));
    if (height * height >= best || height * height > p.squared_tolerance) continue;
    const double squared = squared_distance(p.place, t.places);
    if (squared >= best) continue;
    best = squared;
    best_place = i;
  }
  if (best > p.squared_tolerance) return false;
  moved_.push_back({point, best_place});
  return true;
}

bool CollapsePart::keeps_points() {
  moved_.clear();
  for (const int triangle : lost_) {
    for (int p = item(triangles, triangle).first_point; p >= 0; p = item(points, p).next) {
      if (!take_point(p, -1)) return false;
    }
  }
  for (std::size_t i = 0; i < star_.size(); ++i) {
    for (int p = item(triangles, star_[i]).first_point; p >= 0; p = item(points, p).next) {
      if (!take_point(p, static_cast<int>(i))) return false;
    }
  }
  return true;
}

void CollapsePart::commit(int keep, int gone, const Point3& place) {
  CollapseVertex& kept = item(vertices, keep);
  kept.place = place;
  kept.quadric.add(item(vertices, gone).quadric);
  for (const int triangle : lost_) {
    item(triangles, triangle).is_left = false;
    item(triangles, triangle).first_point = -1;
  }
  for (const int triangle : star_) {
    CollapseTriangle& t = item(triangles, triangle);
    t.first_point = -1;
    std::replace(t.corners.begin(), t.corners.end(), gone, keep);
  }
  for (const auto& [point, place_in_star] : moved_) {
    CollapseTriangle& t = item(triangles, item(star_, place_in_star));
    item(points, point).next = std::exchange(t.first_point, point);
  }

  // The fan of the kept vertex is the star; the two sides lose a triangle.
  item(fans_, keep).first = around_.size();
  item(fans_, keep).count = static_cast<std::uint32_t>(star_.size());
  around_.insert(around_.end(), star_.begin(), star_.end());
  item(fans_, gone).count = 0;
  for (const int side : sides_) {
    Fan& fan = item(fans_, side);
    const auto begin = around_.begin() + static_cast<std::ptrdiff_t>(fan.first);
    const auto end = std::remove_if(begin, begin + fan.count, [&](int triangle) {
      return !item(triangles, triangle).is_left;
    });
    fan.count = static_cast<std::uint32_t>(end - begin);
  }
  ++item(fans_, keep).stamp;
  ++item(fans_, gone).stamp;

  ++mark_;
  item(marks_, keep) = mark_;
  for (const int triangle : star_) {
    for (const int vertex : item(triangles, triangle).corners) {
      if (std::exchange(item(marks_, vertex), mark_) != mark_) push(keep, vertex);
    }
  }
}

}  // namespace octavo
