#include "octavo/io/images/tiff_packed.h"

#include <cstring>

namespace octavo {

namespace {

template <class T>
void unpack_as(const PackedRow& packed, std::span<const std::byte> row,
               std::span<std::byte> values) {
  const auto bits = static_cast<std::size_t>(packed.bits);
  const std::size_t count = values.size() / sizeof(T);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t begin = (i * packed.step + packed.first) * bits;
    const std::size_t end = begin + bits;
    std::uint32_t window = 0;  // of at most three bytes
    for (std::size_t at = begin / 8; at * 8 < end; ++at) {
      window = window << 8 | std::to_integer<std::uint32_t>(row[at]);
    }
    const std::size_t behind = (8 - end % 8) % 8;
    const auto value = static_cast<T>(window >> behind & ((1U << bits) - 1));
    std::memcpy(values.data() + i * sizeof value, &value, sizeof value);
  }
}

}  // namespace

std::string packed_width_text(int bits) {
  return std::to_string(bits) + (bits == 1 ? " bit" : " bits");
}

void unpack_row(const PackedRow& packed, std::span<const std::byte> row,
                std::span<std::byte> values) {
  if (is_packed_byte(packed.bits)) return unpack_as<std::uint8_t>(packed, row, values);
  unpack_as<std::uint16_t>(packed, row, values);
}

}  // namespace octavo
