// Sorting on the threads of the caller's arena.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <functional>
#include <vector>

#include "octavo/threads/arena.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

/// Sorts `values`; what is equal may end up in any order.
/// is_before  a strict weak order of two values, called on many threads at once
/// Memory     at most half as much again
template <class T, class Before = std::less<>>
void parallel_sort(std::vector<T>& values, const Before& is_before = {}) {
  // Parts are sorted, then joined in pairs.
  constexpr std::size_t kSmallest = 4096;
  std::size_t parts = std::bit_ceil(static_cast<std::size_t>(arena_threads()));
  while (parts > 1 && values.size() / parts < kSmallest) parts /= 2;
  const auto start_of = [&](std::size_t part, std::size_t count) {
    return values.begin() + static_cast<std::ptrdiff_t>(values.size() * part / count);
  };
  parallel_for(std::size_t{0}, parts, [&](std::size_t i) {
    std::sort(start_of(i, parts), start_of(i + 1, parts), is_before);
  });
  for (std::size_t left = parts / 2; left > 0; left /= 2) {
    parallel_for(std::size_t{0}, left, [&](std::size_t i) {
      std::inplace_merge(start_of(2 * i, 2 * left), start_of(2 * i + 1, 2 * left),
                         start_of(i + 1, left), is_before);
    });
  }
}

}  // namespace octavo
