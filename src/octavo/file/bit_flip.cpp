#include "octavo/file/bit_flip.h"

#include <bit>
#include <cstdio>

namespace octavo {

std::optional<BitFlip> find_bit_flip(std::uint32_t found, std::uint32_t stored,
                                     std::uint64_t length) noexcept {
  if (length > kMaxSearchedBytes) return std::nullopt;
  constexpr std::uint32_t kReversedPolynomial = 0x82f63b78u;
  const std::uint32_t difference = found ^ stored;
  std::uint32_t state = 1;
  for (std::uint64_t byte = length; byte-- > 0;) {
    for (int bit = 7; bit >= 0; --bit) {
      state = state >> 1 ^ (state & 1 ? kReversedPolynomial : 0u);
      if (state == difference) return BitFlip{byte, bit};
    }
  }
  return std::nullopt;
}

bool is_safe_guess(std::uint64_t length, OtherProof proof) noexcept {
  switch (proof) {
    case OtherProof::none: return false;
    case OtherProof::range: return length <= kMaxPlainBits / 8;
    case OtherProof::content: return length <= kMaxCodedBits / 8;
    case OtherProof::checksums: return true;
  }
  return false;
}

std::optional<BitFlip> locate_bit_flip(std::uint32_t found, std::uint32_t stored,
                                       const CheckedBytes& place) noexcept {
  const std::uint32_t difference = found ^ stored;
  if (place.checksum_offset && std::has_single_bit(difference)) {
    const int bit = std::countr_zero(difference);
    return BitFlip{*place.checksum_offset + static_cast<std::uint64_t>(bit / 8), bit % 8};
  }
  auto flip = find_bit_flip(found, stored, place.length);
  if (flip) flip->byte += place.offset;
  return flip;
}

std::string describe_checksums(std::uint32_t found, std::uint32_t stored,
                               const CheckedBytes& place) {
  char text[64];
  std::snprintf(text, sizeof text, "checksum %08x, stored %08x", found, stored);
  std::string line = text;
  if (const auto flip = locate_bit_flip(found, stored, place)) {
    line += " (one flipped bit, byte " + std::to_string(flip->byte) + ")";
  }
  return line;
}

}  // namespace octavo
