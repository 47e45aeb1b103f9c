#include "octavo/io/images/tiff_directory.h"

#include <algorithm>
#include <array>
#include <span>

namespace octavo {

namespace {

constexpr std::uint64_t kBigTiffVersion = 43;
constexpr std::uint64_t kAsciiType = 2;
constexpr std::uint64_t kShortType = 3;
constexpr std::uint64_t kLongType = 4;
constexpr std::uint64_t kMostEntries = std::uint64_t{1} << 16;
constexpr std::uint64_t kMaxTextBytes = std::uint64_t{1} << 20;
constexpr std::size_t kMostTexts = 8;

}  // namespace

// An entry is its tag, its type, how many values there are, and these or where they stand: 12
// bytes between a count of 2 and a link of 4; in BigTIFF 20, 8 and 8.
TiffDirectory::TiffDirectory(const SourceFile& file, std::uint64_t offset, bool is_big_endian)
    : file_(file), is_big_endian_(is_big_endian) {
  std::array<std::byte, 8> raw{};
  const auto read_number = [&](std::uint64_t at, std::size_t width) {
    file_.read_exactly(at, std::span(raw).first(width));
    return number_at(std::span(raw).first(width));
  };
  is_big_tiff_ = read_number(2, 2) == kBigTiffVersion;
  const std::size_t count_bytes = is_big_tiff_ ? 8 : 2;
  const std::uint64_t count = std::min(read_number(offset, count_bytes), kMostEntries);
  const std::uint64_t bytes = entry_bytes() * count;
  const std::uint64_t end = offset + count_bytes + bytes + (is_big_tiff_ ? 8 : 4);
  if (end > file_.size()) {
    reject(file_.path(), "the file ends early: its directory needs bytes to " +
                             std::to_string(end) + ", the file has " +
                             std::to_string(file_.size()) + "; copy it again from its origin");
  }
  entries_.resize(bytes);
  file_.read_exactly(offset + count_bytes, entries_);
}

std::vector<std::string> TiffDirectory::texts(std::uint16_t tag, std::size_t skipped) const {
  std::vector<std::string> found;
  const std::span<const std::byte> all(entries_);
  for (std::size_t at = 0; at < all.size() && found.size() < kMostTexts; at += entry_bytes()) {
    if (number_at(all.subspan(at, 2)) != tag || number_at(all.subspan(at + 2, 2)) != kAsciiType) {
      continue;
    }
    if (skipped > 0) {
      --skipped;
      continue;
    }
    if (std::string text = text_at(at); !text.empty()) found.push_back(std::move(text));
  }
  return found;
}

std::optional<std::uint64_t> TiffDirectory::number(std::uint16_t tag) const {
  const std::size_t width = is_big_tiff_ ? 8 : 4;
  const std::span<const std::byte> all(entries_);
  for (std::size_t at = 0; at < all.size(); at += entry_bytes()) {
    if (number_at(all.subspan(at, 2)) != tag) continue;
    const std::uint64_t type = number_at(all.subspan(at + 2, 2));
    const std::size_t bytes = type == kShortType ? 2 : type == kLongType ? 4 : 0;
    if (bytes == 0 || number_at(all.subspan(at + 4, width)) != 1) return std::nullopt;
    return number_at(all.subspan(at + 4 + width, bytes));
  }
  return std::nullopt;
}

std::uint64_t TiffDirectory::longest_text() const {
  std::uint64_t longest = 0;
  const std::span<const std::byte> all(entries_);
  for (std::size_t at = 0; at < all.size(); at += entry_bytes()) {
    if (number_at(all.subspan(at + 2, 2)) != kAsciiType) continue;
    const std::uint64_t bytes = number_at(all.subspan(at + 4, is_big_tiff_ ? 8 : 4));
    if (bytes <= file_.size()) longest = std::max(longest, bytes);
  }
  return longest;
}

std::uint64_t TiffDirectory::number_at(std::span<const std::byte> bytes) const {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const std::byte next = bytes[is_big_endian_ ? i : bytes.size() - 1 - i];
    value = value << 8 | std::to_integer<std::uint64_t>(next);
  }
  return value;
}

std::string TiffDirectory::text_at(std::size_t at) const {
  const std::size_t width = is_big_tiff_ ? 8 : 4;
  const std::span<const std::byte> entry = std::span(entries_).subspan(at);
  const std::uint64_t count = number_at(entry.subspan(4, width));
  const std::span<const std::byte> value = entry.subspan(4 + width, width);
  const std::uint64_t start = number_at(value);
  const bool is_within = count <= width;
  if (count > kMaxTextBytes || (!is_within && start > file_.size())) return {};
  std::vector<std::byte> bytes(count);
  if (is_within) {
    std::copy_n(value.begin(), count, bytes.begin());
  } else if (file_.read_some(start, bytes) != count) {
    return {};
  }
  std::string text;
  for (const std::byte byte : bytes) {
    if (byte == std::byte{0}) break;
    text += static_cast<char>(byte);
  }
  return text;
}

}  // namespace octavo
