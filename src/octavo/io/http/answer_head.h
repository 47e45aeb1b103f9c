// The head of a server's answer to a request for a range, and whether its body can be that range.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace octavo {

/// "bytes 0-65535/1048576"
struct ContentRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t total = 0;  ///< bytes of the whole file
  std::uint64_t length() const { return last - first + 1; }
};

struct AnswerHead {
  long status = 0;  ///< 0 as long as none came
  std::string content_range;
  std::string content_encoding;
  std::string content_type;
  std::string location;
  std::string retry_after;
  std::string etag;
  std::string last_modified;
  std::optional<std::uint64_t> content_length;

  /// Takes one line: a status line starts anew, a header is kept, all else is passed over. Of a
  /// header that comes twice both values are kept, which makes no sense of most.
  void take(std::string_view line);

  /// A redirect that says where to.
  bool is_redirect() const;
  /// 429 and 5xx: the same request may be answered later.
  bool is_busy() const { return status == 429 || status >= 500; }
  /// What tells one version of the file from another: ETag, else Last-Modified, else nothing.
  const std::string& validator() const { return etag.empty() ? last_modified : etag; }
  /// The pause that is asked for: Retry-After as seconds or as a date; infinite for more than any
  /// number holds.
  std::optional<double> pause_seconds(std::int64_t unix_now) const;
};

/// What the body of a 206 is, or why it is of no use.
struct RangeOffer {
  ContentRange range;
  std::string problem;  ///< empty where the body begins as asked
};

/// The body of an answer 206 to a request for [offset, offset + count). It may be shorter than what
/// was asked for.
RangeOffer offered_range(const AnswerHead& head, std::uint64_t offset, std::uint64_t count);

/// The same of an answer to a request for the last `count` bytes, or all where there are fewer.
RangeOffer offered_end(const AnswerHead& head, std::uint64_t count);

}  // namespace octavo
