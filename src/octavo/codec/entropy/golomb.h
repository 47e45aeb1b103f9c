// Adaptive Exp-Golomb codes: the count of significant bits in unary, the second highest bit
// adaptively, the rest plain.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/codec/entropy/binary_coder.h"
#include "octavo/codec/entropy/byte_io.h"

namespace octavo {

/// What has been learned of one kind of number, each below 2^kMaxBits.
template <int kMaxBits>
struct GolombModel {
  static_assert(kMaxBits >= 2 && kMaxBits <= 33);
  std::array<AdaptiveBit, std::size_t{kMaxBits} + 1> length;
  std::array<AdaptiveBit, std::size_t{kMaxBits} + 1> second_bit;
};

/// Requires value < 2^kMaxBits.
template <int kMaxBits>
void put_golomb(BinaryEncoder& coder, GolombModel<kMaxBits>& model, std::uint64_t value) {
  const int bits = bit_length(value);
  for (int i = 0; i < kMaxBits; ++i) {
    put_adaptive(coder, model.length[static_cast<std::size_t>(i)], i == bits);
    if (i == bits) break;
  }
  if (bits < 2) return;
  put_adaptive(coder, model.second_bit[static_cast<std::size_t>(bits)],
               (value >> (bits - 2) & 1) != 0);
  coder.put_bits(static_cast<std::uint32_t>(value), bits - 2);
}

template <int kMaxBits>
std::uint64_t get_golomb(BinaryDecoder& coder, GolombModel<kMaxBits>& model) {
  int bits = 0;
  while (bits < kMaxBits && !get_adaptive(coder, model.length[static_cast<std::size_t>(bits)])) {
    ++bits;
  }
  if (bits < 2) return static_cast<std::uint64_t>(bits);
  const auto second = static_cast<std::uint64_t>(
      get_adaptive(coder, model.second_bit[static_cast<std::size_t>(bits)]));
  const std::uint64_t rest = coder.get_bits(bits - 2);
  return (2u | second) << (bits - 2) | rest;
}

}  // namespace octavo
