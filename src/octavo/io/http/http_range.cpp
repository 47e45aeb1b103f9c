#include "octavo/io/http/http_range.h"

#include <curl/curl.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstring>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr int kAttempts = 4;
constexpr std::chrono::milliseconds kFirstPause{200};

/// "bytes 0-65535/1048576"
struct ContentRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t total = 0;
};

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

bool is_worth_another_try(CURLcode code) {
  switch (code) {
    case CURLE_COULDNT_CONNECT:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_PARTIAL_FILE:
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM: return true;
    default: return false;
  }
}

void start_curl() {
  static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
  if (started != CURLE_OK) throw Error(ErrorKind::io, "libcurl does not start");
}

}  // namespace

/// What has come in of one answer.
struct RangeClient::Attempt {
  std::uint64_t limit = 0;  ///< bytes asked for
  long status = 0;
  std::string content_range;
  std::string content_encoding;
  std::string etag;
  std::string last_modified;
  std::vector<std::uint8_t> body;
  bool is_too_long = false;
  bool is_rejected = false;  ///< stopped after the headers: the body is of no use
};

class RangeClient::Connection {
 public:
  explicit Connection(const std::string& url) : easy_(curl_easy_init()) {
    if (easy_ == nullptr) throw Error(ErrorKind::out_of_memory, "no memory for a connection");
    headers_ = curl_slist_append(nullptr, "Accept-Encoding: identity");
    set(CURLOPT_URL, url.c_str());
    set(CURLOPT_HTTPHEADER, headers_);
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
    set(CURLOPT_FOLLOWLOCATION, 1L);
    set(CURLOPT_MAXREDIRS, 5L);
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_CONNECTTIMEOUT, 15L);
    set(CURLOPT_LOW_SPEED_LIMIT, 100L);
    set(CURLOPT_LOW_SPEED_TIME, 30L);
    set(CURLOPT_HEADERFUNCTION, &Connection::on_header);
    set(CURLOPT_WRITEFUNCTION, &Connection::on_body);
  }

  ~Connection() {
    curl_easy_cleanup(easy_);
    curl_slist_free_all(headers_);
  }

  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  CURLcode get(std::uint64_t offset, std::uint64_t count, Attempt& attempt) {
    const std::string range = std::to_string(offset) + '-' + std::to_string(offset + count - 1);
    attempt = Attempt{};
    attempt.limit = count;
    set(CURLOPT_RANGE, range.c_str());
    set(CURLOPT_HEADERDATA, &attempt);
    set(CURLOPT_WRITEDATA, &attempt);
    return curl_easy_perform(easy_);
  }

 private:
  template <class T>
  void set(CURLoption option, T value) {
    const CURLcode code = curl_easy_setopt(easy_, option, value);
    if (code != CURLE_OK) {
      throw Error(ErrorKind::io, std::string("libcurl: ") + curl_easy_strerror(code));
    }
  }

  static std::size_t on_header(char* bytes, std::size_t size, std::size_t count, void* user) {
    Attempt& attempt = *static_cast<Attempt*>(user);
    const std::string_view line = trimmed({bytes, size * count});
    if (line.starts_with("HTTP/")) {
      // A redirect brings several heads; only the last one counts.
      const std::uint64_t limit = attempt.limit;
      attempt = Attempt{};
      attempt.limit = limit;
      const std::size_t space = std::min(line.find(' '), line.size());
      const std::string_view status = trimmed(line.substr(space));
      std::from_chars(status.data(), status.data() + status.size(), attempt.status);
      return size * count;
    }
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return size * count;
    const std::string name = lower_case(std::string(line.substr(0, colon)));
    const std::string value(trimmed(line.substr(colon + 1)));
    if (name == "content-range") attempt.content_range = value;
    if (name == "content-encoding") attempt.content_encoding = value;
    if (name == "etag") attempt.etag = value;
    if (name == "last-modified") attempt.last_modified = value;
    return size * count;
  }

  static std::size_t on_body(char* bytes, std::size_t size, std::size_t count, void* user) {
    Attempt& attempt = *static_cast<Attempt*>(user);
    const std::size_t length = size * count;
    if (attempt.status >= 300 && attempt.status < 400) return length;
    attempt.is_rejected = attempt.status != 206;
    attempt.is_too_long = attempt.body.size() + length > attempt.limit;
    if (attempt.is_rejected || attempt.is_too_long) return 0;
    attempt.body.insert(attempt.body.end(), bytes, bytes + length);
    return length;
  }

  CURL* easy_;
  curl_slist* headers_ = nullptr;
};

RangeClient::RangeClient(std::string url) : url_(std::move(url)) { start_curl(); }

RangeClient::~RangeClient() = default;

std::unique_ptr<RangeClient::Connection> RangeClient::take_connection() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return std::make_unique<Connection>(url_);
  auto connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

void RangeClient::return_connection(std::unique_ptr<Connection> connection) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(connection));
}

namespace {

[[noreturn]] void fail(const std::string& url, std::uint64_t offset, const std::string& what) {
  throw Error(ErrorKind::io, what, escaped(url), offset);
}

std::string status_words(long status) {
  if (status == 200) return "this server ignores Range; it sends whole files only";
  const std::string number = std::to_string(status);
  if (status == 404) return "the server has no such file (404)";
  if (status == 401 || status == 403) return "the server denies access (" + number + ")";
  if (status == 416) return "the server has no such range (416); the file is empty or was replaced";
  return "the server answers with status " + number + ", expected 206";
}

}  // namespace

RangeAnswer RangeClient::fetch(std::uint64_t offset, std::uint64_t count) {
  Attempt attempt;
  CURLcode code = CURLE_OK;
  auto pause = kFirstPause;
  for (int tries = 1;; ++tries, pause *= 2) {
    auto connection = take_connection();
    code = connection->get(offset, count, attempt);
    const bool is_busy = attempt.status == 429 || attempt.status >= 500;
    const bool has_lost = is_worth_another_try(code);
    if (!has_lost) return_connection(std::move(connection));
    if ((!is_busy && !has_lost) || tries == kAttempts) break;
    std::this_thread::sleep_for(pause);
  }

  // Name what is wrong, the most telling first.
  if (attempt.status != 0 && attempt.status != 206)
    fail(url_, offset, status_words(attempt.status));
  if (attempt.is_too_long) fail(url_, offset, "the server sends more bytes than were asked for");
  if (code != CURLE_OK) {
    fail(url_, offset, std::string("cannot be read: ") + curl_easy_strerror(code));
  }
  if (!attempt.content_encoding.empty() && lower_case(attempt.content_encoding) != "identity") {
    fail(url_, offset,
           "the server encodes the file as " + escaped(attempt.content_encoding) +
               "; ranges need it as it is");
  }
  const auto range = parse_content_range(attempt.content_range);
  if (!range) {
    fail(url_, offset, "the answer's Content-Range is '" + escaped(attempt.content_range) + "'");
  }
  const std::uint64_t last = std::min(offset + count, range->total) - 1;
  if (range->first != offset || range->last != last) {
    fail(url_, offset,
           "the server sent bytes " + std::to_string(range->first) + '-' +
               std::to_string(range->last) + ", asked were " + std::to_string(offset) + '-' +
               std::to_string(last));
  }
  if (attempt.body.size() != last - offset + 1) {
    fail(url_, offset,
           "the answer has " + std::to_string(attempt.body.size()) + " bytes, announced were " +
               std::to_string(last - offset + 1));
  }
  return {std::move(attempt.body), range->total,
          attempt.etag.empty() ? attempt.last_modified : attempt.etag};
}

}  // namespace octavo
