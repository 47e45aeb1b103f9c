#include "octavo/ops/morphometry/box_counts.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace octavo {

namespace {

/// The octants among 64 children that are neither empty nor full.
std::uint64_t mixed_octants(std::uint64_t any, std::uint64_t full) {
  std::uint64_t count = 0;
  for (int octant = 0; octant < 8; ++octant) {
    const std::uint64_t some = any >> 8 * octant & 0xff;
    const std::uint64_t all = full >> 8 * octant & 0xff;
    count += some != 0 && all != 0xff ? 1 : 0;
  }
  return count;
}

}  // namespace

std::vector<BoxCount> box_counts(const MaskTree& mask) {
  const std::vector<std::int64_t> leaves = leaf_counts(mask);
  std::vector<BoxCount> counts(static_cast<std::size_t>(2 * mask.rank_count()) + 4);
  // A word is an octant of level 2, its bytes are those of level 1; and so on by two levels a rank.
  counts[2].mixed = mask.words().size();
  for (const std::uint64_t word : mask.words()) counts[1].mixed += mixed_octants(word, word);
  for (int rank = 0; rank < mask.rank_count(); ++rank) {
    const auto level = static_cast<std::size_t>(2 * rank + 4);
    for (const MaskCube& cube : mask.cubes(rank)) {
      const std::uint64_t some = cube.full | cube.mixed;
      if (some != 0 && !cube.is_full()) ++counts[level].mixed;
      counts[level - 1].mixed += mixed_octants(some, cube.full);
    }
  }
  // The tree may end above the root of the volume.
  counts.resize(leaves.size());
  std::uint64_t in_leaves = 0;
  for (std::size_t k = counts.size(); k-- > 0;) {
    in_leaves = 8 * in_leaves + static_cast<std::uint64_t>(leaves[k]);
    counts[k].side = std::int64_t{1} << k;
    counts[k].holding = counts[k].mixed + in_leaves;
  }
  return counts;
}

std::optional<FractalFit> fractal_dimension(const std::vector<BoxCount>& counts, const Size3& size,
                                            bool of_surface) {
  const std::int64_t largest = std::min({size.x, size.y, size.z}) / 4;
  std::vector<std::array<double, 2>> points;  // logarithms of 1 / side and count
  FractalFit fit;
  for (const BoxCount& one : counts) {
    if (one.side < 2 || one.side > largest) continue;
    const std::uint64_t count = of_surface ? one.mixed : one.holding;
    if (count == 0) return std::nullopt;
    points.push_back({-std::log(static_cast<double>(one.side)),
                      std::log(static_cast<double>(count))});
    if (fit.smallest_side == 0) fit.smallest_side = one.side;
    fit.largest_side = one.side;
  }
  if (points.size() < 3) return std::nullopt;
  const auto n = static_cast<double>(points.size());
  double x = 0;
  double y = 0;
  for (const auto& p : points) {
    x += p[0] / n;
    y += p[1] / n;
  }
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const auto& p : points) {
    xx += (p[0] - x) * (p[0] - x);
    xy += (p[0] - x) * (p[1] - y);
    yy += (p[1] - y) * (p[1] - y);
  }
  fit.dimension = xy / xx;
  fit.r2 = yy > 0 ? xy * xy / (xx * yy) : 1;
  return fit;
}

}  // namespace octavo
