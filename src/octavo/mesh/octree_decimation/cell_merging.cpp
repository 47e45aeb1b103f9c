#include "octavo/mesh/octree_decimation/cell_merging.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

#include "octavo/core/vectors.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_shape.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/parallel_sort.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

constexpr std::uint32_t kNoNeighbor = CellSurface::kNone;
constexpr int kCellBrickLevel = CellSurface::kLevels;  // bricks are twice the largest cells

std::size_t corner_of(const MeshTriangle& t, std::uint32_t point) {
  return t[0] == point ? 0 : t[1] == point ? 1 : 2;
}

/// Merges groups of points of one cell at a time.
class CellMerger {
 public:
  CellMerger(CellSurface& surface, const CellRules& rules, std::vector<std::uint8_t>& is_in,
             std::vector<std::uint8_t>& is_seen)
      : surface_(surface), rules_(rules), is_in_(is_in), is_seen_(is_seen) {}

  /// points  of a cell of a level
  void merge(std::span<const std::uint32_t> points, int level) {
    for (const std::uint32_t point : points) is_in_[point] = 1;
    for (const std::uint32_t point : points) {
      if (is_in_[point] != 1) continue;
      find_group(point);
      if (group_.size() > 1 && try_group()) {
        surface_.levels[group_.front()] = static_cast<std::int8_t>(level);
      }
      for (const std::uint32_t member : group_) is_in_[member] = 0;
    }
  }

 private:
  /// One triangle beside the points, as it would be.
  struct NewTriangle {
    std::uint32_t number = 0;
    std::uint32_t a = 0;  // the corners that stay, behind the new point
    std::uint32_t b = 0;
    TrianglePlaces places;
  };

  template <class Visit>
  void visit_fan(std::uint32_t point, Visit visit) const {
    const std::uint32_t begin = surface_.fans[point];
    std::uint32_t triangle = begin;
    do {
      visit(triangle);
      triangle = surface_.across[triangle][corner_of(surface_.triangles[triangle], point)];
    } while (triangle != begin);
  }

  /// The points that hang together with one, and the triangles around them: 2 in is_in_ while a
  /// group is looked at.
  void find_group(std::uint32_t point) {
    group_.assign(1, point);
    around_.clear();
    is_in_[point] = 2;
    for (std::size_t i = 0; i < group_.size(); ++i) {
      visit_fan(group_[i], [&](std::uint32_t triangle) {
        if (std::exchange(is_seen_[triangle], std::uint8_t{1}) != 0) return;
        around_.push_back(triangle);
        for (const std::uint32_t other : surface_.triangles[triangle]) {
          if (is_in_[other] != 1) continue;
          is_in_[other] = 2;
          group_.push_back(other);
        }
      });
    }
    for (const std::uint32_t triangle : around_) is_seen_[triangle] = 0;
    std::sort(group_.begin(), group_.end());
  }

  bool try_group() {
    if (!keeps_topology()) return false;
    find_place();
    if (cost_ > rules_.tolerance * rules_.tolerance * quadric_.weight()) return false;
    if (!keeps_shapes() || !keeps_points()) return false;
    commit();
    return true;
  }

  bool is_member(std::uint32_t point) const { return is_in_[point] == 2; }

  /// Whether the group is a tree or a disk, around which the other corners make one ring.
  bool keeps_topology() {
    std::size_t inner = 0;   // triangles with all corners in the group
    std::size_t sides = 0;   // with both ends in it, each counted twice
    renewed_.clear();
    for (const std::uint32_t triangle : around_) {
      const MeshTriangle& t = surface_.triangles[triangle];
      const int count = int{is_member(t[0])} + int{is_member(t[1])} + int{is_member(t[2])};
      if (count == 3) ++inner;
      sides += count == 3 ? 3 : count == 2 ? 1 : 0;
      if (count > 1) continue;
      const std::size_t k = is_member(t[0]) ? 0 : is_member(t[1]) ? 1 : 2;
      renewed_.push_back({triangle, t[(k + 1) % 3], t[(k + 2) % 3], {}});
    }
    if (group_.size() + inner != sides / 2 + 1 || renewed_.size() < 3) return false;
    // The triangles in the order of the ring
    std::sort(renewed_.begin(), renewed_.end(),
              [](const NewTriangle& x, const NewTriangle& y) { return x.a < y.a; });
    ring_.clear();
    std::size_t at = 0;
    do {
      ring_.push_back(at);
      const std::uint32_t wanted = renewed_[at].b;
      const auto found = std::lower_bound(
          renewed_.begin(), renewed_.end(), wanted,
          [](const NewTriangle& t, std::uint32_t point) { return t.a < point; });
      if (found == renewed_.end() || found->a != wanted) return false;
      if (found + 1 != renewed_.end() && (found + 1)->a == wanted) return false;
      at = static_cast<std::size_t>(found - renewed_.begin());
    } while (at != 0 && ring_.size() <= renewed_.size());
    return ring_.size() == renewed_.size();
  }

