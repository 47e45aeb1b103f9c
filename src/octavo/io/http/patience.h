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

  /// Seconds since the last bytes.
  double silence(Time now) const { return std::chrono::duration<double>(now - fed_).count(); }

 private:
  void drain(Time now) {
    left_ -= std::chrono::duration<double>(now - at_).count();
    at_ = now;
  }

  double seconds_;
  double left_;
  Time at_;
  Time fed_;
};

}  // namespace octavo
