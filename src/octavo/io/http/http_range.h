// One byte range of a URL, asked for until all of it has come, and proven.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "octavo/io/http/http_options.h"

namespace octavo {

class HttpConnection;
struct RangeInProgress;
struct RequestResult;

/// What a server answered to a range request.
struct RangeAnswer {
  std::vector<std::uint8_t> bytes;
  std::uint64_t total_bytes = 0;  ///< of the whole file
  std::string validator;          ///< ETag, else Last-Modified, else empty
  std::uint64_t offset = 0;       ///< of the first byte
};

/// Asks for ranges of one URL over connections that stay open. Thread-safe.
class RangeClient {
 public:
  RangeClient(std::string url, HttpOptions options);
  ~RangeClient();
  RangeClient(const RangeClient&) = delete;
  RangeClient& operator=(const RangeClient&) = delete;

  /// The URL as public_name gives it.
  const std::string& name() const { return name_; }

  /// The bytes [offset, offset + count), fewer where the file ends in between.
  /// An answer that holds less than was asked for, or breaks off, is continued: the rest is asked
  /// for. Without a new byte it tries again three times after lost connections and answers 429 and
  /// 5xx, after the pause that the server asks for. Memory grows with the bytes that arrive.
  /// Throws Error{io} for other answers than a 206 with bytes of that range, not encoded; for more
  ///        than five redirects, and those that redirect_target does not allow; when its pauses
  ///        together are longer than kLongestPauseSeconds or timeout_s; about timeout_s when that
  ///        has passed.
  ///        Error{cancelled}
  RangeAnswer fetch(std::uint64_t offset, std::uint64_t count);

  /// The last `count` bytes, or those of them that one request brings before is_over() says so; it
  /// is asked about once a second. Nothing where that fails: not all servers know such ranges.
  std::optional<RangeAnswer> fetch_end(std::uint64_t count, const std::function<bool()>& is_over);

 private:
  RequestResult follow(RangeInProgress& range);
  void check_same_file(const RangeInProgress& range, const RequestResult& result,
                       RangeAnswer& answer) const;
  [[noreturn]] void fail_late(RangeInProgress& range) const;
  void pause_as_asked(RangeInProgress& range, const RequestResult& result, int tries);
  void pause(RangeInProgress& range, double seconds) const;
  void say_once(const std::string& text);
  std::unique_ptr<HttpConnection> take_connection();
  void return_connection(std::unique_ptr<HttpConnection> connection);
  void drop_idle_connections();

  std::string url_;
  std::string name_;
  HttpOptions options_;
  std::atomic<bool> has_said_ = false;
  std::mutex mutex_;
  std::vector<std::unique_ptr<HttpConnection>> idle_;
};

}  // namespace octavo
