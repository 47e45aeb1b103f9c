// The segments of a brick as they stand in the file: in up to four pieces.
//
//     piece      0          1          2          3
//     segments   0          1          2          3 .. last, behind the lengths of all but the last
//
// The bytes of a brick grow eightfold from a level to the finer one: those of the coarsest levels
// are so few that one read, one length and one checksum do for all of them.
//
// Invariants
//   A last piece without bytes has no segments: the brick is uniform or stored (brick_codec.h).
//   The last segment of a piece with bytes has some.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "octavo/core/bytes.h"
#include "octavo/core/levels.h"

namespace octavo {

inline constexpr int kTierPieces = 4;

/// Pieces of the bricks of a tier of so many levels.
constexpr int piece_count(int level_count) {
  return level_count < kTierPieces ? level_count : kTierPieces;
}

/// The piece that holds the segment of an in-brick level.
constexpr int piece_of_level(int in_brick_level) {
  return in_brick_level < kTierPieces ? in_brick_level : kTierPieces - 1;
}

/// The pieces of a brick from all its segments, of which it has at least one; those behind
/// piece_count() are empty.
/// Throws Error{internal} where the last piece would hold segments, but not the last of them
std::array<Bytes, kTierPieces> encode_pieces(std::span<const Bytes> segments);

/// The segments of a brick of `level_count` levels, which point into its pieces; those in pieces
/// that are left empty are empty.
/// Throws Error{corrupt}
std::array<ByteSpan, kTierLevels> segments_of(std::span<const Bytes> pieces, int level_count);

}  // namespace octavo