  void find_place() {
    quadric_ = {};
    Point3 lo = surface_.places[group_.front()];
    Point3 hi = lo;
    Point3 middle = {0, 0, 0};
    for (const std::uint32_t point : group_) {
      const Point3& place = surface_.places[point];
      quadric_.add(surface_.quadrics[point]);
      middle = sum(middle, scaled(place, 1 / static_cast<double>(group_.size())));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lo[axis] = std::min(lo[axis], place[axis]);
        hi[axis] = std::max(hi[axis], place[axis]);
      }
    }
    const Point3 size = difference(hi, lo);
    const double margin = 0.5 * std::max({size[0], size[1], size[2]});
    place_ = quadric_.lowest_place(middle);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool is_near = place_[axis] >= lo[axis] - margin && place_[axis] <= hi[axis] + margin;
      if (!is_near) place_ = middle;
    }
    cost_ = quadric_.at(place_);
  }

  bool keeps_shapes() {
    const ShapeRule rule(rules_.tolerance);
    const auto places_before = [&](const NewTriangle& t) {
      const MeshTriangle& corners = surface_.triangles[t.number];
      return TrianglePlaces{surface_.places[corners[0]], surface_.places[corners[1]],
                            surface_.places[corners[2]]};
    };
    const auto around = [&] {
      Point3 normal = {0, 0, 0};
      for (const NewTriangle& t : renewed_) {
        normal = sum(normal, TriangleShape(places_before(t)).normal);
      }
      return normal;
    };
    for (NewTriangle& t : renewed_) {
      t.places = {place_, surface_.places[t.a], surface_.places[t.b]};
      if (!rule.renewed(places_before(t), t.places, around)) return false;
    }
    return true;
  }

  bool keeps_points() {
    const double most = rules_.tolerance * rules_.tolerance;
    moved_.clear();
    for (const std::uint32_t triangle : around_) {
      for (std::uint32_t point = surface_.first[triangle]; point != kNoNeighbor;
           point = surface_.next[point]) {
        double best = std::numeric_limits<double>::infinity();
        std::size_t best_place = 0;
        for (std::size_t i = 0; i < renewed_.size() && best > 0.1 * most; ++i) {
          const double own = squared_distance(rules_.full_places[point], renewed_[i].places);
          if (own >= best) continue;
          best = own;
          best_place = i;
        }
        if (best > most) return false;
        moved_.push_back({point, best_place});
      }
    }
    return true;
  }

  void commit() {
    const std::uint32_t kept = group_.front();
    surface_.places[kept] = place_;
    surface_.quadrics[kept] = quadric_;
    for (const std::uint32_t point : group_) surface_.owners[point] = kept;
    for (const std::uint32_t triangle : around_) {
      surface_.is_left[triangle] = 0;
      surface_.first[triangle] = kNoNeighbor;
    }
    for (std::size_t i = 0; i < ring_.size(); ++i) {
      const NewTriangle& t = renewed_[ring_[i]];
      const NewTriangle& behind = renewed_[ring_[(i + 1) % ring_.size()]];
      const NewTriangle& ahead = renewed_[ring_[(i + ring_.size() - 1) % ring_.size()]];
      MeshTriangle& corners = surface_.triangles[t.number];
      const std::size_t k = (corner_of(corners, t.a) + 2) % 3;
      corners[k] = kept;
      surface_.across[t.number][k] = ahead.number;
      surface_.across[t.number][(k + 2) % 3] = behind.number;
      surface_.is_left[t.number] = 1;
      surface_.fans[t.a] = t.number;
    }
    surface_.fans[kept] = renewed_.front().number;
    for (const auto& [point, place] : moved_) {
      std::uint32_t& first = surface_.first[renewed_[place].number];
      surface_.next[point] = std::exchange(first, point);
    }
  }

  CellSurface& surface_;
  const CellRules& rules_;
  std::vector<std::uint8_t>& is_in_;    // points: 1 of the cell, 2 of the group
  std::vector<std::uint8_t>& is_seen_;  // triangles
  std::vector<std::uint32_t> group_;
  std::vector<std::uint32_t> around_;   // triangles with a corner in the group
  std::vector<NewTriangle> renewed_;    // those with one, by their corners a
  std::vector<std::size_t> ring_;       // renewed_ in order around the group
  Quadric quadric_;
  Point3 place_{};
  double cost_ = 0;
  std::vector<std::pair<std::uint32_t, std::size_t>> moved_;  // full points, and places in renewed_
};

