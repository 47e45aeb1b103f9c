#include "octavo/io/source/text_voxels.h"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 16;
/// Far more than a double in full takes.
constexpr std::size_t kMaxWordBytes = 128;

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

}  // namespace

TextVoxels::TextVoxels(const std::string& path, std::uint64_t offset)
    : file_(path), buffer_offset_(offset) {
  buffer_.reserve(kBufferBytes);
}

void TextVoxels::read(StoredType type, std::span<std::byte> values) {
  if (type.wide() == WideType::int64) return read_values<std::int64_t>(values);
  if (type.wide() == WideType::uint64) return read_values<std::uint64_t>(values);
  if (type.wide() == WideType::float64) return read_values<double>(values);
  with_voxel_type(type.voxel(), [&](auto tag) {
    read_values<typename decltype(tag)::type>(values);
  });
}

template <class T>
void TextVoxels::read_values(std::span<std::byte> values) {
  for (std::size_t at = 0; at < values.size(); at += sizeof(T)) {
    std::string_view word = next_word();
    if (word.starts_with('+')) word.remove_prefix(1);
    T value{};
    const char* end = word.data() + word.size();
    const auto [behind, failure] = std::from_chars(word.data(), end, value);
    if (failure != std::errc() || behind != end) {
      reject("\"" + escaped(word) + "\" is no number that a voxel of this type can hold");
    }
    std::memcpy(values.data() + at, &value, sizeof(T));
  }
}

std::string_view TextVoxels::next_word() {
  for (;;) {
    while (at_ < buffer_.size() && is_blank(buffer_[at_])) ++at_;
    if (at_ < buffer_.size()) break;
    if (!refill()) reject("the file ends where a voxel is expected: it is cut");
  }
  for (std::size_t end = at_;; ++end) {
    if (end - at_ > kMaxWordBytes) reject("a word of more than 128 bytes is no number");
    if (end == buffer_.size()) {
      end -= at_;
      if (!refill()) {
        reject("the file ends within a number, or lacks the line end behind its last one: it may "
               "be cut");
      }
    }
    if (!is_blank(buffer_[end])) continue;
    const std::string_view word(buffer_.data() + at_, end - at_);
    at_ = end;
    return word;
  }
}

bool TextVoxels::refill() {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at_));
  buffer_offset_ += at_;
  at_ = 0;
  const std::size_t kept = buffer_.size();
  buffer_.resize(kBufferBytes);
  const std::size_t found = file_.read_some(
      buffer_offset_ + kept, std::as_writable_bytes(std::span(buffer_).subspan(kept)));
  buffer_.resize(kept + found);
  return found > 0;
}

void TextVoxels::reject(const std::string& why) const {
  throw Error(ErrorKind::source_rejected,
              "at byte " + std::to_string(offset()) + ": " + why +
                  "; copy the file again from its origin",
              path(), offset());
}

}  // namespace octavo
