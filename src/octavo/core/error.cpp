#include "octavo/core/error.h"

#include <utility>

#include "octavo/core/url_text.h"

namespace octavo {

namespace {

constexpr std::size_t kMessageTextLimit = 200;

std::string line_of(const std::string& path, const std::string& detail) {
  return path.empty() ? detail : escaped(path) + ": " + detail;
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
  for (const char c : text) {
    if (out.size() >= kMessageTextLimit) return out + "...";
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7f) {
      out += c;
    } else {
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