/// The points of bricks, ascending by their codes.
struct CellBricks {
  std::vector<std::uint32_t> order;
  std::vector<std::pair<std::size_t, std::size_t>> ranges;  // of order
};

CellBricks bricks_of(const CellSurface& surface, const CellRules& rules) {
  CellBricks bricks;
  for (std::uint32_t point = 0; point < surface.fans.size(); ++point) {
    if (surface.fans[point] == kNoNeighbor || rules.is_locked[point] != 0) continue;
    bricks.order.push_back(point);
  }
  parallel_sort(bricks.order, [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(rules.codes[a], a) < std::pair(rules.codes[b], b);
  });
  const auto brick_at = [&](std::size_t i) {
    return rules.codes[bricks.order[i]] >> (3 * kCellBrickLevel);
  };
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= bricks.order.size(); ++i) {
    if (i < bricks.order.size() && brick_at(i) == brick_at(begin)) continue;
    bricks.ranges.push_back({begin, i});
    begin = i;
  }
  return bricks;
}

}  // namespace

void merge_cells(CellSurface& surface, const CellRules& rules) {
  std::vector<std::uint8_t> is_in(surface.fans.size());
  std::vector<std::uint8_t> is_seen(surface.triangles.size());
  CellBricks bricks = bricks_of(surface, rules);
  PerThread<CellMerger> mergers(
      [&] { return CellMerger(surface, rules, is_in, is_seen); });
  for (int level = 0; level < CellSurface::kLevels; ++level) {
    const std::vector<std::uint64_t>& kept = rules.kept[static_cast<std::size_t>(level)];
    for (std::uint64_t color = 0; color < 8; ++color) {
      // Bricks of one color have others between them: what they change is apart.
      parallel_for(std::size_t{0}, bricks.ranges.size(), [&](std::size_t number) {
        auto& [begin, end] = bricks.ranges[number];
        const auto code_at = [&](std::size_t i) { return rules.codes[bricks.order[i]]; };
        if (begin == end || (code_at(begin) >> (3 * kCellBrickLevel)) % 8 != color) return;
        CellMerger& merger = mergers.local();
        std::size_t first = begin;
        for (std::size_t i = begin + 1; i <= end; ++i) {
          const std::uint64_t cell = code_at(first) >> (3 * level);
          if (i < end && code_at(i) >> (3 * level) == cell) continue;
          if (i - first > 1 && !std::binary_search(kept.begin(), kept.end(), cell)) {
            merger.merge({bricks.order.data() + first, i - first}, level);
          }
          first = i;
        }
        const auto from = bricks.order.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto to = bricks.order.begin() + static_cast<std::ptrdiff_t>(end);
        const auto left = std::remove_if(from, to, [&](std::uint32_t point) {
          return surface.owners[point] != point;
        });
        end = static_cast<std::size_t>(left - bricks.order.begin());
      });
    }
  }
}

}  // namespace octavo
