#include "octavo/file/storage/round_meter.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

/// Less than such a part of a round no clock tells reliably.
constexpr double kMinimumShare = 1.0 / 16;

}  // namespace

void RoundMeter::add(double seconds, std::uint64_t bytes) {
  if (!std::isfinite(seconds) || seconds <= 0) return;
  if (bytes <= kSmallBytes) round_seconds_ = std::min(round_seconds_, seconds);
  // A much smaller one than before says less, later ones more.
  if (bytes < std::max(kLargeBytes, large_bytes_ / 8)) return;
  large_seconds_ = seconds;
  large_bytes_ = bytes;
}

std::uint64_t RoundMeter::bytes_per_round() const {
  if (large_bytes_ == 0 || !std::isfinite(round_seconds_)) return 0;
  const double extra = std::max(large_seconds_ - round_seconds_, kMinimumShare * round_seconds_);
  const double bytes = static_cast<double>(large_bytes_) * (round_seconds_ / extra);
  return static_cast<std::uint64_t>(std::min(bytes, 0x1p62));
}

}  // namespace octavo
