#include "octavo/io/source/jpeg_codes.h"

#include <algorithm>

namespace octavo {

void JpegBits::fill() {
  constexpr std::byte kMark{0xff};
  while (held_ <= 56 && !has_ended_) {
    std::size_t next = at_;
    while (next < bytes_.size() && bytes_[next] == kMark) ++next;
    const bool is_stuffed = next > at_ && next < bytes_.size() && bytes_[next] == std::byte{0};
    has_ended_ = next == bytes_.size() || (next > at_ && !is_stuffed);
    if (has_ended_) return;
    const std::byte value = is_stuffed ? kMark : bytes_[next];
    window_ |= std::to_integer<std::uint64_t>(value) << (56 - held_);
    held_ += 8;
    at_ = next + 1;
  }
}

unsigned JpegBits::next_mark() {
  constexpr std::byte kMark{0xff};
  window_ = 0;
  held_ = 0;
  has_ended_ = false;
  while (at_ < bytes_.size()) {
    const bool is_behind = bytes_[at_++] == kMark;
    while (is_behind && at_ < bytes_.size() && bytes_[at_] == kMark) ++at_;
    if (!is_behind || at_ == bytes_.size()) continue;
    const auto mark = std::to_integer<unsigned>(bytes_[at_++]);
    if (mark != 0) return mark;
  }
  return 0;
}

std::optional<JpegCodes> JpegCodes::of(const JpegTable& table) {
  JpegCodes codes;
  codes.symbols_ = table.symbols;
  std::uint32_t code = 0;
  std::uint32_t place = 0;
  for (unsigned length = 1; length <= kMostBits; ++length) {
    const auto count = std::to_integer<std::uint32_t>(table.counts[length - 1]);
    if (code + count > std::uint32_t{1} << length) return std::nullopt;
    codes.lengths_[length] = {code, count, place};
    for (std::uint32_t i = 0; length <= kQuickBits && i < count; ++i) {
      const Quick quick = {static_cast<std::uint8_t>(length),
                           std::to_integer<std::uint8_t>(table.symbols[place + i])};
      const std::size_t same = std::size_t{1} << (kQuickBits - length);
      std::fill_n(codes.quick_.begin() + static_cast<std::ptrdiff_t>((code + i) * same), same,
                  quick);
    }
    code = (code + count) << 1;
    place += count;
  }
  return codes;
}

std::optional<unsigned> JpegCodes::take(JpegBits& bits) const {
  const unsigned ahead = bits.ahead();
  const Quick quick = quick_[ahead >> (kMostBits - kQuickBits)];
  if (quick.length > 0) {
    return bits.skip(quick.length) ? std::optional<unsigned>(quick.symbol) : std::nullopt;
  }
  for (unsigned length = kQuickBits + 1; length <= kMostBits; ++length) {
    const std::uint32_t code = ahead >> (kMostBits - length);
    const Length& those = lengths_[length];
    if (code < those.first || code - those.first >= those.count) continue;
    if (!bits.skip(length)) return std::nullopt;
    return std::to_integer<unsigned>(symbols_[those.place + code - those.first]);
  }
  return std::nullopt;
}

}  // namespace octavo
