// The head of an HTTP request, as text from a stranger.
//
// Invariants
//   Nothing is taken that two programs could read differently: no folded lines, no blanks before a
//   colon, no second Host or Range, no bytes below 32 but tabs, no body.
// Source  RFC 9112, sections 3 and 5
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace octavo {

/// A longer head is rejected with 431.
inline constexpr std::size_t kMaxRequestHead = 8192;

struct RequestHead {
  std::string method;
  std::string path;   ///< percent-decoded, begins with "/"; without the query
  std::string query;  ///< as it was sent, without "?"
  std::string host;   ///< of an absolute target, else of the field; empty where there is none
  std::optional<std::string> origin;
  std::optional<std::string> range;
  std::optional<std::string> if_range;
  std::optional<std::string> if_match;
  std::optional<std::string> if_none_match;
  bool keeps_alive = true;
  bool asks_private_network = false;  ///< a preflight from a public page
};

/// A head, or the status of an error.
struct ParsedHead {
  RequestHead head;
  int status = 0;  ///< 0: the head is right
};

/// Where the head in `bytes` ends, behind its empty line; nothing while it has not ended.
std::optional<std::size_t> end_of_head(std::string_view bytes);

/// Parses a head with its empty line; one more before it is ignored. 400 for what is malformed or
/// has a body, 404 for targets that are neither a path nor begin with "http://", 505 for other
/// versions of HTTP.
ParsedHead parse_request_head(std::string_view bytes);

/// "%20" as a blank; nothing where a percent sign stands before anything but two hexadecimal
/// digits, and for a zero byte.
std::optional<std::string> percent_decoded(std::string_view text);

/// Every byte but letters, digits, "-", "_", "." and "~" as "%XX".
std::string percent_encoded(std::string_view text);

}  // namespace octavo
