// Voxels from files of either byte order.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>

namespace octavo {

/// True when multi-byte values of a file of that order must be swapped on this machine.
constexpr bool needs_swap(bool file_is_big_endian) {
  return file_is_big_endian != (std::endian::native == std::endian::big);
}

/// Reverses the bytes of every value of `value_bytes` bytes. Requires a whole number of values.
inline void swap_values(std::span<std::byte> bytes, std::size_t value_bytes) {
  if (value_bytes < 2) return;
  for (std::size_t at = 0; at + value_bytes <= bytes.size(); at += value_bytes) {
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at + value_bytes));
  }
}

}  // namespace octavo
