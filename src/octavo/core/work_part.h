// One of several parts of a work whose items stand in order: what a part does follows from its
// number alone, so that each can be done by itself, on any machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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
void require_part(const WorkPart& part);

/// Where the parts stand among `parts`, by their numbers.
/// Throws Error{invalid_argument} unless each part of one work is there once
std::vector<std::size_t> order_of_all_parts(std::span<const WorkPart> parts);

}  // namespace octavo
