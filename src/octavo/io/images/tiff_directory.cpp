#include "octavo/io/images/tiff_directory.h"

#include <algorithm>
#include <array>
#include <map>
#include <span>

namespace octavo {

namespace {

constexpr std::uint64_t kBigTiffVersion = 43;
constexpr std::uint64_t kAsciiType = 2;
constexpr std::uint64_t kMostEntries = std::uint64_t{1} << 16;
constexpr std::uint64_t kMaxTextBytes = std::uint64_t{1} << 20;
constexpr std::size_t kMostTexts = 8;

/// Of tags whose numbers are read here, for messages.
std::string name_of(std::uint16_t tag) {
  static const std::map<std::uint16_t, const char*> kNames = {
      {254, "NewSubfileType"},  {256, "ImageWidth"},          {257, "ImageLength"},
      {258, "BitsPerSample"},   {259, "Compression"},         {262, "PhotometricInterpretation"},
      {266, "FillOrder"},       {273, "StripOffsets"},        {274, "Orientation"},
      {277, "SamplesPerPixel"}, {278, "RowsPerStrip"},        {279, "StripByteCounts"},
      {317, "Predictor"},       {284, "PlanarConfiguration"}, {322, "TileWidth"},
      {323, "TileLength"},      {324, "TileOffsets"},         {325, "TileByteCounts"},
      {339, "SampleFormat"},    {32997, "ImageDepth"},
      {32998, "TileDepth"}};
  const auto found = kNames.find(tag);
  const std::string number = std::to_string(tag);
  return found == kNames.end() ? number : number + " (" + found->second + ")";
}

struct IntegerType {
  std::size_t bytes = 0;
  bool is_signed = false;
};

/// BYTE, SHORT, LONG, LONG8, those with a sign, and offsets of directories.
std::optional<IntegerType> integer_type(std::uint64_t type) {
  switch (type) {
    case 1: return IntegerType{1, false};
    case 3: return IntegerType{2, false};
    case 4:
    case 13: return IntegerType{4, false};
    case 16:
    case 18: return IntegerType{8, false};
    case 6: return IntegerType{1, true};
    case 8: return IntegerType{2, true};
    case 9: return IntegerType{4, true};
    case 17: return IntegerType{8, true};
    default: return std::nullopt;
  }
}

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
  begin_ = offset;
  end_ = end;
  link_ = read_number(offset + count_bytes + bytes, is_big_tiff_ ? 8 : 4);
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

std::optional<std::span<const std::byte>> TiffDirectory::entry_of(std::uint16_t tag) const {
  std::optional<std::span<const std::byte>> found;
  const std::span<const std::byte> all(entries_);
  for (std::size_t at = 0; at < all.size(); at += entry_bytes()) {
    if (number_at(all.subspan(at, 2)) != tag) continue;
    const std::span<const std::byte> entry = all.subspan(at, entry_bytes());
    if (found && !std::ranges::equal(*found, entry)) {
      reject_tag(tag, "stands in two entries that differ");
    }
    found = entry;
  }
  return found;
}

void TiffDirectory::reject_tag(std::uint16_t tag, const std::string& why) const {
  reject(file_.path(), "tag " + name_of(tag) + " of its directory at byte " +
                           std::to_string(begin_) + " " + why +
                           "; save it again with another program");
}

std::optional<std::uint64_t> TiffDirectory::value_count(std::uint16_t tag) const {
  const auto entry = entry_of(tag);
  if (!entry) return std::nullopt;
  return number_at(entry->subspan(4, is_big_tiff_ ? 8 : 4));
}

std::optional<std::uint64_t> TiffDirectory::number(std::uint16_t tag) const {
  const std::optional<std::uint64_t> count = value_count(tag);
  if (!count) return std::nullopt;
  if (*count != 1) reject_tag(tag, "has " + std::to_string(*count) + " values, one expected");
  return numbers(tag, 1).front();
}

std::vector<std::uint64_t> TiffDirectory::numbers(std::uint16_t tag, std::uint64_t most) const {
  const auto entry = entry_of(tag);
  if (!entry) return {};
  const std::uint64_t type = number_at(entry->subspan(2, 2));
  const std::optional<IntegerType> integers = integer_type(type);
  if (!integers) {
    reject_tag(tag, "is of type " + std::to_string(type) + ", which is none of whole numbers");
  }
  const std::size_t width = is_big_tiff_ ? 8 : 4;
  const std::uint64_t count = number_at(entry->subspan(4, width));
  std::span<const std::byte> raw = entry->subspan(4 + width, width);
  std::vector<std::byte> elsewhere;
  if (count > width / integers->bytes) {
    const std::uint64_t start = number_at(raw);
    if (start > file_.size() || count > (file_.size() - start) / integers->bytes) {
      reject_tag(tag, "has " + std::to_string(count) + " values from byte " +
                          std::to_string(start) + " on, and the file ends at byte " +
                          std::to_string(file_.size()));
    }
    elsewhere.resize(static_cast<std::size_t>(std::min(count, most)) * integers->bytes);
    file_.read_exactly(start, elsewhere);
    raw = elsewhere;
  }

  std::vector<std::uint64_t> values(static_cast<std::size_t>(std::min(count, most)));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = number_at(raw.subspan(i * integers->bytes, integers->bytes));
    if (integers->is_signed && values[i] >> (8 * integers->bytes - 1) != 0) {
      reject_tag(tag, "has a value below 0");
    }
  }
  return values;
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
