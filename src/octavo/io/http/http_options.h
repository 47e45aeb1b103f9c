// How a URL is read: how patiently, who hears of waiting, and who may stop it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace octavo {

/// What a server must send on average, where it has used up its time.
inline constexpr double kFloorBytesPerSecond = 10'000;
/// After so long without an answer a wait is reported.
inline constexpr double kSilentSeconds = 5;
/// A server that is busy may ask for pauses of so long, all those of a range together, or of
/// timeout_s where that is less.
inline constexpr double kLongestPauseSeconds = 60;

struct HttpOptions {
  /// The silence that one range may cost, all attempts together, beside the pauses that a busy
  /// server asks for. Every 10 kB that arrive give a second back, so that this is also how long a
  /// server may be slower than 10 kB/s.
  double timeout_s = 60;
  /// Of the ranges of a fetch, so many are asked for at the same time, each over a connection of
  /// its own. At least 1.
  int most_requests = 6;
  /// So many bytes at the end of the file are asked for together with those at its front: what
  /// opening reads there.
  std::uint64_t end_bytes = 0;
  /// Told once a URL, on any thread, that the server makes it wait.
  std::function<void(const std::string&)> on_wait;
  /// Asked about once a second, on any thread.
  std::function<bool()> is_cancelled;
};

}  // namespace octavo
