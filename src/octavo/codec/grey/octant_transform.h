// The reversible octant transform: means and details along one axis at a time.
//
// A pair (a, b) becomes its rounded mean m = floor((a + b + r) / 2) and its detail d = a - b. The
// parity of a + b is that of d, so m and d give the pair back exactly. The rounding term r is 0 or
// 1 and alternates from level to level along each axis, and from axis to axis, so that roundings up
// and down balance: the means of noise are expected at most 0.25 above the true ones (0.5 where no
// two axes are halved alike), where without it they would drift by about half a unit per level. A
// detail of 16-bit samples needs 17 bits.
//
// Where the volume ends inside a coarse sample, that sample is the mean of fewer voxels. The last
// pair along an axis may so have two weights, wa voxels and wb <= wa, and is lifted instead:
//
//      m = b + floor((wa d + (wa + wb - 1 + r) / 2) / (wa + wb))
//
// the weighted mean rounded to the nearest, of two down where r is 0 and up where it is 1. m and d
// give b back exactly, and b gives a. With equal weights this is the mean above.
//
// An octant is transformed along the axes of its level's halving mask, one after the other: x, y, z
// unless a model says otherwise. The lone sample at an odd edge is its own mean and has no detail.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/bytes.h"
#include "octavo/core/levels.h"

namespace octavo {

/// The rounding term of the means along `axis` of in-brick level `level`. Axes take turns in the
/// order in which they come to be halved: by how often they have been at the next level, those
/// halved as often as `order` has them.
int rounding_term(const BrickShape& shape, int level, int axis,
                  const AxisOrder& order = kStraightOrder);

/// The rounded mean of a pair. No overflow for samples of up to 33 bits held in 64-bit integers.
template <class Int>
constexpr Int pair_mean(Int a, Int b, int rounding) {
  return (a + b + rounding) >> 1;
}

/// The pair whose rounded mean is `mean` and whose difference a - b is `detail`.
template <class Int>
struct Pair {
  Int a;
  Int b;
};
template <class Int>
constexpr Pair<Int> pair_of(Int mean, Int detail, int rounding) {
  const Int sum = 2 * mean - rounding + ((detail + rounding) & 1);
  return {(sum + detail) >> 1, (sum - detail) >> 1};
}

/// How far the rounded mean of a pair of weights lies above its second sample. No overflow for
/// weights up to kMaxAxis and details of up to 34 bits.
constexpr std::int64_t mean_above_second(std::int64_t detail, const PairWeights& weights,
                                         int rounding) {
  const std::int64_t sum = weights.first + weights.second;
  const std::int64_t scaled = weights.first * detail + ((sum - 1 + rounding) >> 1);
  return scaled / sum - (scaled % sum < 0 ? 1 : 0);
}

/// The rounded mean of a pair of weights.
constexpr std::int64_t weighted_mean(std::int64_t a, std::int64_t b, const PairWeights& weights,
                                     int rounding) {
  return b + mean_above_second(a - b, weights, rounding);
}

/// The pair whose rounded mean by weights is `mean` and whose difference a - b is `detail`.
constexpr Pair<std::int64_t> weighted_pair_of(std::int64_t mean, std::int64_t detail,
                                              const PairWeights& weights, int rounding) {
  const std::int64_t b = mean - mean_above_second(detail, weights, rounding);
  return {b + detail, b};
}

/// The means of `fine` (dense [z][y][x] of `size`) along one axis; ceil(size / 2) samples there.
/// last_pair  the weights of the last pair
template <class Sample>
std::vector<Sample> means_along(const std::vector<Sample>& fine, const Size3& size, int axis,
                                int rounding, const PairWeights& last_pair = {});

/// The samples of in-brick level `level` + 1 of a brick from those of `level`: means along the
/// halved axes, in the given order.
template <class Sample>
std::vector<Sample> coarser_level(std::vector<Sample> fine, const BrickShape& shape, int level,
                                  const AxisOrder& order = kStraightOrder);

}  // namespace octavo
