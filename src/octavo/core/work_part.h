// One of several parts of a work whose items stand in order: what a part does follows from its
// number alone, so that each can be done by itself, on any machine.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/core/error.h"

namespace octavo {

/// Part `number` of `count`; the only one by default.
struct WorkPart {
  static constexpr std::int64_t kMostParts = 65536;

  std::int64_t number = 0;  ///< from 0
  std::int64_t count = 1;

  /// The items [begin_of, end_of) of `total` are those of this part: as many as those of the
  /// others, or one more. Requires a total below 2^46
  std::int64_t begin_of(std::int64_t total) const { return total * number / count; }
  std::int64_t end_of(std::int64_t total) const { return total * (number + 1) / count; }
  bool is_last() const { return number + 1 == count; }

  friend bool operator==(const WorkPart&, const WorkPart&) = default;
};

/// Throws Error{invalid_argument} unless 0 <= number < count <= kMostParts.
inline void require_part(const WorkPart& part) {
  if (part.number >= 0 && part.number < part.count && part.count <= WorkPart::kMostParts) return;
  throw Error(ErrorKind::invalid_argument,
              "part " + std::to_string(part.number) + " of " + std::to_string(part.count) +
                  ": parts are numbered from 0, and at most " +
                  std::to_string(WorkPart::kMostParts));
}

}  // namespace octavo
