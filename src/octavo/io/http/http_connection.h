// One request for a range over a connection that stays open.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "octavo/io/http/answer_head.h"
#include "octavo/io/http/patience.h"

using CURL = void;
struct curl_slist;

namespace octavo {

struct CurlLibrary;

/// A range of a file that is being fetched: what of it has come, and how long it may still take.
struct RangeInProgress {
  std::uint64_t offset = 0;  ///< of the first byte
  std::uint64_t count = 0;   ///< bytes in all
  std::vector<std::uint8_t> bytes;
  Patience patience;
  std::function<void(Patience::Time)> each_second;  ///< called while it waits
  std::function<bool()> is_cancelled;            ///< may be empty
  bool is_end = false;  ///< the last bytes of the file; the answer says from which offset on

  std::uint64_t next() const { return offset + bytes.size(); }
  std::uint64_t missing() const { return count - bytes.size(); }
};

/// How a request ended.
enum class RequestEnd {
  answered,   ///< the head says how; a body that is no range is not read to its end
  rejected,   ///< the answer is of no use, whatever is asked next
  lost,       ///< the connection broke, or may have done so unseen
  late,       ///< the patience ended
  cancelled,
};

struct RequestResult {
  RequestEnd end = RequestEnd::lost;
  AnswerHead head;
  ContentRange range;   ///< of a body that was taken
  std::string problem;  ///< of what was lost or rejected
};

/// Not thread-safe.
class HttpConnection {
 public:
  HttpConnection();
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  /// Asks `url` for what is missing and appends what comes of it to `range.bytes`. Follows no
  /// redirect. Bytes are taken only behind a head that promises them.
  /// A connection that was put aside, or in the middle of a body, counts as lost after a third of
  /// the patience in silence: another one may still be answered.
  RequestResult request(const std::string& url, RangeInProgress& range);

  /// Says that the next request comes later. The connection may break meanwhile without a sign.
  void put_aside() { was_put_aside_ = true; }

 private:
  struct Transfer;

  template <class T>
  void set(int option, T value);
  static std::size_t on_header(char* bytes, std::size_t size, std::size_t count, void* user);
  static std::size_t on_body(char* bytes, std::size_t size, std::size_t count, void* user);
  static int on_second(void* user, std::int64_t, std::int64_t, std::int64_t, std::int64_t);

  const CurlLibrary& curl_;
  CURL* easy_;
  curl_slist* headers_ = nullptr;
  bool was_put_aside_ = false;
};

}  // namespace octavo
