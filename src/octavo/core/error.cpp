#include "octavo/core/error.h"

#include <utility>

#include "octavo/core/url_text.h"
#include "octavo/core/utf8.h"

namespace octavo {

namespace {

constexpr std::size_t kMessageTextLimit = 200;

std::string line_of(const std::string& path, const std::string& detail) {
  return path.empty() ? detail : escaped(path) + ": " + detail;
}

/// Whether a character of UTF-8 neither controls a terminal nor moves what stands around it.
bool is_printable(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first >= 0x20 && first != 0x7f;
  const auto second = static_cast<unsigned char>(character[1]);
  if (character.size() == 2) {
    const bool is_control = first == 0xc2 && second < 0xa0;   // U+0080 .. U+009F
    const bool is_arabic_mark = first == 0xd8 && second == 0x9c;  // U+061C
    return !is_control && !is_arabic_mark;
  }
  if (character.size() != 3 || first != 0xe2) return true;
  const auto third = static_cast<unsigned char>(character[2]);
  const bool is_mark = second == 0x80 && (third == 0x8e || third == 0x8f);  // U+200E, U+200F
  const bool is_line_or_turn = second == 0x80 && third >= 0xa8 && third <= 0xae;  // U+2028 .. 202E
  const bool is_isolate = second == 0x81 && third >= 0xa6 && third <= 0xa9;       // U+2066 .. 2069
  return !is_mark && !is_line_or_turn && !is_isolate;
}

}  // namespace

std::string_view error_kind_name(ErrorKind kind) noexcept {
  switch (kind) {
    case ErrorKind::invalid_argument: return "invalid_argument";
    case ErrorKind::not_octavo: return "not_octavo";
    case ErrorKind::unsupported_version: return "unsupported_version";
    case ErrorKind::corrupt: return "corrupt";
    case ErrorKind::truncated: return "truncated";
    case ErrorKind::limit_exceeded: return "limit_exceeded";
    case ErrorKind::source_rejected: return "source_rejected";
    case ErrorKind::io: return "io";
    case ErrorKind::out_of_memory: return "out_of_memory";
    case ErrorKind::cancelled: return "cancelled";
    case ErrorKind::internal: return "internal";
  }
  return "internal";
}

std::string escaped(std::string_view text) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string out;
  while (!text.empty()) {
    const Utf8Piece piece = first_piece(text);
    const std::string_view bytes = text.substr(0, piece.bytes);
    text.remove_prefix(piece.bytes);
    const bool is_shown = piece.is_character && is_printable(bytes);
    const std::size_t limit = is_shown ? kMessageTextLimit - piece.bytes : kMessageTextLimit - 1;
    if (out.size() > limit) return out + "...";
    if (is_shown) {
      out += bytes;
      continue;
    }
    for (const char c : bytes) {
      const auto byte = static_cast<unsigned char>(c);
      out += "\\x";
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
    }
  }
  return out;
}

Error::Error(ErrorKind kind, std::string detail, std::string path,
             std::optional<std::uint64_t> offset)
    : std::runtime_error(line_of(public_name(path), without_secrets(detail))),
      kind_(kind),
      detail_(without_secrets(detail)),
      path_(public_name(path)),
      offset_(offset) {}

const std::string& Error::field() const noexcept {
  static const std::string kNone;
  return hints_.empty() ? kNone : hints_.front().field;
}

Error Error::with_path(const std::string& path) const {
  if (!path_.empty()) return *this;
  Error placed(kind_, detail_, path, offset_);
  placed.hints_ = hints_;
  return placed;
}

Error Error::with_detail(const std::string& detail) const {
  Error reworded(kind_, detail, path_, offset_);
  reworded.hints_ = hints_;
  return reworded;
}

Error Error::with_field(std::string field, std::string value) const {
  Error about = *this;
  about.hints_.push_back({std::move(field), std::move(value)});
  return about;
}

}  // namespace octavo
