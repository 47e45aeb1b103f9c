#include "octavo/file/bit_flip.h"

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

}  // namespace octavo
