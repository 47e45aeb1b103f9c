#include "octavo/io/http/http_connection.h"

#include <algorithm>
#include <cstdlib>
#include <type_traits>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/io/http/curl_library.h"

namespace octavo {

namespace {

using Clock = std::chrono::steady_clock;

/// More in all heads of one answer, those of interim answers too, is no head.
constexpr std::uint64_t kHeadBytes = std::uint64_t{1} << 16;
/// A redirect's body is read so far, so that the connection can be used again.
constexpr std::uint64_t kRedirectBodyBytes = std::uint64_t{1} << 16;
constexpr double kLongestConnectSeconds = 15;

bool is_lost(CURLcode code) {
  switch (code) {
    case CURLE_COULDNT_CONNECT:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_PARTIAL_FILE:
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_UNSUPPORTED_PROTOCOL:   // garbage on a connection that was used before
    case CURLE_BAD_FUNCTION_ARGUMENT:  // the same, with zero bytes
    case CURLE_WEIRD_SERVER_REPLY:
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM: return true;
    default: return false;
  }
}

}  // namespace

/// A request while it runs.
struct HttpConnection::Transfer {
  explicit Transfer(RangeInProgress& wanted) : range(wanted) {}

  RangeInProgress& range;
  RequestResult result;
  bool may_be_lost = false;                ///< where nothing comes
  Clock::time_point heard = Clock::now();  ///< when the last bytes of the body came, or it began
  std::uint64_t body_start = range.bytes.size();
  std::uint64_t head_bytes = 0;
  std::uint64_t skipped_bytes = 0;         ///< of a body that is no range
  bool has_offer = false;
  bool is_cut = false;                     ///< ended by us, as the rest is of no use
  bool is_ended = false;                   ///< result.end says why
  std::exception_ptr failure;              ///< which must not pass through libcurl

  bool reject(const std::string& problem) {
    end(RequestEnd::rejected);
    result.problem = problem;
    return false;
  }

  void end(RequestEnd why) {
    is_ended = true;
    result.end = why;
  }

  bool take_header(std::string_view line) {
    head_bytes += line.size();
    if (head_bytes > kHeadBytes) return reject("the server's headers are longer than 64 KiB");
    result.head.take(line);
    return true;
  }

  /// Whether the head of a 206 promises bytes that are missing.
  bool take_offer() {
    has_offer = true;
    RangeOffer offer = range.is_end ? offered_end(result.head, range.count)
                                    : offered_range(result.head, range.next(), range.missing());
    if (!offer.problem.empty()) return reject(offer.problem);
    if (range.is_end) range.offset = offer.range.first;
    result.range = offer.range;
    return true;
  }

  bool take_body(const char* bytes, std::size_t count) {
    if (result.head.status != 206) {
      skipped_bytes += count;
      is_cut = !result.head.is_redirect() || skipped_bytes > kRedirectBodyBytes;
      return !is_cut;
    }
    if (!has_offer && !take_offer()) return false;
    if (range.bytes.size() - body_start + count > result.range.length()) {
      return reject("the server sends more bytes than were asked for");
    }
    range.bytes.insert(range.bytes.end(), bytes, bytes + count);
    may_be_lost = true;
    heard = Clock::now();
    range.patience.feed(count, heard);
    return true;
  }

  /// Whether to go on.
  bool look_around() {
    const Clock::time_point now = Clock::now();
    if (range.is_cancelled && range.is_cancelled()) {
      end(RequestEnd::cancelled);
    } else if (range.patience.left(now) <= 0) {
      end(RequestEnd::late);
    } else if (may_be_lost &&
               now - heard > std::chrono::duration<double>(range.patience.seconds() / 3)) {
      end(RequestEnd::lost);
      result.problem = "the server went silent";
    } else {
      range.each_second(now);
    }
    return !is_ended;
  }

  /// Calls what libcurl calls back; nothing is thrown through it.
  template <class Work>
  bool guarded(Work work) {
    try {
      return work();
    } catch (...) {
      failure = std::current_exception();
      return false;
    }
  }
};

HttpConnection::HttpConnection() : curl_(curl_library()), easy_(curl_.easy_init()) {
  if (easy_ == nullptr) throw Error(ErrorKind::out_of_memory, "no memory for a connection");
  headers_ = curl_.slist_append(nullptr, "Accept-Encoding: identity");
  set(CURLOPT_HTTPHEADER, headers_);
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_NOPROGRESS, 0L);
  set(CURLOPT_HEADERFUNCTION, &HttpConnection::on_header);
  set(CURLOPT_WRITEFUNCTION, &HttpConnection::on_body);
  set(CURLOPT_XFERINFOFUNCTION, &HttpConnection::on_second);
  // Authorities to trust, named as for most other programs.
  if (const char* authorities = std::getenv("SSL_CERT_FILE")) set(CURLOPT_CAINFO, authorities);
}

HttpConnection::~HttpConnection() {
  curl_.easy_cleanup(easy_);
  curl_.slist_free_all(headers_);
}

template <class T>
void HttpConnection::set(int option, T value) {
  const CURLcode code = curl_.easy_setopt(easy_, static_cast<CURLoption>(option), value);
  if (code != CURLE_OK) {
    throw Error(ErrorKind::io, std::string("libcurl: ") + curl_.easy_strerror(code));
  }
}

std::size_t HttpConnection::on_header(char* bytes, std::size_t size, std::size_t count,
                                      void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  const std::size_t length = size * count;
  const bool goes_on = transfer.guarded([&] { return transfer.take_header({bytes, length}); });
  return goes_on ? length : 0;
}

std::size_t HttpConnection::on_body(char* bytes, std::size_t size, std::size_t count,
                                    void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  const std::size_t length = size * count;
  const bool goes_on = transfer.guarded([&] { return transfer.take_body(bytes, length); });
  return goes_on ? length : 0;
}

int HttpConnection::on_second(void* user, std::int64_t, std::int64_t, std::int64_t,
                              std::int64_t) {
  auto& transfer = *static_cast<Transfer*>(user);
  return transfer.guarded([&] { return transfer.look_around(); }) ? 0 : 1;
}

RequestResult HttpConnection::request(const std::string& url, RangeInProgress& range) {
  static_assert(std::is_same_v<curl_off_t, std::int64_t>);
  Transfer transfer{range};
  transfer.may_be_lost = std::exchange(was_put_aside_, false);
  const std::string wanted =
      range.is_end ? '-' + std::to_string(range.count)
                   : std::to_string(range.next()) + '-' +
                         std::to_string(range.offset + range.count - 1);
  const double connect_s = std::min(kLongestConnectSeconds, range.patience.seconds() / 2);
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_RANGE, wanted.c_str());
  set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(connect_s * 1000));
  set(CURLOPT_HEADERDATA, &transfer);
  set(CURLOPT_WRITEDATA, &transfer);
  set(CURLOPT_XFERINFODATA, &transfer);

  const CURLcode code = curl_.easy_perform(easy_);
  if (transfer.failure) std::rethrow_exception(transfer.failure);
  RequestResult& result = transfer.result;
  if (transfer.is_ended) return result;
  if (code != CURLE_OK && !transfer.is_cut) {
    result.problem = std::string("cannot be read: ") + curl_.easy_strerror(code);
    result.end = is_lost(code) ? RequestEnd::lost : RequestEnd::rejected;
    return result;
  }
  if (result.head.status == 206 && !transfer.has_offer && !transfer.take_offer()) return result;
  result.end = RequestEnd::answered;
  return result;
}

}  // namespace octavo
