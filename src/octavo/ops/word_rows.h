// Words of 4 x 4 x 4 voxels in o-code order, and rows of voxels along x, one bit each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace octavo {

namespace word_rows_detail {

// The four bits of a row of a word, x = 0..3, at their places in the word.
inline constexpr std::array<std::uint64_t, 16> kRowPlaces = [] {
  std::array<std::uint64_t, 16> places{};
  for (std::uint64_t bits = 0; bits < 16; ++bits) {
    for (std::uint64_t x = 0; x < 4; ++x) {
      if ((bits >> x & 1) != 0) places[bits] |= std::uint64_t{1} << (16 * (x >> 1) + 2 * (x & 1));
    }
  }
  return places;
}();

// How far the row (y, z) of a word is from its first one.
constexpr int row_shift(int y, int z) noexcept {
  return 32 * (z >> 1) + 4 * (z & 1) + 8 * (y >> 1) + (y & 1);
}

}  // namespace word_rows_detail

/// The word at x = 4 * i of 64 x 4 x 4 voxels, whose 16 rows [z][y] are given as bits, x lowest
/// first.
inline std::uint64_t word_of_rows(const std::array<std::uint64_t, 16>& rows,
                                  std::int64_t i) noexcept {
  std::uint64_t word = 0;
  for (int z = 0; z < 4; ++z) {
    for (int y = 0; y < 4; ++y) {
      const std::uint64_t four = rows[static_cast<std::size_t>(4 * z + y)] >> 4 * i & 15;
      word |= word_rows_detail::kRowPlaces[four] << word_rows_detail::row_shift(y, z);
    }
  }
  return word;
}

/// The four voxels of a word in the row (y, z), x lowest first.
constexpr std::uint64_t row_of_word(std::uint64_t word, int y, int z) noexcept {
  const std::uint64_t bits = word >> word_rows_detail::row_shift(y, z);
  return (bits & 1) | (bits >> 1 & 2) | (bits >> 14 & 4) | (bits >> 15 & 8);
}

}  // namespace octavo
