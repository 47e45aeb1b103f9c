// Finite floats in bins: one bin per code, in each of them floats counted by rank.
//
//     ranks   .. -2   -1   0   1    2  ..           every float in ascending order, -0 below +0
//     floats  .. -e   -0  +0   e   2e  ..           e the smallest positive one, 2^-149
//     bins    [.. code 3 ..)[ .. code 4 .. )[ ..    code c begins at (c - 1/2) * scale + offset
//
// Code and rank inside the bin give the float back bit by bit, whatever the scale is: bins are
// derived from scale and offset in binary64, every step rounded once. With a scale of 2^n and no
// offset a bin between two powers of two holds 2^k floats, whose ranks are k bits of their own.
//
// The first and the last bin take all that lies beyond them.
#pragma once

#include <cstdint>
#include <cstring>

#include "octavo/core/sample_coding.h"

namespace octavo::exact {

/// The rank of +infinity; the ranks of finite floats lie below it and above -1 - kInfinityRank.
inline constexpr std::int32_t kInfinityRank = 0x7f800000;
inline constexpr int kMantissaBits = 23;

/// Codes of voxels are of this magnitude at most: the index knows two more, for bounds.
inline constexpr std::int64_t kLargestBin = SampleCoding::kUnbounded - 1;

inline std::uint32_t bits_of(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}
inline float float_of_bits(std::uint32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

inline constexpr std::uint32_t kSignBit = 0x80000000;

inline std::int32_t rank_of(float value) {
  const std::uint32_t bits = bits_of(value);
  const auto magnitude = static_cast<std::int32_t>(bits & ~kSignBit);
  return bits == static_cast<std::uint32_t>(magnitude) ? magnitude : ~magnitude;
}

inline float float_of(std::int32_t rank) {
  return rank >= 0 ? float_of_bits(static_cast<std::uint32_t>(rank))
                   : float_of_bits(static_cast<std::uint32_t>(~rank) | kSignBit);
}

/// A rank as if the lowest `bits` bits of the mantissa, all 0, were not there.
constexpr std::int32_t short_rank(std::int32_t rank, int bits) {
  return rank >= 0 ? rank >> bits : ~(~rank >> bits);
}
constexpr std::int32_t whole_rank(std::int32_t rank, int bits) {
  return rank >= 0 ? rank << bits : ~(~rank << bits);
}

/// Ranks [first, end) of a bin; none where the bin lies between two floats.
struct FloatBin {
  std::int64_t first;
  std::int64_t end;

  bool contains(std::int64_t rank) const { return rank >= first && rank < end; }
  /// It begins or ends at zero, or zero is in it, and something else: it spans many exponents.
  bool is_central() const { return first <= 0 && end >= 0 && end - first > 1; }
};

class FloatBins {
 public:
  /// Requires a valid coding.
  explicit FloatBins(const SampleCoding& coding) : coding_(coding) {}

  /// The code of a finite value.
  std::int64_t code_of(float value) const;

  /// Code within +-kLargestBin. Ranks are short ones.
  FloatBin bin_of(std::int64_t code, int short_bits) const {
    return {short_first(code, short_bits), short_first(code + 1, short_bits)};
  }

 private:
  std::int32_t first_rank(std::int64_t code) const;
  std::int64_t short_first(std::int64_t code, int short_bits) const;

  SampleCoding coding_;
};

}  // namespace octavo::exact
