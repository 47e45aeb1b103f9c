// In which cells of a brick anything may be seen, a bit each: what rays look at together before
// they look at samples.
//
//     bounds of values  ->  ranges of values in which nothing is seen, not between any two of them
//     cell              ->  empty where the samples around it lie in one range
//     bit               ->  whether any of the kSeenSide^2 cells from there on, side by side along
//                           y and z, is not empty
//
// Cells that touch share samples: where all of a box are empty one range holds all of its values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "octavo/render/rays/sample_source.h"

namespace octavo {

/// Values between any two of which nothing is seen; both ends belong to them.
struct UnseenRange {
  float first = 0;
  float last = 0;
};

/// Ranges of values of volumes that run from `all.lowest` to `all.highest`, in order, at most 8.
/// is_seen  whether anything is seen between two values; of a part of them no more than of all
/// margin   that values of a range stay from what is seen
std::vector<UnseenRange> unseen_ranges(
    const SampleRange& all, float margin,
    const std::function<bool(float lowest, float highest)>& is_seen);

/// The samples of a brick, x fastest, and what is known of its cubes.
template <class Pooled>
struct SeenBrick {
  const Pooled* samples = nullptr;      ///< its first one; those next to its last ones count
  std::ptrdiff_t row = 0;               ///< samples from a row to the next
  std::ptrdiff_t plane = 0;             ///< from a plane to the next
  int shift = 0;                        ///< its side is 1 << shift, at least 8
  const float* cube_bounds = nullptr;   ///< empty where not above 0; none: they say nothing more
};

/// For the cells of a brick.
constexpr std::size_t seen_bytes(int shift) { return std::size_t{1} << (3 * shift - 3); }

/// Sets the bytes of a brick, as in BrickTables; Pooled is std::int16_t or float.
template <class Pooled>
void mark_seen_cells(const SeenBrick<Pooled>& brick, std::span<const UnseenRange> ranges,
                     std::uint8_t* bytes);

}  // namespace octavo
