// Codes of PackBits, as TIFF and the run lengths of DICOM have them: a byte that says how many
// bytes follow as they are, or how often the one behind it comes.
#pragma once

#include <cstddef>

namespace octavo {

struct PackBitsCode {
  std::size_t taken = 0;  ///< bytes, with the one that it starts with
  std::size_t made = 0;   ///< bytes; none of a code that stands for nothing
};

/// Source: TIFF 6.0, section 9; DICOM PS3.5, annex G.
constexpr PackBitsCode packbits_code(std::byte first) {
  const auto number = std::to_integer<std::size_t>(first);
  if (number < 128) return {2 + number, 1 + number};
  if (number > 128) return {2, 257 - number};
  return {1, 0};
}

}  // namespace octavo
