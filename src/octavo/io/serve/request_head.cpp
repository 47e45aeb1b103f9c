#include "octavo/io/serve/request_head.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace octavo {

namespace {

constexpr std::string_view kLineEnd = "\r\n";
constexpr int kBadRequest = 400;
constexpr int kNotFound = 404;
constexpr int kOtherVersion = 505;

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

bool is_token(std::string_view text) {
  constexpr std::string_view kSigns = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return is_letter_or_digit(c) || kSigns.find(c) != std::string_view::npos;
  });
}

/// Of a header field: visible characters, blanks, tabs, and bytes above 127.
bool is_field_text(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte == '\t' || (byte >= 0x20 && byte != 0x7f);
  });
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return result;
}

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

std::optional<int> hexadecimal(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

/// Leaves the path of "http://host/path?query" and takes its host; gives a status.
int take_absolute_target(std::string_view& target, RequestHead& head) {
  constexpr std::string_view kScheme = "http://";
  if (lower(target.substr(0, kScheme.size())) != kScheme) return kNotFound;
  target.remove_prefix(kScheme.size());
  const std::size_t end = std::min(target.find_first_of("/?"), target.size());
  const std::string_view host = target.substr(0, end);
  if (host.empty() || host.find('@') != std::string_view::npos) return kBadRequest;
  head.host = host;
  target.remove_prefix(end);
  return 0;
}

/// Takes "GET /x?y HTTP/1.1" apart; gives a status.
int take_request_line(std::string_view line, RequestHead& head) {
  const std::size_t first = line.find(' ');
  const std::size_t second = first == std::string_view::npos ? first : line.find(' ', first + 1);
  if (second == std::string_view::npos || line.find(' ', second + 1) != std::string_view::npos) {
    return kBadRequest;
  }
  const std::string_view version = line.substr(second + 1);
  if (!version.starts_with("HTTP/")) return kBadRequest;
  if (version != "HTTP/1.1" && version != "HTTP/1.0") return kOtherVersion;
  head.keeps_alive = version == "HTTP/1.1";
  head.method = line.substr(0, first);
  if (!is_token(head.method)) return kBadRequest;
  std::string_view target = line.substr(first + 1, second - first - 1);
  if (target.empty() || !is_field_text(target)) return kBadRequest;
  if (target.front() != '/') {
    if (const int status = take_absolute_target(target, head); status != 0) return status;
  }
  const std::size_t question = target.find('?');
  if (question != std::string_view::npos) {
    head.query = target.substr(question + 1);
    target = target.substr(0, question);
  }
  auto path = percent_decoded(target);
  if (!path) return kNotFound;
  head.path = path->empty() ? "/" : std::move(*path);
  return 0;
}

/// A field that may stand once.
bool take_once(std::optional<std::string>& field, std::string_view value) {
  if (field) return false;
  field = std::string(value);
  return true;
}

int take_field(std::string_view line, RequestHead& head, bool& has_host) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) return kBadRequest;
  const std::string name = lower(line.substr(0, colon));
  const std::string_view value = without_blanks(line.substr(colon + 1));
  if (!is_field_text(value)) return kBadRequest;
  bool is_right = true;
  if (name == "host") {
    is_right = !has_host;
    has_host = true;
    // The host of an absolute target goes before.
    if (head.host.empty()) head.host = value;
  } else if (name == "origin") {
    is_right = take_once(head.origin, value);
  } else if (name == "range") {
    is_right = take_once(head.range, value);
  } else if (name == "if-range") {
    is_right = take_once(head.if_range, value);
  } else if (name == "if-match") {
    is_right = take_once(head.if_match, value);
  } else if (name == "if-none-match") {
    is_right = take_once(head.if_none_match, value);
  } else if (name == "connection") {
    if (lower(value) == "close") head.keeps_alive = false;
  } else if (name == "access-control-request-private-network") {
    head.asks_private_network = value == "true";
  } else if (name == "content-length") {
    is_right = value == "0";
  } else if (name == "transfer-encoding") {
    is_right = false;
  }
  return is_right ? 0 : kBadRequest;
}

}  // namespace

std::optional<std::size_t> end_of_head(std::string_view bytes) {
  const std::size_t at = bytes.find("\r\n\r\n");
  if (at == std::string_view::npos) return std::nullopt;
  return at + 4;
}

ParsedHead parse_request_head(std::string_view bytes) {
  ParsedHead parsed;
  bool has_host = false;
  bool is_first = true;
  if (bytes.starts_with(kLineEnd)) bytes.remove_prefix(kLineEnd.size());
  while (parsed.status == 0) {
    const std::size_t end = bytes.find(kLineEnd);
    if (end == std::string_view::npos) {
      parsed.status = kBadRequest;
      break;
    }
    const std::string_view line = bytes.substr(0, end);
    bytes.remove_prefix(end + kLineEnd.size());
    if (is_first) {
      parsed.status = take_request_line(line, parsed.head);
      is_first = false;
    } else if (line.empty()) {
      if (!bytes.empty()) parsed.status = kBadRequest;
      break;
    } else {
      parsed.status = take_field(line, parsed.head, has_host);
    }
  }
  return parsed;
}

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result.push_back(text[i]);
      continue;
    }
    if (i + 2 >= text.size()) return std::nullopt;
    const auto high = hexadecimal(text[i + 1]);
    const auto low = hexadecimal(text[i + 2]);
    if (!high || !low || (*high == 0 && *low == 0)) return std::nullopt;
    result.push_back(static_cast<char>(*high * 16 + *low));
    i += 2;
  }
  return result;
}

std::string percent_encoded(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  constexpr std::string_view kPlain = "-_.~";
  std::string result;
  for (const char c : text) {
    if (is_letter_or_digit(c) || kPlain.find(c) != std::string_view::npos) {
      result.push_back(c);
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    result.push_back('%');
    result.push_back(kDigits[byte >> 4]);
    result.push_back(kDigits[byte & 15]);
  }
  return result;
}

}  // namespace octavo
