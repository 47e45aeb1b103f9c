// How long the index of a volume can be: what follows from its size alone, before a byte of the
// index is read. docs/format.md, section 10.
#pragma once

#include <cstdint>

#include "octavo/core/levels.h"

namespace octavo {

inline constexpr std::int64_t kPageBricks = 1024;

/// What a page costs in the index root at least: length, CRC, two for the range, uniform count, one
/// total of pieces.
inline constexpr std::uint64_t kMinPageRefBytes = 9;

/// Lengths in bytes, both ends included.
struct LengthBounds {
  std::uint64_t min = 0;
  std::uint64_t max = 0;
  bool holds(std::uint64_t length) const { return length >= min && length <= max; }
};

/// Of an index page of so many bricks.
LengthBounds page_lengths(std::int64_t bricks);

/// Of all index pages of a volume.
LengthBounds pages_lengths(const Levels& levels);

/// Of the index root of a volume.
LengthBounds root_lengths(const Levels& levels);

/// The longest trailer of a slab of so many bricks and planes.
std::uint64_t max_slab_trailer_bytes(std::int64_t bricks, std::int64_t planes);

}  // namespace octavo
