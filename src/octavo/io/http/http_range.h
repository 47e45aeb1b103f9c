// One byte range of a URL, asked for and proven.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace octavo {

/// What a server answered to a range request.
struct RangeAnswer {
  std::vector<std::uint8_t> bytes;
  std::uint64_t total_bytes = 0;  ///< of the whole file
  std::string validator;          ///< ETag, else Last-Modified, else empty
};

/// Asks for ranges of one URL over connections that stay open. Thread-safe.
class RangeClient {
 public:
  explicit RangeClient(std::string url);
  ~RangeClient();
  RangeClient(const RangeClient&) = delete;
  RangeClient& operator=(const RangeClient&) = delete;

  const std::string& url() const { return url_; }

  /// The bytes [offset, offset + count), fewer where the file ends in between.
  /// Tries again after lost connections, answers 429 and 5xx.
  /// Throws Error{io} unless the answer is a 206 with exactly that range, not encoded.
  RangeAnswer fetch(std::uint64_t offset, std::uint64_t count);

 private:
  class Connection;
  struct Attempt;

  std::unique_ptr<Connection> take_connection();
  void return_connection(std::unique_ptr<Connection> connection);

  std::string url_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Connection>> idle_;
};

}  // namespace octavo
