// The reversible octant transform: means and details along one axis at a time.
//
// A pair (a, b) becomes its rounded mean m = floor((a + b + r) / 2) and its detail d = a - b. The
// parity of a + b is that of d, so m and d give the pair back exactly. The rounding term r is 0 or
// 1 and alternates from axis to axis and level to level, so that roundings up and down balance:
// without it the means would drift by about half a unit per level. A detail of 16-bit samples needs
// 17 bits.
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

/// The rounding term of the means along the axis at `place` of the axis order, from `level`
/// (global) to the next coarser one.
constexpr int rounding_term(int place, int level) { return (place + level + 1) & 1; }

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

/// The means of `fine` (dense [z][y][x] of `size`) along one axis; ceil(size / 2) samples there.
template <class Sample>
std::vector<Sample> means_along(const std::vector<Sample>& fine, const Size3& size, int axis,
                                int rounding);

/// The samples of the next coarser level: means along the axes of `mask`, in the given order.
/// level  global level of `fine`
template <class Sample>
std::vector<Sample> coarser_level(std::vector<Sample> fine, Size3 size, HalvingMask mask, int level,
                                  const AxisOrder& order = kStraightOrder);

}  // namespace octavo
