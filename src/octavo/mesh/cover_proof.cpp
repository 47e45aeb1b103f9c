#include "octavo/mesh/cover_proof.h"

#include <algorithm>
#include <cmath>

#include "octavo/core/vectors.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

namespace {

constexpr std::uint32_t kNotMet = TriangleTree::kNone;
constexpr std::size_t kMetSlots = 1024;  // at first
constexpr double kFarthest = 100;        // sides away, up to which margins are safe

}  // namespace

bool CoverProof::proves(const TrianglePlaces& triangle, std::uint32_t near) {
  if (!set_up(triangle)) return false;
  for (const std::uint32_t slot : slots_) met_[slot] = kNotMet;
  slots_.clear();
  waiting_.clear();
  if (met_.empty()) met_.assign(kMetSlots, kNotMet);
  for (const std::uint32_t first : fans_.of(near)) add(first);
  covers_ = 0;
  while (!waiting_.empty()) {
    const std::uint32_t next = waiting_.back();
    waiting_.pop_back();
    if (!visit(next)) return false;
  }
  return covers_ != 0;
}

/// Axes and sides of a triangle; false where it is too thin for them.
bool CoverProof::set_up(const TrianglePlaces& triangle) {
  constexpr double kThinnest = 1e-5;  // height of a triangle by its longest side
  origin_ = triangle[0];
  const Point3 ab = difference(triangle[1], origin_);
  const Point3 ac = difference(triangle[2], origin_);
  const Point3 bc = difference(triangle[2], triangle[1]);
  const double squared = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
  const Point3 normal = cross(ab, ac);
  const double area = std::sqrt(dot(normal, normal));
  if (!(area > kThinnest * squared)) return false;
  normal_ = scaled(normal, 1 / area);
  along_ = unit(ab);
  across_ = cross(normal_, along_);
  const std::array<std::array<double, 2>, 3> corners = {
      {{0, 0}, {dot(along_, ab), 0}, {dot(along_, ac), dot(across_, ac)}}};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& [u, v] = corners[k];
    const double du = corners[(k + 1) % 3][0] - u;
    const double dv = corners[(k + 1) % 3][1] - v;
    const double length = std::hypot(du, dv);
    sides_[k] = {-dv / length, du / length, (dv * u - du * v) / length};
  }
  // Not the middle, through which edges pass more often than through others.
  constexpr std::array<double, 3> kShares = {0.341, 0.329, 0.33};
  counted_ = {};
  for (std::size_t k = 0; k < 3; ++k) {
    counted_[0] += kShares[k] * corners[k][0];
    counted_[1] += kShares[k] * corners[k][1];
  }
  longest_ = std::sqrt(squared);
  margin_ = 1e-7 * distance_ + 1e-10 * longest_;
  return true;
}

CoverProof::Seen CoverProof::seen(std::uint32_t point) const {
  const Point3 from = difference(place_of_point(surface_.points[point]), origin_);
  Seen s{dot(along_, from), dot(across_, from), dot(normal_, from), {}};
  for (std::size_t k = 0; k < 3; ++k) {
    s.inside[k] = sides_[k][0] * s.along + sides_[k][1] * s.across + sides_[k][2];
  }
  return s;
}

/// False where a triangle of the surface shows that nothing can be proven.
bool CoverProof::visit(std::uint32_t triangle) {
  const MeshTriangle& numbers = surface_.triangles[triangle];
  const SeenTriangle t = {seen(numbers[0]), seen(numbers[1]), seen(numbers[2])};
  const auto is_beyond = [&](std::size_t i, std::size_t j, std::size_t side) {
    return t[i].inside[side] < -margin_ && t[j].inside[side] < -margin_;
  };
  for (std::size_t side = 0; side < 3; ++side) {
    if (is_beyond(0, 1, side) && t[2].inside[side] < -margin_) return true;
  }
  if (!is_low(t) || !count(t)) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if (is_beyond(i, j, 0) || is_beyond(i, j, 1) || is_beyond(i, j, 2)) continue;
    if (!visit_beside(numbers[i], numbers[j])) return false;
  }
  return true;
}

