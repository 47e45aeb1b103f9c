// Values of 1, 2 or 4 bits, as masks have them, and of 10, 12 or 14 bits, as scientific cameras
// write them, that stand side by side.
//
//     bits   | 0 .. 11 | 12 .. 23 | 24 .. 35 | .. |    the highest bit of each value first
//     bytes  |---0---|---1---|---2---|---3---|        each row begins with a byte
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace octavo {

/// Whether values of so many bits are read as packed ones.
constexpr bool is_packed_width(int bits) {
  return bits == 1 || bits == 2 || bits == 4 || bits == 10 || bits == 12 || bits == 14;
}

/// Whether such values become uint8, else uint16.
constexpr bool is_packed_byte(int bits) { return bits < 8; }

/// "1 bit", "12 bits".
std::string packed_width_text(int bits);

/// Bytes that so many values of a row take. Requires that bits * values is below 2^63
constexpr std::uint64_t packed_row_bytes(int bits, std::uint64_t values) {
  return (values * static_cast<std::uint64_t>(bits) + 7) / 8;
}

/// Of a row of values that take turns, of which every `step`-th is taken from `first` on.
struct PackedRow {
  int bits = 12;
  std::size_t step = 1;
  std::size_t first = 0;
};

/// Fills `values`, uint8 or uint16 in native order as is_packed_byte says, from a row.
/// Requires that `row` has packed_row_bytes of the last value taken
/// Source    TIFF 6.0, section 3 (BitsPerSample), section 8 (FillOrder)
void unpack_row(const PackedRow& packed, std::span<const std::byte> row,
                std::span<std::byte> values);

}  // namespace octavo
