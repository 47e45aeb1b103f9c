#include "octavo/render/rays/octree_nodes.h"

#include <algorithm>
#include <utility>

#include "octavo/octree/o_code.h"

namespace octavo {

namespace {

constexpr std::int64_t kSeenWeight = 16;  // of a brick of which nothing is seen: 1

/// Nodes of up to 2^level bricks along a side that one rank owns.
class NodeSplitter {
 public:
  NodeSplitter(const std::vector<std::pair<std::uint64_t, int>>& owners,
               std::vector<OctreeNode>& out)
      : owners_(owners), out_(out) {}

  /// first, end  of the bricks in the node, by code
  void split(const Index3& lo, int level, std::size_t first, std::size_t end) {
    if (first == end) return;
    const int rank = owners_[first].second;
    if (owners_[end - 1].second == rank) {
      out_.push_back({rank, lo, std::int64_t{1} << level});
      return;
    }
    const std::int64_t half = std::int64_t{1} << (level - 1);
    for (int octant = 0; octant < 8; ++octant) {
      const Index3 corner = deinterleave(static_cast<std::uint64_t>(octant));
      const Index3 at{lo.x + corner.x * half, lo.y + corner.y * half, lo.z + corner.z * half};
      const std::uint64_t begin_code = interleave(at);
      const std::uint64_t end_code = begin_code + (std::uint64_t{1} << 3 * (level - 1));
      split(at, level - 1, place_of(begin_code, first, end), place_of(end_code, first, end));
    }
  }

 private:
  std::size_t place_of(std::uint64_t code, std::size_t first, std::size_t end) const {
    const auto begin = owners_.begin();
    const auto at = std::lower_bound(
        begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(end), code,
        [](const auto& owner, std::uint64_t of) { return owner.first < of; });
    return static_cast<std::size_t>(at - begin);
  }

  const std::vector<std::pair<std::uint64_t, int>>& owners_;
  std::vector<OctreeNode>& out_;
};

}  // namespace

std::vector<OctreeNode> share_octree(const Size3& grid, const std::vector<bool>& is_seen,
                                     int ranks) {
  // Bricks in Morton order, as much for each rank.
  std::vector<std::pair<std::uint64_t, std::int64_t>> weights;
  std::int64_t all = 0;
  visit_cells(box_of(grid), {1, 1, 1}, [&](const Index3& brick) {
    const auto number = static_cast<std::size_t>((brick.z * grid.y + brick.y) * grid.x + brick.x);
    weights.emplace_back(interleave(brick), is_seen[number] ? kSeenWeight : 1);
    all += weights.back().second;
    return true;
  });
  std::sort(weights.begin(), weights.end());
  std::vector<std::pair<std::uint64_t, int>> owners;
  std::int64_t before = 0;
  for (const auto& [code, weight] : weights) {
    // By the middle of each brick.
    const std::int64_t rank = (2 * before + weight) * ranks / (2 * all);
    owners.emplace_back(code, static_cast<int>(std::min<std::int64_t>(rank, ranks - 1)));
    before += weight;
  }

  int level = 0;
  while ((std::int64_t{1} << level) < std::max({grid.x, grid.y, grid.z})) ++level;
  std::vector<OctreeNode> nodes;
  NodeSplitter(owners, nodes).split({0, 0, 0}, level, 0, owners.size());
  return nodes;
}

std::vector<OctreeNode> nodes_in_order(std::vector<OctreeNode> nodes, const RayFrame& frame,
                                       std::int64_t brick_side) {
  // At the octant where two part, what is nearer along the first axis that parts them goes first:
  // of each axis the side of the eye, or the one that rays begin at.
  const auto is_low_first = [&](int axis, std::int64_t plane) {
    const auto i = static_cast<std::size_t>(axis);
    if (frame.eye_pixels > 0) return frame.origin[i] < static_cast<float>(plane * brick_side);
    return frame.direction[i] > 0;
  };
  const auto comes_before = [&](const OctreeNode& a, const OctreeNode& b) {
    // The smallest node that holds both.
    int level = 0;
    const auto parts = [&](int axis) { return a.lo[axis] >> level != b.lo[axis] >> level; };
    while (parts(0) || parts(1) || parts(2)) ++level;
    if (level == 0) return false;
    for (int axis = 2; axis >= 0; --axis) {
      const std::int64_t half_a = a.lo[axis] >> (level - 1);
      const std::int64_t half_b = b.lo[axis] >> (level - 1);
      if (half_a == half_b) continue;
      const std::int64_t plane = std::max(half_a, half_b) << (level - 1);
      return is_low_first(axis, plane) == (half_a < half_b);
    }
    return false;
  };
  std::sort(nodes.begin(), nodes.end(), comes_before);
  return nodes;
}

std::vector<RayRegion> regions_in(const OctreeNode& node, std::span<const RayRegion> regions,
                                  std::int64_t brick_side) {
  std::vector<RayRegion> inside;
  for (RayRegion region : regions) {
    bool is_empty = false;
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const auto low = static_cast<float>(node.lo[axis] * brick_side);
      const auto high = static_cast<float>((node.lo[axis] + node.side) * brick_side);
      // What lies before the first sample is the first brick's.
      if (node.lo[axis] > 0) region.low[i] = std::max(region.low[i], low);
      region.high[i] = std::min(region.high[i], high);
      is_empty = is_empty || !(region.low[i] < region.high[i]);
    }
    if (!is_empty) inside.push_back(region);
  }
  return inside;
}

}  // namespace octavo
