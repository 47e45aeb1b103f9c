#include "octavo/mesh/nets/net_smoothing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

/// Along and against each axis.
constexpr std::size_t kWaysOut = 6;
constexpr float kInwardShare = 0.5f;
constexpr float kOutwardShare = -0.5f;
/// Points of different corners stay apart when they are rounded.
constexpr float kLongest = 0.5f - 1.0f / 256;

/// The points beside one, by direction.
struct NetNeighbors {
  std::array<std::uint32_t, kWaysOut> points{};
  std::array<std::uint8_t, kWaysOut> quad_counts{};  // at the edge to each; 0: no edge

  bool is_junction(std::size_t direction) const { return quad_counts[direction] > 2; }
};

std::size_t direction_of(const NetPoint& from, const NetPoint& to) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (to[axis] != from[axis]) return 2 * axis + (to[axis] > from[axis] ? 1 : 0);
  }
  return 0;
}

std::vector<NetNeighbors> neighbors_of(const SurfaceNet& net) {
  std::vector<NetNeighbors> neighbors(net.points.size());
  for (const NetQuad& quad : net.quads) {
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t from = quad.corners[k];
      const std::uint32_t to = quad.corners[(k + 1) % 4];
      const std::size_t direction = direction_of(net.points[from], net.points[to]);
      neighbors[from].points[direction] = to;
      ++neighbors[from].quad_counts[direction];
      neighbors[to].points[direction ^ 1] = from;
      ++neighbors[to].quad_counts[direction ^ 1];
    }
  }
  // Lines that end are no lines: their last points follow all around them.
  for (NetNeighbors& own : neighbors) {
    std::size_t count = 0;
    for (std::size_t d = 0; d < kWaysOut; ++d) count += own.is_junction(d) ? 1u : 0u;
    for (std::size_t d = 0; d < kWaysOut; ++d) {
      if (count >= 2 && !own.is_junction(d)) own.quad_counts[d] = 0;
    }
  }
  return neighbors;
}

NetOffset moved(const NetNeighbors& own, const std::vector<NetOffset>& offsets, std::size_t point,
                float share) {
  NetOffset sum{};
  float count = 0;
  for (std::size_t d = 0; d < kWaysOut; ++d) {
    if (own.quad_counts[d] == 0) continue;
    const NetOffset& other = offsets[own.points[d]];
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += other[axis];
    sum[d / 2] += d % 2 != 0 ? 1.0f : -1.0f;
    ++count;
  }
  NetOffset result = offsets[point];
  if (count == 0) return result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float wanted = result[axis] + share * (sum[axis] / count - result[axis]);
    result[axis] = std::clamp(wanted, -kLongest, kLongest);
  }
  return result;
}

double squared_move(const NetOffset& offset, const Geometry& geometry) {
  double squared = 0;
  for (std::size_t row = 0; row < 3; ++row) {
    double moved = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      moved += geometry.direction[3 * row + axis] * geometry.spacing_mm[axis] *
               static_cast<double>(offset[axis]);
    }
    squared += moved * moved;
  }
  return squared;
}

}  // namespace

std::vector<NetOffset> smoothed_offsets(const SurfaceNet& net, int steps) {
  std::vector<NetOffset> offsets(net.points.size());
  if (steps <= 0) return offsets;
  const std::vector<NetNeighbors> neighbors = neighbors_of(net);
  std::vector<NetOffset> next(offsets.size());
  for (int step = 0; step < steps; ++step) {
    for (const float share : {kInwardShare, kOutwardShare}) {
      parallel_parts(std::size_t{0}, offsets.size(), 4096,
                     [&](std::size_t begin, std::size_t end) {
                       for (std::size_t i = begin; i < end; ++i) {
                         next[i] = moved(neighbors[i], offsets, i, share);
                       }
                     });
      offsets.swap(next);
    }
  }
  return offsets;
}

std::map<std::int64_t, double> longest_moves_mm(const SurfaceNet& net,
                                                const std::vector<NetOffset>& offsets,
                                                const Geometry& geometry) {
  std::vector<double> of_pair(net.pairs.size());
  for (const NetQuad& quad : net.quads) {
    if (offsets.empty()) break;
    double& longest = of_pair[quad.pair];
    for (const std::uint32_t point : quad.corners) {
      longest = std::max(longest, squared_move(offsets[point], geometry));
    }
  }
  std::map<std::int64_t, double> moves;
  for (std::size_t i = 0; i < of_pair.size(); ++i) {
    for (const std::int64_t label : net.pairs[i]) {
      if (label != 0) moves[label] = std::max(moves[label], std::sqrt(of_pair[i]));
    }
  }
  return moves;
}

}  // namespace octavo