/// Whether a triangle is nowhere above or below the proven one farther than the distance.
bool CoverProof::is_low(const SeenTriangle& t) const {
  const auto is_low_at = [&](double height) { return std::abs(height) <= distance_; };
  if (is_low_at(t[0].height) && is_low_at(t[1].height) && is_low_at(t[2].height)) return true;

  // Cut it off at the sides
  struct Corner {
    std::array<double, 3> inside;
    double height;
  };
  std::array<Corner, 24> kept;  // at most twice as many at each side
  std::array<Corner, 24> cut;
  std::size_t count = 3;
  for (std::size_t k = 0; k < 3; ++k) kept[k] = {t[k].inside, t[k].height};
  for (std::size_t side = 0; side < 3; ++side) {
    std::size_t cut_count = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Corner& a = kept[i];
      const Corner& b = kept[(i + 1) % count];
      const double from = a.inside[side] + margin_;
      const double to = b.inside[side] + margin_;
      if (from >= 0) cut[cut_count++] = a;
      if ((from >= 0) == (to >= 0)) continue;
      // An edge along a side is not cut, which is safe.
      const double share = std::abs(from - to) < margin_ ? (from >= 0 ? 1 : 0) : from / (from - to);
      Corner& between = cut[cut_count++];
      for (std::size_t k = 0; k < 3; ++k) {
        between.inside[k] = a.inside[k] + share * (b.inside[k] - a.inside[k]);
      }
      between.height = a.height + share * (b.height - a.height);
    }
    std::swap(kept, cut);
    count = cut_count;
  }
  return std::all_of(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(count),
                     [&](const Corner& corner) { return is_low_at(corner.height); });
}

/// Counts a triangle that covers the counted place, by the side that is seen; false where it is not
/// clear whether it does.
bool CoverProof::count(const SeenTriangle& t) {
  const double far = kFarthest * (longest_ + distance_);
  double lowest = 0;
  double highest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Seen& a = t[i];
    const Seen& b = t[(i + 1) % 3];
    if (std::max(std::abs(a.along), std::abs(a.across)) > far) return false;
    const double turn = (b.along - a.along) * (counted_[1] - a.across) -
                        (b.across - a.across) * (counted_[0] - a.along);
    lowest = i == 0 ? turn : std::min(lowest, turn);
    highest = i == 0 ? turn : std::max(highest, turn);
  }
  const double safe = margin_ * longest_;
  if (lowest < -safe && highest > safe) return true;
  if (lowest > safe) ++covers_;
  else if (highest < -safe) --covers_;
  else return false;
  return true;
}

/// Adds the triangle at the other side of an edge; false where there is none.
bool CoverProof::visit_beside(std::uint32_t from, std::uint32_t to) {
  for (const std::uint32_t triangle : fans_.of(from)) {
    const MeshTriangle& t = surface_.triangles[triangle];
    if ((t[0] == to && t[1] == from) || (t[1] == to && t[2] == from) ||
        (t[2] == to && t[0] == from)) {
      add(triangle);
      return true;
    }
  }
  return false;
}

void CoverProof::add(std::uint32_t triangle) {
  if (2 * slots_.size() >= met_.size()) {
    std::vector<std::uint32_t> all;
    for (const std::uint32_t slot : slots_) all.push_back(met_[slot]);
    met_.assign(4 * met_.size(), kNotMet);
    slots_.clear();
    const std::vector<std::uint32_t> waiting = waiting_;
    for (const std::uint32_t met : all) add(met);
    waiting_ = waiting;
  }
  const std::size_t mask = met_.size() - 1;
  std::size_t at = (triangle * 0x9e3779b1u >> 7) & mask;
  while (met_[at] != kNotMet && met_[at] != triangle) at = (at + 1) & mask;
  if (met_[at] == triangle) return;
  met_[at] = triangle;
  slots_.push_back(static_cast<std::uint32_t>(at));
  waiting_.push_back(triangle);
}

}  // namespace octavo
