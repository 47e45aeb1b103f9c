// Which residual stands for which detail.
//
// Possible details have numbers 0 .. last, smallest first; `from` is that of the prediction.
// Residuals 0, -1, 1, -2, 2 .. stand for the details around it, a minus for those towards the
// middle, until the nearer end is met. From there on either sign, in the same order, stands for
// what is left on the other side: no residual is kept for a detail that cannot be.
#pragma once

#include <algorithm>

namespace octavo::grey {

/// The residual of number `to`. 0 <= from, to <= last
template <class Int>
constexpr Int folded(Int to, Int from, Int last) {
  if (from < last - from) return folded<Int>(last - to, last - from, last);
  const Int room = last - from;
  if (from - to <= room) return to - from;
  const Int left = last - to;
  return left >> 1 ^ -(left & 1);
}

/// The number of a residual; of one that is damaged, any within 0 .. last.
template <class Int>
constexpr Int unfolded(Int residual, Int from, Int last) {
  if (from < last - from) return last - unfolded<Int>(residual, last - from, last);
  const Int size = residual < 0 ? -residual : residual;
  if (size <= last - from) return from + residual;
  const Int left = residual < 0 ? 2 * size - 1 : 2 * size;
  return std::max<Int>(last - left, 0);
}

/// The same for details and predictions within +-limit.
template <class Int>
constexpr Int residual_of(Int detail, Int prediction, Int limit) {
  return folded<Int>(detail + limit, prediction + limit, 2 * limit);
}
template <class Int>
constexpr Int detail_of(Int residual, Int prediction, Int limit) {
  return unfolded<Int>(residual, prediction + limit, 2 * limit) - limit;
}

}  // namespace octavo::grey
