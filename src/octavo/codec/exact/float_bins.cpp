#include "octavo/codec/exact/float_bins.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace octavo::exact {

// The rank of the smallest float that is not below where the bin begins.
std::int32_t FloatBins::first_rank(std::int64_t code) const {
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (code <= -kLargestBin) return ~(kInfinityRank - 1);
  if (code > kLargestBin) return kInfinityRank;
  const double begin = (static_cast<double>(code) - 0.5) * coding_.scale + coding_.offset;
  if (!(begin >= -kLargest)) return ~(kInfinityRank - 1);
  if (!(begin <= kLargest)) return kInfinityRank;
  const auto nearest = static_cast<float>(begin);
  return rank_of(nearest) + (static_cast<double>(nearest) < begin ? 1 : 0);
}

// The smallest short rank of a float that is not below where the bin begins.
std::int64_t FloatBins::short_first(std::int64_t code, int short_bits) const {
  const std::int64_t rank = first_rank(code);
  if (rank < 0) return ~(~rank >> short_bits);
  return (rank + (std::int64_t{1} << short_bits) - 1) >> short_bits;
}

std::int64_t FloatBins::code_of(float value) const {
  constexpr auto kMost = static_cast<double>(kLargestBin);
  const double steps = (static_cast<double>(value) - coding_.offset) / coding_.scale;
  auto code = static_cast<std::int64_t>(std::nearbyint(std::clamp(steps, -kMost, kMost)));
  // Rounding may have led to the bin beside.
  const std::int32_t rank = rank_of(value);
  while (rank < first_rank(code)) --code;
  while (rank >= first_rank(code + 1)) ++code;
  return code;
}

}  // namespace octavo::exact
