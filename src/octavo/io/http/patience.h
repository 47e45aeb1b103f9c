// How much longer a server may make us wait for a range.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "octavo/io/http/http_options.h"

namespace octavo {

/// A bucket of seconds that drains with time; bytes refill it at 10 kB a second, never above its
/// start. Silence empties it after `seconds`, and so does a trickle, a little later.
class Patience {
 public:
  using Time = std::chrono::steady_clock::time_point;

  Patience(double seconds, Time now) : seconds_(seconds), left_(seconds), at_(now), fed_(now) {}

  double seconds() const { return seconds_; }

  void feed(std::uint64_t bytes, Time now) {
    drain(now);
    left_ = std::min(seconds_, left_ + static_cast<double>(bytes) / kFloorBytesPerSecond);
    fed_ = now;
  }

  /// Seconds that are left; 0 or less where it has ended.
  double left(Time now) {
    drain(now);
    return left_;
  }

  /// A silence that was announced, and is over, costs nothing and gives nothing back.
  void leave_out(double seconds) {
    const auto time = std::chrono::duration_cast<Time::duration>(
        std::chrono::duration<double>(seconds));
    at_ += time;
    fed_ += time;
    left_out_ += seconds;
  }

  /// Seconds that were left out, all together.
  double left_out() const { return left_out_; }

  /// Seconds since the last bytes, but for those that were left out.
  double silence(Time now) const { return std::chrono::duration<double>(now - fed_).count(); }

 private:
  void drain(Time now) {
    left_ -= std::chrono::duration<double>(now - at_).count();
    at_ = now;
  }

  double seconds_;
  double left_;
  double left_out_ = 0;
  Time at_;
  Time fed_;
};

}  // namespace octavo
