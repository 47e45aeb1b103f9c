#include "octavo/core/url_text.h"

#include <algorithm>
#include <array>

namespace octavo {

namespace {

constexpr std::array<std::string_view, 2> kStarts = {"http://", "https://"};

bool is_same_letter(char a, char b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return lower(a) == lower(b);
}

/// Length of the "https://" that `text` begins with, or 0.
std::size_t start_length(std::string_view text) {
  for (const std::string_view start : kStarts) {
    const std::string_view head = text.substr(0, start.size());
    if (std::equal(head.begin(), head.end(), start.begin(), start.end(), is_same_letter)) {
      return start.size();
    }
  }
  return 0;
}

/// "host", "host:8000", "[::1]:8000"
bool is_host_and_port(std::string_view text) {
  const std::size_t bracket = text.starts_with('[') ? text.find(']') : 0;
  if (bracket == std::string_view::npos) return false;
  const std::size_t colon = text.find(':', bracket);
  if (colon == 0 || text.empty()) return false;
  const std::string_view port = colon < text.size() ? text.substr(colon + 1) : std::string_view{};
  return std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// Whether what stands behind the host may be the end of a password that was not encoded:
/// "https://user:1/2@host".
bool may_hold_password(std::string_view host, std::string_view rest) {
  const std::size_t at = rest.find('@');
  if (at == std::string_view::npos) return false;
  const bool has_port = !host.starts_with('[') && host.find(':') != std::string_view::npos;
  const std::size_t path_end = rest.find_first_of("?#");
  return has_port || rest.substr(0, std::min(at, path_end)).find(':') != std::string_view::npos;
}

bool ends_url(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte <= ' ' || byte == 0x7f || c == '"' || c == '<' || c == '>';
}

/// Whether the character at `at` is a quote mark that begins a name in a message: " 'x'".
bool opens_name(std::string_view text, std::size_t at) {
  return text[at] == '\'' && (at == 0 || text[at - 1] == ' ' || text[at - 1] == '(');
}

/// Whether it ends one.
bool closes_name(std::string_view text, std::size_t at) {
  constexpr std::string_view kBehindNames = " ,;:.)";
  return text[at] == '\'' &&
         (at + 1 == text.size() || kBehindNames.find(text[at + 1]) != std::string_view::npos);
}

/// Where the URL that begins at `at` ends.
std::size_t url_end(std::string_view text, std::size_t at, bool is_in_name) {
  const auto ends = [&](std::size_t i) {
    return is_in_name ? closes_name(text, i) : ends_url(text[i]);
  };
  while (at < text.size() && !ends(at)) ++at;
  return at;
}

}  // namespace

bool is_url(std::string_view name) { return start_length(name) != 0; }

std::string public_name(std::string_view name) {
  const std::size_t start = start_length(name);
  if (start == 0) return std::string(name);
  const std::string scheme(name.substr(0, start));
  const std::string_view rest = name.substr(start);
  const std::size_t host_end = std::min(rest.find_first_of("/?#\\"), rest.size());
  std::string_view host = rest.substr(0, host_end);
  if (const std::size_t at = host.rfind('@'); at != std::string_view::npos) {
    host.remove_prefix(at + 1);
  }
  const std::string_view path = rest.substr(host_end);
  if (!is_host_and_port(host) || may_hold_password(host, path)) return scheme + "...";
  return scheme + std::string(host) + std::string(path.substr(0, path.find_first_of("?#")));
}

std::string without_secrets(std::string_view text) {
  std::string out;
  bool is_in_name = false;
  for (std::size_t at = 0; at < text.size();) {
    if (start_length(text.substr(at)) == 0) {
      is_in_name = is_in_name ? !closes_name(text, at) : opens_name(text, at);
      out += text[at++];
      continue;
    }
    std::string_view url = text.substr(at, url_end(text, at, is_in_name) - at);
    at += url.size();
    const std::size_t last = url.find_last_not_of(":;,.'\")");
    const std::string_view punctuation = url.substr(last + 1);
    url.remove_suffix(punctuation.size());
    out.append(public_name(url)).append(punctuation);
  }
  return out;
}

}  // namespace octavo
