#include "octavo/io/dicom/picture_head.h"

#include <algorithm>
#include <array>

namespace octavo {

namespace {

// Start of codestream, image and tile size: always the first two marks.
constexpr std::array kStart = {std::byte{0xff}, std::byte{0x4f}, std::byte{0xff}, std::byte{0x51}};
// Behind kStart: length, capabilities, then numbers of 32 bits.
constexpr std::size_t kWidthAt = 8;
constexpr std::size_t kHeightAt = 12;
constexpr std::size_t kLeftAt = 16;
constexpr std::size_t kTopAt = 20;
constexpr std::size_t kComponentsAt = 40;
// A component: sign and bits, then the distances of its samples.
constexpr std::size_t kBitsAt = 42;
constexpr std::size_t kAcrossAt = 43;
constexpr std::size_t kDownAt = 44;
constexpr std::size_t kEnd = 45;
// Of a JPEG frame header, behind its length.
constexpr std::size_t kJpegBitsAt = 2;

std::uint64_t extent_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (const std::byte b : bytes.subspan(at, 4)) value = value << 8 | std::to_integer<unsigned>(b);
  return value;
}

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<std::uint32_t>(bytes[at]) << 8 |
         std::to_integer<std::uint32_t>(bytes[at + 1]);
}

/// Samples of a component that stand `step` apart on the reference grid from `first` to `end`.
std::uint32_t samples_between(std::uint64_t first, std::uint64_t end, std::uint64_t step) {
  const std::uint64_t before = (first + step - 1) / step;
  const std::uint64_t all = (end + step - 1) / step;
  return static_cast<std::uint32_t>(all > before ? all - before : 0);
}

std::optional<PictureHead> jpeg2000_head(std::span<const std::byte> bytes) {
  const auto start = std::search(bytes.begin(), bytes.end(), kStart.begin(), kStart.end());
  const std::span<const std::byte> head(start, bytes.end());
  if (head.size() < kEnd) return std::nullopt;
  const auto across = std::to_integer<std::uint64_t>(head[kAcrossAt]);
  const auto down = std::to_integer<std::uint64_t>(head[kDownAt]);
  if (across == 0 || down == 0) return std::nullopt;
  const auto bits = std::to_integer<unsigned>(head[kBitsAt]);
  return PictureHead{samples_between(extent_at(head, kLeftAt), extent_at(head, kWidthAt), across),
                     samples_between(extent_at(head, kTopAt), extent_at(head, kHeightAt), down),
                     (bits & 0x7fU) + 1, (bits & 0x80U) != 0, word_at(head, kComponentsAt)};
}

/// Marks that stand alone, without a length: of restarts, of the start, and for private use.
bool has_no_length(unsigned mark) {
  return (mark >= 0xd0 && mark <= 0xd8) || mark == 0x01;
}

/// A frame header of JPEG in any of its processes, or of JPEG-LS.
bool starts_frame(unsigned mark) {
  const bool is_table = mark == 0xc4 || mark == 0xc8 || mark == 0xcc;
  return (mark >= 0xc0 && mark <= 0xcf && !is_table) || mark == 0xf7;
}

/// A frame header behind its mark; it is whole.
struct FramePlace {
  unsigned mark = 0;
  std::size_t at = 0;
};

std::optional<FramePlace> find_frame(std::span<const std::byte> bytes) {
  constexpr unsigned kScan = 0xda;
  constexpr std::size_t kFrameBytes = 8;
  std::size_t at = 0;
  while (at + 2 <= bytes.size() && bytes[at] == std::byte{0xff}) {
    const auto mark = std::to_integer<unsigned>(bytes[at + 1]);
    if (mark == 0xff) {  // a byte that fills
      ++at;
      continue;
    }
    at += 2;
    if (has_no_length(mark)) continue;
    if (mark == kScan || at + kFrameBytes > bytes.size()) return std::nullopt;
    if (starts_frame(mark)) return FramePlace{mark, at};
    at += word_at(bytes, at);
  }
  return std::nullopt;
}

std::optional<PictureHead> jpeg_head(std::span<const std::byte> bytes) {
  const std::optional<FramePlace> frame = find_frame(bytes);
  if (!frame) return std::nullopt;
  return PictureHead{word_at(bytes, frame->at + 5), word_at(bytes, frame->at + 3),
                     std::to_integer<std::int64_t>(bytes[frame->at + kJpegBitsAt]), false,
                     std::to_integer<std::int64_t>(bytes[frame->at + 7])};
}

bool starts_jpeg(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{0xff} && bytes[1] == std::byte{0xd8};
}

}  // namespace

std::optional<PictureHead> picture_head(std::span<const std::byte> bytes) {
  return starts_jpeg(bytes) ? jpeg_head(bytes) : jpeg2000_head(bytes);
}

std::optional<std::size_t> lossless_bits_place(std::span<const std::byte> picture) {
  constexpr unsigned kLossless = 0xc3;
  const auto frame = starts_jpeg(picture) ? find_frame(picture) : std::nullopt;
  if (!frame || frame->mark != kLossless) return std::nullopt;
  return frame->at + kJpegBitsAt;
}

}  // namespace octavo
