#include "octavo/io/dicom/jpeg2000_size.h"

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
// A component: bits, then the distances of its samples.
constexpr std::size_t kAcrossAt = 43;
constexpr std::size_t kDownAt = 44;
constexpr std::size_t kEnd = 45;

std::uint64_t extent_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (const std::byte b : bytes.subspan(at, 4)) value = value << 8 | std::to_integer<unsigned>(b);
  return value;
}

/// Samples of a component that stand `step` apart on the reference grid from `first` to `end`.
std::uint32_t samples_between(std::uint64_t first, std::uint64_t end, std::uint64_t step) {
  const std::uint64_t before = (first + step - 1) / step;
  const std::uint64_t all = (end + step - 1) / step;
  return static_cast<std::uint32_t>(all > before ? all - before : 0);
}

}  // namespace

std::optional<PictureSize> jpeg2000_size(std::span<const std::byte> bytes) {
  const auto start = std::search(bytes.begin(), bytes.end(), kStart.begin(), kStart.end());
  const std::span<const std::byte> head(start, bytes.end());
  if (head.size() < kEnd) return std::nullopt;
  const auto across = std::to_integer<std::uint64_t>(head[kAcrossAt]);
  const auto down = std::to_integer<std::uint64_t>(head[kDownAt]);
  if (across == 0 || down == 0) return std::nullopt;
  return PictureSize{samples_between(extent_at(head, kLeftAt), extent_at(head, kWidthAt), across),
                     samples_between(extent_at(head, kTopAt), extent_at(head, kHeightAt), down)};
}

}  // namespace octavo
