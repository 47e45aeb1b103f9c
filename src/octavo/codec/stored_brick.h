// Bricks that coding would enlarge: segment 0 holds all their samples, the others are empty.
#pragma once

#include <algorithm>
#include <span>

#include "octavo/core/bytes.h"
#include "octavo/core/error.h"
#include "octavo/core/levels.h"

namespace octavo {

/// Whether a brick that is not uniform is stored.
/// segments  one per in-brick level; those that are not read may be empty, but not the coarsest
/// first     the finest in-brick level with details
/// Throws    Error{corrupt} when it has segments that it cannot have then
inline bool is_stored(const BrickShape& shape, std::span<const ByteSpan> segments, int first = 0) {
  const auto holds_bytes = [](ByteSpan segment) { return !segment.empty(); };
  if (shape.level_count - first == 1 || !segments.back().empty()) {
    if (std::any_of(segments.begin(), segments.begin() + first, holds_bytes)) {
      throw Error(ErrorKind::corrupt, "a level without details has bytes");
    }
    return false;
  }
  if (std::any_of(segments.begin() + 1, segments.end(), holds_bytes)) {
    throw Error(ErrorKind::corrupt, "a stored brick has more than one segment");
  }
  return true;
}

}  // namespace octavo
