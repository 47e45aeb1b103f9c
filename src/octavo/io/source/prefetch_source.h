// Reads planes ahead of whoever consumes them, on threads of its own.
#pragma once

#include <cstdint>
#include <memory>

#include "octavo/planes/plane_source.h"

namespace octavo {

struct PrefetchOptions {
  int threads = 0;                                        ///< 0: all cores
  std::uint64_t max_bytes = std::uint64_t{64} << 20;  ///< planes held ahead; at least two are held
};

/// Wraps `source`: the same planes in the same order, read ahead from the first one that is asked
/// for. Sources of separate files (DICOM,
/// TIFF, PNG stacks) are decoded by several threads at once, others by one. What a plane throws is
/// thrown when that plane is asked for; destroying the wrapper early stops and joins the threads.
/// Memory  options.max_bytes, or two planes
std::unique_ptr<PlaneSource> make_prefetch_source(std::unique_ptr<PlaneSource> source,
                                                  const PrefetchOptions& options);

}  // namespace octavo
