#include "octavo/ops/align/pose_agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr double kSameWay = 0.7;        // cosine between directions that count as the same
constexpr double kCellTolerances = 6;   // side of the cells that tell what lies around
constexpr double kSharpEdges = 0.5;
constexpr double kNearEdges = 4;
constexpr double kAloneEdges = 2;      // from where on a point outside has no counterpart
constexpr double kFewestAlone = 0.05;   // of the points

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

/// What the other surface is to a point.
struct OtherSurface {
  double mm = 0;  ///< above 0 outside of it
  bool faces_alike = false;
};

/// p, of one surface, is mapped to q.
OtherSurface other_surface(const PosedSurface& from, const Point3& p, const PosedSurface& to,
                           const Point3& q, const Affine& map, double within_mm) {
  OtherSurface other{to.distances.at(q).mm, false};
  if (!(std::abs(other.mm) <= within_mm)) return other;
  const Point3 own = turned_way(map, way_out(from.distances, p, from.voxel_mm));
  const Point3 way = way_out(to.distances, q, to.voxel_mm);
  other.faces_alike = dot(own, way) > kSameWay * std::sqrt(dot(own, own) * dot(way, way));
  return other;
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

/// Counts of distances that are near, and of those among them that are sharp.
class NearCounts {
 public:
  explicit NearCounts(double edge_mm) : edge_mm_(edge_mm) {}

  double near_mm() const { return kNearEdges * edge_mm_; }
  void add(double mm) {
    if (!(std::abs(mm) <= near_mm())) return;
    ++near_;
    if (std::abs(mm) <= kSharpEdges * edge_mm_) ++sharp_;
  }
  double sharpness() const {
    return near_ > 0 ? static_cast<double>(sharp_) / static_cast<double>(near_) : 0;
  }

 private:
  double edge_mm_;
  std::size_t near_ = 0;
  std::size_t sharp_ = 0;
};

Point3 middle_of_points(const std::vector<Point3>& points) {
  Point3 middle{};
  for (const Point3& p : points) {
    middle = sum(middle, scaled(p, 1 / static_cast<double>(points.size())));
  }
  return middle;
}

/// How well a plane across the way between their middles parts two sets of points.
double parting_of(const std::vector<Point3>& first, const std::vector<Point3>& second) {
  const Point3 across = difference(middle_of_points(first), middle_of_points(second));
  // Places along it, with what each is worth on its side: the first lie high.
  std::vector<std::pair<double, double>> places;
  for (const Point3& p : first) {
    places.emplace_back(dot(p, across), -0.5 / static_cast<double>(first.size()));
  }
  for (const Point3& p : second) {
    places.emplace_back(dot(p, across), 0.5 / static_cast<double>(second.size()));
  }
  std::sort(places.begin(), places.end());
  double parted = 0.5;  // with the plane below all
  double best = parted;
  for (const auto& [at, worth] : places) {
    parted += worth;
    best = std::max(best, parted);
  }
  return best;
}

}  // namespace

double sharpness_of(std::span<const double> distances_mm, double edge_mm) {
  NearCounts counts(edge_mm);
  for (const double mm : distances_mm) counts.add(mm);
  return counts.sharpness();
}

std::vector<Point3> facing_points(const PosedSurface& first, const PosedSurface& second,
                                  const Affine& map) {
  const double edge_mm = std::max(first.edge_mm * stretch_of(map), second.edge_mm);
  std::vector<Point3> facing;
  for (const Point3& p : first.points) {
    if (other_surface(first, p, second, map(p), map, kNearEdges * edge_mm).faces_alike) {
      facing.push_back(p);
    }
  }
  return facing;
}

PoseAgreement agreement_of(const PosedSurface& first, const PosedSurface& second,
                           const Affine& map) {
  PoseAgreement agreement;
  const auto back = inverse(map);
  if (!back) return agreement;
  const double scale = stretch_of(map);
  const double tolerance =
      std::clamp(first.voxel_mm * scale, second.voxel_mm, 2 * second.voxel_mm);
  const double coarser = std::max(first.edge_mm * scale, second.edge_mm);
  const double alone_mm = kAloneEdges * coarser;

  // Of the first, in the world of the second.
  NearCounts near(coarser);
  const double side_mm = kCellTolerances * tolerance;
  std::set<GridCell> around;
  std::vector<Point3> first_alone;
  std::size_t agreeing = 0;
  for (const Point3& p : first.points) {
    const Point3 q = map(p);
    const OtherSurface other = other_surface(first, p, second, q, map, near.near_mm());
    if (other.mm > alone_mm) first_alone.push_back(q);
    if (!other.faces_alike) continue;
    near.add(other.mm);
    if (std::abs(other.mm) > tolerance) continue;
    ++agreeing;
    around.insert(cell_of(q, side_mm));
  }
  agreement.forward = static_cast<double>(agreeing) / static_cast<double>(first.points.size());
  agreement.sharpness = near.sharpness();

  // Of the second, in its own.
  std::vector<Point3> second_alone;
  for (const Point3& q : second.points) {
    if (first.distances.at((*back)(q)).mm * scale > alone_mm) second_alone.push_back(q);
  }
  agreement.backward = share_within(around, side_mm, second.points, [&](const Point3& q) {
    const OtherSurface other =
        other_surface(second, q, first, (*back)(q), *back, tolerance / scale);
    return other.faces_alike;
  });
  const auto is_few = [](const std::vector<Point3>& alone, std::span<const Point3> of) {
    return static_cast<double>(alone.size()) < kFewestAlone * static_cast<double>(of.size());
  };
  agreement.has_both_alone =
      !is_few(first_alone, first.points) && !is_few(second_alone, second.points);
  if (agreement.has_both_alone) agreement.parting = parting_of(first_alone, second_alone);
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
  NearCounts near(second.edge_mm);
  for (const Point3& p : first.points) {
    const Point3 q = map(p);
    laid[cell_of(q, reach)].push_back(q);
    const double mm = second.distances.at(q).mm;
    near.add(mm);
    if (!(std::abs(mm) <= tolerance)) continue;
    ++agreeing;
    around.insert(cell_of(q, side_mm));
  }
  agreement.forward = static_cast<double>(agreeing) / static_cast<double>(first.points.size());
  agreement.sharpness = near.sharpness();
  agreement.backward =
      share_within(around, side_mm, second.points,
                   [&](const Point3& q) { return has_near(laid, q, reach); });
  return agreement;
}

}  // namespace octavo
