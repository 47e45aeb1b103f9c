#include "octavo/ops/align/pose_agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr double kSameWay = 0.7;        // cosine between directions that count as the same
constexpr double kCellTolerances = 6;   // side of the cells that tell what lies around

/// The way out of a surface, not of unit length: faces of voxels alone know six ways.
Point3 way_out(const DistanceGrid& distances, const Point3& p, double voxel_mm) {
  Point3 way{};
  for (int corner = 0; corner < 8; ++corner) {
    Point3 q = p;
    for (std::size_t a = 0; a < 3; ++a) q[a] += (corner >> a & 1) != 0 ? voxel_mm : -voxel_mm;
    way = sum(way, distances.at(q).slope);
  }
  return way;
}

Point3 turned_way(const Affine& map, const Point3& way) {
  return difference(map(way), map.offset);
}

/// Whether a point of one surface, mapped to q, agrees with the other.
bool is_agreeing(const PosedSurface& from, const Point3& p, const PosedSurface& to,
                 const Point3& q, const Affine& map, double tolerance_mm) {
  if (!(std::abs(to.distances.at(q).mm) <= tolerance_mm)) return false;
  const Point3 own = turned_way(map, way_out(from.distances, p, from.voxel_mm));
  const Point3 other = way_out(to.distances, q, to.voxel_mm);
  return dot(own, other) > kSameWay * std::sqrt(dot(own, own) * dot(other, other));
}

/// By how much a map makes lengths longer.
double stretch_of(const Affine& map) {
  const Point3 unit_step = turned_way(map, {1, 0, 0});
  return std::sqrt(dot(unit_step, unit_step));
}

using GridCell = std::array<std::int64_t, 3>;

GridCell cell_of(const Point3& q, double side_mm) {
  GridCell cell{};
  for (std::size_t a = 0; a < 3; ++a) {
    cell[a] = static_cast<std::int64_t>(std::floor(q[a] / side_mm));
  }
  return cell;
}

/// Whether one of the points that cells hold is within their side.
bool has_near(const std::map<GridCell, std::vector<Point3>>& cells, const Point3& q,
              double side_mm) {
  const GridCell own = cell_of(q, side_mm);
  for (int i = 0; i < 27; ++i) {
    const auto found = cells.find({own[0] + i % 3 - 1, own[1] + i / 3 % 3 - 1, own[2] + i / 9 - 1});
    if (found == cells.end()) continue;
    for (const Point3& p : found->second) {
      const Point3 apart = difference(p, q);
      if (dot(apart, apart) <= side_mm * side_mm) return true;
    }
  }
  return false;
}

/// The share of those points that lie in cells of which `agrees` holds; 0 where none does.
template <class Agrees>
double share_within(const std::set<GridCell>& cells, double side_mm, std::span<const Point3> points,
                    const Agrees& agrees) {
  std::size_t asked = 0;
  std::size_t agreeing = 0;
  for (const Point3& q : points) {
    if (!cells.contains(cell_of(q, side_mm))) continue;
    ++asked;
    if (agrees(q)) ++agreeing;
  }
  return asked > 0 ? static_cast<double>(agreeing) / static_cast<double>(asked) : 0;
}

}  // namespace

PoseAgreement agreement_of(const PosedSurface& first, const PosedSurface& second,
                           const Affine& map) {
  PoseAgreement agreement;
  const auto back = inverse(map);
  if (!back) return agreement;
  const double scale = stretch_of(map);
  const double tolerance =
      std::clamp(first.voxel_mm * scale, second.voxel_mm, 2 * second.voxel_mm);

  const double side_mm = kCellTolerances * tolerance;
  std::set<GridCell> around;
  std::size_t agreeing = 0;
  for (const Point3& p : first.points) {
    const Point3 q = map(p);
    if (!is_agreeing(first, p, second, q, map, tolerance)) continue;
    ++agreeing;
    around.insert(cell_of(q, side_mm));
  }
  agreement.forward = static_cast<double>(agreeing) / static_cast<double>(first.points.size());
  agreement.backward = share_within(around, side_mm, second.points, [&](const Point3& q) {
    return is_agreeing(second, q, first, (*back)(q), *back, tolerance / scale);
  });
  return agreement;
}

PoseAgreement agreement_of(const PosedPoints& first, const PosedSurface& second,
                           const Affine& map) {
  PoseAgreement agreement;
  const double scale = stretch_of(map);
  const double tolerance = 1.5 * second.voxel_mm;
  const double reach = std::max(tolerance, 1.5 * first.spacing_mm * scale);
  const double side_mm = kCellTolerances * tolerance;
  std::map<GridCell, std::vector<Point3>> laid;
  std::set<GridCell> around;
  std::size_t agreeing = 0;
  for (const Point3& p : first.points) {
    const Point3 q = map(p);
    laid[cell_of(q, reach)].push_back(q);
    if (!(std::abs(second.distances.at(q).mm) <= tolerance)) continue;
    ++agreeing;
    around.insert(cell_of(q, side_mm));
  }
  agreement.forward = static_cast<double>(agreeing) / static_cast<double>(first.points.size());
  agreement.backward =
      share_within(around, side_mm, second.points,
                   [&](const Point3& q) { return has_near(laid, q, reach); });
  return agreement;
}

}  // namespace octavo
