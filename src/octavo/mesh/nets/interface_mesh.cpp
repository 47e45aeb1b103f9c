#include "octavo/mesh/nets/interface_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <set>
#include <utility>

#include "octavo/core/vectors.h"
#include "octavo/mesh/point_distance.h"

namespace octavo {

namespace {

/// A corner of a polygon, and its fans.
struct PolygonCorner {
  std::uint32_t point = 0;
  std::uint32_t fans = 0;  // 4 bits
};

/// Makes triangles of quads.
class QuadCutter {
 public:
  QuadCutter(const SurfaceNet& net, std::span<const NetOffset> offsets, const SurfaceFrame& frame,
             InterfaceMesh& made)
      : net_(net), offsets_(offsets), frame_(frame), made_(made) {}

  void place_points() {
    made_.mesh.points.reserve(net_.points.size());
    if (offsets_.empty()) {
      for (const NetPoint& at : net_.points) {
        made_.mesh.points.push_back(frame_.point_at(at[0] - 0.5, at[1] - 0.5, at[2] - 0.5));
      }
      return;
    }
    for (std::uint32_t i = 0; i < net_.points.size(); ++i) {
      const Point3 place = index_place(i);
      made_.mesh.points.push_back(frame_.point_at(place[0], place[1], place[2]));
    }
  }

  void cut(const NetQuad& quad) {
    if (quad.crossed_sides == 0) {
      cut_in_two(quad);
      return;
    }
    std::array<PolygonCorner, 8> polygon;
    std::size_t count = 0;
    std::size_t first_middle = polygon.size();
    for (std::size_t k = 0; k < 4; ++k) {
      polygon[count++] = {quad.corners[k], quad.fan_at(k, 0) | quad.fan_at(k, 1) << 2};
      if (!quad.is_crossed(k)) continue;
      first_middle = std::min(first_middle, count);
      polygon[count++] = {middle_of(quad.corners[k], quad.corners[(k + 1) % 4]),
                          quad.side_fan_at(k, 0) | quad.side_fan_at(k, 1) << 2};
    }
    // From the middle of a side no triangle is flat
    for (std::size_t k = 1; k + 1 < count; ++k) {
      add(quad.pair, {polygon[first_middle], polygon[(first_middle + k) % count],
                      polygon[(first_middle + k + 1) % count]});
    }
  }

 private:
  /// The place of a point in the grid, voxels.
  Point3 index_place(std::uint32_t point) const {
    Point3 place;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = static_cast<double>(net_.points[point][axis]) - 0.5;
      if (!offsets_.empty()) place[axis] += static_cast<double>(offsets_[point][axis]);
    }
    return place;
  }

  /// At the shorter diagonal.
  void cut_in_two(const NetQuad& quad) {
    const std::size_t a = !offsets_.empty() && is_second_diagonal_shorter(quad) ? 1 : 0;
    const std::size_t c = a + 2;
    const std::size_t d = (a + 3) % 4;
    const auto fans_at = [&](std::size_t k) {
      return static_cast<std::uint32_t>(quad.corner_fans) >> 4 * k & 15;
    };
    const auto& p = quad.corners;
    made_.mesh.triangles.push_back({p[a], p[a + 1], p[c]});
    made_.mesh.triangles.push_back({p[a], p[c], p[d]});
    made_.pair_of.insert(made_.pair_of.end(), 2, quad.pair);
    const std::uint32_t ends = fans_at(a) | fans_at(c) << 4;
    made_.fans.push_back(static_cast<std::uint16_t>(fans_at(a) | fans_at(a + 1) << 4 |
                                                    fans_at(c) << 8));
    made_.fans.push_back(static_cast<std::uint16_t>(ends | fans_at(d) << 8));
  }

  std::uint32_t middle_of(std::uint32_t a, std::uint32_t b) {
    const auto [low, high] = std::minmax(a, b);
    const auto number = static_cast<std::uint32_t>(made_.mesh.points.size());
    const auto [found, is_new] = middles_.emplace(std::pair(low, high), number);
    if (is_new) {
      const Point3 middle = scaled(sum(index_place(low), index_place(high)), 0.5);
      made_.mesh.points.push_back(frame_.point_at(middle[0], middle[1], middle[2]));
    }
    return found->second;
  }

  bool is_second_diagonal_shorter(const NetQuad& quad) const {
    constexpr double kClearly = 1 - 1e-5;  // not by rounding
    const auto squared = [&](std::size_t a, std::size_t b) {
      const Point3 way = difference(place_of_point(made_.mesh.points[quad.corners[a]]),
                                    place_of_point(made_.mesh.points[quad.corners[b]]));
      return dot(way, way);
    };
    return squared(1, 3) < kClearly * squared(0, 2);
  }

  void add(std::uint32_t pair, const std::array<PolygonCorner, 3>& corners) {
    std::uint32_t fans = 0;
    for (std::size_t k = 0; k < 3; ++k) fans |= corners[k].fans << 4 * k;
    made_.mesh.triangles.push_back({corners[0].point, corners[1].point, corners[2].point});
    made_.pair_of.push_back(pair);
    made_.fans.push_back(static_cast<std::uint16_t>(fans));
  }

