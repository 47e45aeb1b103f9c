#include "octavo/mesh/triangle_crossing.h"

#include <algorithm>
#include <cstddef>

#include "octavo/mesh/orientation.h"

namespace octavo {

namespace {

/// Two axes of a plane in which a triangle is seen with an area; false where it has none.
bool find_axes(const TrianglePlaces& t, int& u, int& v) {
  for (int axis = 0; axis < 3; ++axis) {
    u = (axis + 1) % 3;
    v = (axis + 2) % 3;
    if (turn_of(t[0], t[1], t[2], u, v) != 0) return true;
  }
  return false;
}

/// Whether p lies in the triangle, its border included, all of them in one plane.
bool is_in_flat(const Point3& p, const TrianglePlaces& t, int u, int v) {
  const int a = turn_of(t[0], t[1], p, u, v);
  const int b = turn_of(t[1], t[2], p, u, v);
  const int c = turn_of(t[2], t[0], p, u, v);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

bool do_flat_segments_meet(const Point3& p, const Point3& q, const Point3& a, const Point3& b,
                           int u, int v) {
  if (turn_of(p, q, a, u, v) * turn_of(p, q, b, u, v) > 0) return false;
  if (turn_of(a, b, p, u, v) * turn_of(a, b, q, u, v) > 0) return false;
  // What is left lies across, or on one line, where the ends tell.
  const auto do_overlap = [&](int axis) {
    const auto i = static_cast<std::size_t>(axis);
    return std::min(p[i], q[i]) <= std::max(a[i], b[i]) &&
           std::min(a[i], b[i]) <= std::max(p[i], q[i]);
  };
  return do_overlap(u) && do_overlap(v);
}

bool does_flat_segment_meet(const Point3& p, const Point3& q, const TrianglePlaces& t) {
  int u = 0;
  int v = 0;
  if (!find_axes(t, u, v)) return true;
  if (is_in_flat(p, t, u, v) || is_in_flat(q, t, u, v)) return true;
  for (std::size_t k = 0; k < 3; ++k) {
    if (do_flat_segments_meet(p, q, t[k], t[(k + 1) % 3], u, v)) return true;
  }
  return false;
}

/// Whether the segment p q and the triangle have a point in common, ends and border included.
bool does_segment_meet(const Point3& p, const Point3& q, const TrianglePlaces& t) {
  const int from = orientation_of(t[0], t[1], t[2], p);
  const int to = orientation_of(t[0], t[1], t[2], q);
  if (from * to > 0) return false;
  if (from == 0 && to == 0) return does_flat_segment_meet(p, q, t);
  const int a = orientation_of(p, q, t[0], t[1]);
  const int b = orientation_of(p, q, t[1], t[2]);
  if (a * b < 0) return false;
  const int c = orientation_of(p, q, t[2], t[0]);
  return a * c >= 0 && b * c >= 0;
}

/// Two triangles at an edge: whether one is folded onto the other.
bool are_folded(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  if (orientation_of(a, b, c, d) != 0) return false;
  int u = 0;
  int v = 0;
  if (!find_axes({a, b, c}, u, v)) return true;
  return turn_of(a, b, c, u, v) * turn_of(a, b, d, u, v) >= 0;
}

struct SharedCorners {
  int count = 0;
  std::array<bool, 3> of_a{};
  std::array<bool, 3> of_b{};
};

SharedCorners shared_corners(const MeshTriangle& a, const MeshTriangle& b) {
  SharedCorners shared;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (a[i] != b[j]) continue;
      ++shared.count;
      shared.of_a[i] = true;
      shared.of_b[j] = true;
    }
  }
  return shared;
}

std::size_t place_of(const std::array<bool, 3>& corners, bool value) {
  return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), value) -
                                  corners.begin());
}

bool does_any_edge_meet(const TrianglePlaces& edges, const TrianglePlaces& t) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (does_segment_meet(edges[k], edges[(k + 1) % 3], t)) return true;
  }
  return false;
}

/// Whether all corners of b but shared ones lie strictly on one side of the plane of a.
bool is_on_one_side(const TrianglePlaces& a, const TrianglePlaces& b,
                    const std::array<bool, 3>& shared_of_b) {
  int side = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (shared_of_b[k]) continue;
    const int own = orientation_of(a[0], a[1], a[2], b[k]);
    if (own == 0 || own == -side) return false;
    side = own;
  }
  return true;
}

}  // namespace

bool do_cross(const TrianglePlaces& a, const MeshTriangle& a_numbers, const TrianglePlaces& b,
              const MeshTriangle& b_numbers) {
  const SharedCorners shared = shared_corners(a_numbers, b_numbers);
  if (shared.count < 2 &&
      (is_on_one_side(a, b, shared.of_b) || is_on_one_side(b, a, shared.of_a))) {
    return false;
  }
  if (shared.count == 0) return does_any_edge_meet(a, b) || does_any_edge_meet(b, a);
  if (shared.count == 1) {
    const std::size_t i = place_of(shared.of_a, true);
    const std::size_t j = place_of(shared.of_b, true);
    return does_segment_meet(a[(i + 1) % 3], a[(i + 2) % 3], b) ||
           does_segment_meet(b[(j + 1) % 3], b[(j + 2) % 3], a);
  }
  if (shared.count > 2) return true;
  const std::size_t i = place_of(shared.of_a, false);
  const std::size_t j = place_of(shared.of_b, false);
  return are_folded(a[(i + 1) % 3], a[(i + 2) % 3], a[i], b[j]);
}

}  // namespace octavo
