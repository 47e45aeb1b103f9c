#include "octavo/io/source/alternating_values.h"

#include <cstring>

namespace octavo {

void take_alternating(const Alternation& alternation, std::span<const std::byte> several,
                      std::span<std::byte> values) {
  const std::size_t value_bytes = alternation.value_bytes;
  const std::size_t stride = value_bytes * static_cast<std::size_t>(alternation.count);
  std::size_t from = value_bytes * static_cast<std::size_t>(alternation.index);
  for (std::size_t at = 0; at < values.size(); at += value_bytes, from += stride) {
    std::memcpy(values.data() + at, several.data() + from, value_bytes);
  }
}

}  // namespace octavo
