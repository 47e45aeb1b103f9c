#include "octavo/io/http/http_range.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <thread>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/io/http/http_connection.h"
#include "octavo/io/http/redirect.h"

namespace octavo {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kAttempts = 4;
constexpr int kRedirects = 5;
constexpr double kFirstPauseSeconds = 0.2;

[[noreturn]] void fail(const std::string& what, const RangeInProgress& range) {
  throw Error(ErrorKind::io, what, {}, range.next());
}

std::string status_words(long status) {
  if (status == 0) return "the server's answer has no status";
  if (status == 200) return "this server ignores Range; it sends whole files only";
  const std::string number = std::to_string(status);
  if (status == 404) return "the server has no such file (404)";
  if (status == 401 || status == 403) return "the server denies access (" + number + ")";
  if (status == 416) return "the server has no such range (416); the file is empty or was replaced";
  if (status == 429 || status == 503) return "the server is busy (" + number + ")";
  return "the server answers with status " + number + ", expected 206";
}

std::string seconds_words(double seconds) {
  if (!std::isfinite(seconds) || seconds >= 1e15) return "many years";
  return number_text(std::ceil(seconds)) + " s";
}

}  // namespace

RangeClient::RangeClient(std::string url, HttpOptions options)
    : url_(std::move(url)), name_(public_name(url_)), options_(std::move(options)) {}

RangeClient::~RangeClient() = default;

std::unique_ptr<HttpConnection> RangeClient::take_connection() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return std::make_unique<HttpConnection>();
  auto connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

void RangeClient::return_connection(std::unique_ptr<HttpConnection> connection) {
  connection->put_aside();
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(connection));
}

void RangeClient::drop_idle_connections() {
  const std::lock_guard lock(mutex_);
  idle_.clear();
}

void RangeClient::say_once(const std::string& text) {
  if (options_.on_wait && !has_said_.exchange(true)) options_.on_wait(name_ + ": " + text);
}

/// One request, and those that redirects lead to.
RequestResult RangeClient::follow(RangeInProgress& range) {
  auto connection = take_connection();
  std::string url = url_;
  for (int redirects = 0;; ++redirects) {
    RequestResult result = connection->request(url, range);
    // A connection that failed is not used again, nor are others that were put aside like it.
    const bool is_sound = result.end == RequestEnd::answered;
    if (!is_sound) drop_idle_connections();
    if (!is_sound || !result.head.is_redirect()) {
      if (is_sound) return_connection(std::move(connection));
      return result;
    }
    if (redirects == kRedirects) fail("the server redirects more than 5 times", range);
    url = redirect_target(url, result.head.location);
  }
}

/// All answers of a range speak of the same file. The first says how long it is.
void RangeClient::check_same_file(const RangeInProgress& range, const RequestResult& result,
                                  RangeAnswer& answer) const {
  const bool is_first = answer.total_bytes == 0;
  if (is_first) {
    answer.total_bytes = result.range.total;
    answer.validator = result.head.validator();
  }
  if (answer.total_bytes != result.range.total || answer.validator != result.head.validator()) {
    fail("the file was replaced while being read; open it again", range);
  }
}

void RangeClient::fail_late(RangeInProgress& range) const {
  const double seconds = options_.timeout_s;
  const bool is_silent = range.patience.silence(Clock::now()) > 0.9 * seconds;
  const std::string what = is_silent ? "nothing came from the server for "
                                     : "the server sends less than 10 kB a second, for ";
  throw Error(ErrorKind::io, what + seconds_words(seconds), {}, range.next())
      .with_field("timeout_s");
}

void RangeClient::pause(RangeInProgress& range, double seconds) const {
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(seconds));
  constexpr Clock::duration kLook = std::chrono::milliseconds(50);
  for (auto now = Clock::now(); now < end; now = Clock::now()) {
    if (range.is_cancelled && range.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    std::this_thread::sleep_for(std::min(kLook, end - now));
  }
}

/// Before the next attempt: as long as a busy server asks for, else longer with each.
void RangeClient::pause_as_asked(RangeInProgress& range, const RequestResult& result, int tries) {
  const bool is_busy = result.end == RequestEnd::answered && result.head.is_busy();
  const std::optional<double> asked =
      is_busy ? result.head.pause_seconds(std::time(nullptr)) : std::nullopt;
  if (!asked) return pause(range, kFirstPauseSeconds * std::pow(2, tries - 1));
  const std::string words =
      status_words(result.head.status) + " and asks to wait " + seconds_words(*asked);
  const double longest = std::min(kLongestPauseSeconds, options_.timeout_s);
  if (*asked > longest) fail(words, range);
  const double paused = range.patience.left_out();
  if (paused + *asked > longest) {
    fail(words + " again, after pauses of " + seconds_words(paused) + " in all", range);
  }
  if (*asked >= kSilentSeconds) say_once(words);
  pause(range, *asked);
  range.patience.leave_out(*asked);
}

RangeAnswer RangeClient::fetch(std::uint64_t offset, std::uint64_t count) try {
  RangeInProgress range{offset, count, {}, Patience(options_.timeout_s, Clock::now()), {},
                        options_.is_cancelled};
  range.each_second = [&](Clock::time_point now) {
    if (options_.timeout_s - range.patience.left(now) < kSilentSeconds) return;
    say_once("waiting for the server; it has " + seconds_words(options_.timeout_s));
  };

  RangeAnswer answer;
  for (int tries = 0; range.missing() > 0;) {
    const std::uint64_t before = range.bytes.size();
    const RequestResult result = follow(range);
    if (result.end == RequestEnd::cancelled) throw Error(ErrorKind::cancelled, "stopped");
    if (result.end == RequestEnd::late) fail_late(range);
    if (result.end == RequestEnd::rejected) fail(result.problem, range);

    // What came counts, and the rest is asked for.
    if (range.bytes.size() > before) {
      check_same_file(range, result, answer);
      range.count = std::min(count, answer.total_bytes - offset);
      tries = 0;
      continue;
    }
    const bool is_answered = result.end == RequestEnd::answered && result.head.status != 206;
    if (is_answered && !result.head.is_busy()) fail(status_words(result.head.status), range);
    if (++tries == kAttempts) {
      if (is_answered) fail(status_words(result.head.status), range);
      fail(result.problem.empty() ? "the server sends no bytes" : result.problem, range);
    }
    pause_as_asked(range, result, tries);
  }
  answer.bytes = std::move(range.bytes);
  answer.offset = offset;
  return answer;
} catch (const Error& error) {
  throw error.with_path(name_);
}

std::optional<RangeAnswer> RangeClient::fetch_end(std::uint64_t count,
                                                  const std::function<bool()>& is_over) try {
  RangeInProgress range{0,       count, {}, Patience(options_.timeout_s, Clock::now()),
                        [](Clock::time_point) {}, is_over, true};
  const RequestResult result = follow(range);
  if (result.end != RequestEnd::answered || result.head.status != 206) return {};
  return RangeAnswer{std::move(range.bytes), result.range.total, result.head.validator(),
                     range.offset};
} catch (...) {
  // It is asked for beside the front, by a thread of its own; real trouble meets the front as well.
  return {};
}

}  // namespace octavo
