#include "octavo/io/images/tiff_code_lengths.h"

#include <algorithm>
#include <array>

#include "octavo/io/source/packbits.h"

namespace octavo {

namespace {

/// What some programs fill up to an even length with.
constexpr std::size_t kMostBytesBehind = 3;

/// The codes of LZW, the most significant bit first.
class LzwCodes {
 public:
  explicit LzwCodes(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::size_t bits_left() const { return (bytes_.size() - at_) * 8 + held_; }
  /// The next code. Requires as many bits.
  unsigned take(unsigned width) {
    while (held_ < width) {
      window_ = window_ << 8 | std::to_integer<std::uint64_t>(bytes_[at_++]);
      held_ += 8;
    }
    held_ -= width;
    return static_cast<unsigned>(window_ >> held_) & ((1U << width) - 1);
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::uint64_t window_ = 0;
  unsigned held_ = 0;  // of its lowest bits
};

}  // namespace

std::optional<MadeBytes> lzw_bytes(std::span<const std::byte> coded, const WantedRows& wanted) {
  constexpr unsigned kClear = 256;
  constexpr unsigned kEnd = 257;
  constexpr unsigned kFirst = 258;
  constexpr unsigned kFirstWidth = 9;
  constexpr unsigned kLastWidth = 12;
  LzwCodes codes(coded);
  if (codes.bits_left() < kFirstWidth || codes.take(kFirstWidth) != kClear) return std::nullopt;
  std::array<std::uint64_t, std::size_t{1} << kLastWidth> lengths;
  std::fill_n(lengths.begin(), kFirst, 1);
  unsigned next = kFirst;  // code that gets a string
  unsigned width = kFirstWidth;
  std::uint64_t last = 0;  // length of the string before; 0: the table is clear
  MadeBytes made;
  while (made.count <= wanted.most) {
    const bool is_all = wanted.may_end(made.count) && codes.bits_left() <= 8 * kMostBytesBehind;
    if (is_all || codes.bits_left() < width) return made;
    const unsigned code = codes.take(width);
    if (code == kEnd) return made;
    if (code == kClear) {
      next = kFirst;
      width = kFirstWidth;
      last = 0;
      continue;
    }
    // The string of a new code is the one before with a byte more.
    if (last > 0 && next < lengths.size()) lengths[next++] = last + 1;
    if (code >= next || (last == 0 && code >= kClear)) {
      made.damage = "it has a code that stands for nothing";
      return made;
    }
    last = lengths[code];
    made.count += last;
    if (next + 1 >= 1U << width && width < kLastWidth) ++width;
  }
  return made;
}

MadeBytes packbits_bytes(std::span<const std::byte> coded, const WantedRows& wanted) {
  MadeBytes made;
  while (!coded.empty() && made.count <= wanted.most) {
    if (wanted.may_end(made.count) && coded.size() <= kMostBytesBehind) return made;
    const PackBitsCode code = packbits_code(coded.front());
    if (code.taken > coded.size()) {
      made.damage = "its last run is cut";
      return made;
    }
    made.count += code.made;
    coded = coded.subspan(code.taken);
  }
  return made;
}

}  // namespace octavo
