// Rows of voxels along x out of words of 4 x 4 x 4 voxels in o-code order.
#pragma once

#include <cstdint>

namespace octavo {

namespace word_rows_detail {

// How far the row (y, z) of a word is from its first one.
constexpr int row_shift(int y, int z) noexcept {
  return 32 * (z >> 1) + 4 * (z & 1) + 8 * (y >> 1) + (y & 1);
}

}  // namespace word_rows_detail

/// The four voxels of a word in the row (y, z), x lowest first.
constexpr std::uint64_t row_of_word(std::uint64_t word, int y, int z) noexcept {
  const std::uint64_t bits = word >> word_rows_detail::row_shift(y, z);
  return (bits & 1) | (bits >> 1 & 2) | (bits >> 14 & 4) | (bits >> 15 & 8);
}

}  // namespace octavo
