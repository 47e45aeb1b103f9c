// Bits and Huffman codes of a JPEG scan, as far as it takes to step over its values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace octavo {

/// The bits of a scan, which end at the next mark or with the bytes; stuffed zeros are left out.
/// Source: ITU-T T.81, B.1.1.5 and F.2.2.5
class JpegBits {
 public:
  /// at  where the scan starts, at most bytes.size()
  JpegBits(std::span<const std::byte> bytes, std::size_t at) : bytes_(bytes), at_(at) {}

  /// The next 16 bits, with zeros behind the last one.
  unsigned ahead() {
    if (held_ < kMostSkipped) fill();
    return static_cast<unsigned>(window_ >> 48);
  }
  /// Steps over at most 16 bits; false where there are fewer, for they end before.
  bool skip(unsigned count) {
    if (held_ < count) fill();
    if (held_ < count) return false;
    window_ <<= count;
    held_ -= count;
    return true;
  }
  /// Leaves out what stands before the next mark, and steps over that. Bits behind it may follow.
  /// Returns  its second byte, 0 where there is none
  unsigned next_mark();
  /// How many bytes there are behind the last bit that was stepped over, marks among them.
  std::size_t bytes_left() const { return bytes_.size() - at_ + held_ / 8; }
  /// Where the bytes behind a mark start that was stepped over.
  std::size_t position() const { return at_; }

 private:
  static constexpr unsigned kMostSkipped = 16;

  void fill();

  std::span<const std::byte> bytes_;
  std::size_t at_;
  std::uint64_t window_ = 0;  // the next bits, the first of them on top
  unsigned held_ = 0;         // how many
  bool has_ended_ = false;    // at a mark or with the bytes
};

/// A Huffman table as it stands in the picture, which must outlive it.
struct JpegTable {
  std::span<const std::byte> counts;   ///< of codes of 1 to 16 bits
  std::span<const std::byte> symbols;  ///< as many as codes
};

/// The codes of a table.
class JpegCodes {
 public:
  /// Nothing where the counts are more than codes of these lengths can be.
  /// Source: ITU-T T.81, annex C
  static std::optional<JpegCodes> of(const JpegTable& table);

  /// Steps over a code and returns its symbol; nothing where the bits end before it does, or are
  /// none of the codes.
  std::optional<unsigned> take(JpegBits& bits) const;

 private:
  static constexpr unsigned kQuickBits = 9;
  static constexpr unsigned kMostBits = 16;

  /// length  0 where longer codes alone start like this
  struct Quick {
    std::uint8_t length = 0;
    std::uint8_t symbol = 0;
  };
  /// Codes of one length: `count` from `first` on, their symbols from `place` on.
  struct Length {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::uint32_t place = 0;
  };

  std::array<Quick, std::size_t{1} << kQuickBits> quick_{};
  std::array<Length, kMostBits + 1> lengths_{};
  std::span<const std::byte> symbols_;
};

}  // namespace octavo
