// Measures of a mask that are sums over slabs of planes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/progress.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

/// Planes of a slab.
inline constexpr std::int64_t kSumPlanes = 16;

/// Slabs of so many planes.
constexpr std::int64_t sum_slab_count(std::int64_t planes) {
  return (planes + kSumPlanes - 1) / kSumPlanes;
}

/// The sum of measure(begin, end) over slabs of up to kSumPlanes of `planes`, in their order, so
/// that it does not depend on the threads, which are those of the calling task arena.
/// Throws  Error{cancelled}
template <class Sums, class Measure>
Sums sum_of_slabs(std::int64_t planes, Progress& progress, Measure&& measure) {
  const std::int64_t slabs = sum_slab_count(planes);
  std::vector<Sums> parts(static_cast<std::size_t>(slabs));
  parallel_for(std::int64_t{0}, slabs, [&](std::int64_t i) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    const std::int64_t begin = i * kSumPlanes;
    const std::int64_t end = std::min(begin + kSumPlanes, planes);
    parts[static_cast<std::size_t>(i)] = measure(begin, end);
    progress.advance(end - begin);
  });
  Sums all;
  for (const Sums& part : parts) all += part;
  return all;
}

}  // namespace octavo
