#include "octavo/io/http/answer_head.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "octavo/core/error.h"
#include "octavo/io/http/curl_library.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

/// Takes a number and the character behind it off the front; `end` 0 stands for the end of the
/// text.
std::optional<std::uint64_t> take_number(std::string_view& text, char end) {
  std::uint64_t value = 0;
  const auto [at, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc()) return {};
  text.remove_prefix(static_cast<std::size_t>(at - text.data()));
  if (end == 0) return text.empty() ? std::optional(value) : std::nullopt;
  if (!text.starts_with(end)) return {};
  text.remove_prefix(1);
  return value;
}

std::optional<ContentRange> parse_content_range(std::string_view text) {
  constexpr std::string_view kUnit = "bytes ";
  if (!text.starts_with(kUnit)) return {};
  text.remove_prefix(kUnit.size());
  const auto first = take_number(text, '-');
  if (!first) return {};
  const auto last = take_number(text, '/');
  if (!last) return {};
  const auto total = take_number(text, 0);
  if (!total || *first > *last || *last >= *total) return {};
  return ContentRange{*first, *last, *total};
}

void add_value(std::string& all, std::string_view value) {
  if (!all.empty()) all += ", ";
  all += value;
}

std::string described(std::uint64_t first, std::uint64_t last) {
  return std::to_string(first) + '-' + std::to_string(last);
}

}  // namespace

void AnswerHead::take(std::string_view line) {
  line = trimmed(line);
  if (line.starts_with("HTTP/")) {
    *this = AnswerHead{};
    const std::string_view code = trimmed(line.substr(std::min(line.find(' '), line.size())));
    std::from_chars(code.data(), code.data() + code.size(), status);
    return;
  }
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos) return;
  const std::string name = lower_case(std::string(line.substr(0, colon)));
  std::string_view value = trimmed(line.substr(colon + 1));
  if (name == "content-range") add_value(content_range, value);
  if (name == "content-encoding") add_value(content_encoding, value);
  if (name == "content-type") add_value(content_type, value);
  if (name == "location") location = value;
  if (name == "retry-after") retry_after = value;
  if (name == "etag") etag = value;
  if (name == "last-modified") last_modified = value;
  if (name == "content-length") content_length = take_number(value, 0);
}

bool AnswerHead::is_redirect() const {
  const bool is_elsewhere = (status >= 300 && status <= 303) || status == 307 || status == 308;
  return is_elsewhere && !location.empty();
}

std::optional<double> AnswerHead::pause_seconds(std::int64_t unix_now) const {
  if (retry_after.empty()) return {};
  const bool is_number = retry_after.find_first_not_of("0123456789") == std::string::npos;
  if (is_number) {
    std::string_view text = retry_after;
    const auto seconds = take_number(text, 0);
    return seconds ? static_cast<double>(*seconds) : std::numeric_limits<double>::infinity();
  }
  const std::int64_t date = curl_library().getdate(retry_after.c_str(), nullptr);
  if (date < 0) return {};
  return static_cast<double>(std::max<std::int64_t>(0, date - unix_now));
}

RangeOffer offered_range(const AnswerHead& head, std::uint64_t offset, std::uint64_t count) {
  if (!head.content_encoding.empty() && lower_case(head.content_encoding) != "identity") {
    return {{},
            "the server encodes the file as " + escaped(head.content_encoding) +
                "; ranges need it as it is"};
  }
  if (lower_case(head.content_type).starts_with("multipart/")) {
    return {{}, "the server answers one range in several parts (multipart)"};
  }
  const auto range = parse_content_range(head.content_range);
  if (!range) {
    return {{}, "the answer's Content-Range is '" + escaped(head.content_range) + "'"};
  }
  const std::uint64_t last = std::min(offset + count, std::max(range->total, offset + 1)) - 1;
  if (range->first != offset || range->last > last) {
    return {{}, "the server sent bytes " + described(range->first, range->last) +
                    ", asked were " + described(offset, last)};
  }
  if (head.content_length && *head.content_length > range->length()) {
    return {{}, "the server sends more bytes than were asked for"};
  }
  if (head.content_length && *head.content_length < range->length()) {
    return {{},
            "the answer has " + std::to_string(*head.content_length) +
                " bytes, announced were " + std::to_string(range->length())};
  }
  return {*range, ""};
}

RangeOffer offered_end(const AnswerHead& head, std::uint64_t count) {
  const auto range = parse_content_range(head.content_range);
  const std::uint64_t total = range ? range->total : 0;
  return offered_range(head, total - std::min(total, count), count);
}

}  // namespace octavo