  const SurfaceNet& net_;
  std::span<const NetOffset> offsets_;
  const SurfaceFrame& frame_;
  InterfaceMesh& made_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles_;
};

}  // namespace

InterfaceMesh interface_mesh(const SurfaceNet& net, std::span<const NetOffset> offsets,
                             const SurfaceFrame& frame) {
  InterfaceMesh made;
  made.pairs = net.pairs;
  std::size_t count = 2 * net.quads.size();
  for (const NetQuad& quad : net.quads) {
    count += static_cast<std::size_t>(std::popcount(quad.crossed_sides));
  }
  made.mesh.triangles.reserve(count);
  made.pair_of.reserve(count);
  made.fans.reserve(count);
  QuadCutter cutter(net, offsets, frame, made);
  cutter.place_points();
  for (const NetQuad& quad : net.quads) cutter.cut(quad);
  return made;
}

LabelParts::LabelParts(const InterfaceMesh& interfaces)
    : interfaces_(interfaces), numbers_(interfaces.mesh.points.size(), kNone) {
  std::set<std::int64_t> labels;
  for (const LabelPair& pair : interfaces.pairs) labels.insert(pair.begin(), pair.end());
  labels.erase(0);
  labels_.assign(labels.begin(), labels.end());
  // Of each pair the places of its labels; behind all others that of 0.
  std::vector<std::array<std::size_t, 2>> places(interfaces.pairs.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t side = 0; side < 2; ++side) {
      const std::int64_t label = interfaces.pairs[i][side];
      const auto found = std::lower_bound(labels_.begin(), labels_.end(), label);
      places[i][side] =
          label == 0 ? labels_.size() : static_cast<std::size_t>(found - labels_.begin());
    }
  }
  ends_.assign(labels_.size() + 2, 0);
  for (const std::uint32_t pair : interfaces.pair_of) {
    for (const std::size_t place : places[pair]) ++ends_[place + 1];
  }
  for (std::size_t i = 1; i < ends_.size(); ++i) ends_[i] += ends_[i - 1];
  triangles_.resize(ends_[labels_.size()]);
  std::vector<std::size_t> next(ends_.begin(), ends_.end() - 1);
  for (std::size_t i = 0; i < interfaces.pair_of.size(); ++i) {
    for (const std::size_t place : places[interfaces.pair_of[i]]) {
      if (place < labels_.size()) triangles_[next[place]++] = static_cast<std::uint32_t>(i);
    }
  }
}

TriangleMesh LabelParts::cut(std::int64_t label) {
  const auto place = static_cast<std::size_t>(
      std::lower_bound(labels_.begin(), labels_.end(), label) - labels_.begin());
  const std::span<const std::uint32_t> own(triangles_.data() + ends_[place],
                                           ends_[place + 1] - ends_[place]);
  TriangleMesh part;
  part.triangles.reserve(own.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> others;  // by point and fan
  for (const std::uint32_t triangle : own) {
    const std::size_t side =
        interfaces_.pairs[interfaces_.pair_of[triangle]][0] == label ? 0 : 1;
    const MeshTriangle& corners = interfaces_.mesh.triangles[triangle];
    MeshTriangle& numbers = part.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t fan = interfaces_.fan_at(triangle, k, side);
      const auto next = static_cast<std::uint32_t>(part.points.size());
      std::uint32_t& number =
          fan == 0 ? numbers_[corners[k]]
                   : others.emplace(std::pair(corners[k], fan), kNone).first->second;
      if (number == kNone) {
        number = next;
        part.points.push_back(interfaces_.mesh.points[corners[k]]);
      }
      numbers[k] = number;
    }
    if (side == 1) std::swap(numbers[1], numbers[2]);
  }
  touching_.clear();
  for (const auto& [point_and_fan, number] : others) {
    touching_.push_back(number);
    if (numbers_[point_and_fan.first] != kNone) touching_.push_back(numbers_[point_and_fan.first]);
  }
  std::sort(touching_.begin(), touching_.end());
  touching_.erase(std::unique(touching_.begin(), touching_.end()), touching_.end());
  for (const std::uint32_t triangle : own) {
    for (const std::uint32_t point : interfaces_.mesh.triangles[triangle]) numbers_[point] = kNone;
  }
  return part;
}

std::map<std::int64_t, std::int64_t> voxel_counts(const SurfaceNet& net, bool is_mirrored) {
  std::vector<std::int64_t> of_pair(net.pairs.size());
  for (const NetQuad& quad : net.quads) {
    // Columns along x begin and end at faces across it.
    const NetPoint& a = net.points[quad.corners[0]];
    const NetPoint& b = net.points[quad.corners[1]];
    const NetPoint& d = net.points[quad.corners[3]];
    const std::int64_t turn = std::int64_t{b[1] - a[1]} * (d[2] - a[2]) -
                              std::int64_t{b[2] - a[2]} * (d[1] - a[1]);
    of_pair[quad.pair] += turn * a[0];
  }
  std::map<std::int64_t, std::int64_t> counts;
  for (std::size_t i = 0; i < of_pair.size(); ++i) {
    const std::int64_t inside = is_mirrored ? -of_pair[i] : of_pair[i];
    counts[net.pairs[i][0]] += inside;
    counts[net.pairs[i][1]] -= inside;
  }
  counts.erase(0);
  return counts;
}

}  // namespace octavo
