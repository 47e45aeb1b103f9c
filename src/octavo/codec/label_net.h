// The probability of a yes/no question about a label, from the labels around it: a two-layer
// network in integers.
//
//      32 neighbors x 6 states --+
//      2 categories -------------+--> sum of int8 rows --> 16 x max(0, .) --> weighted sum -->
//      logit
//
// Every neighbor adds one row of 16 weights, chosen by what is known of it and whether it has the
// label asked for; so do two categories (position and history of the child, level). No input is
// multiplied: the first layer is 34 additions of 16 lanes. Rows, sums and the logit are integers,
// equal on every machine.
//
// Ranges: a row entry is at most 127 in size, so a sum of 34 fits in 16 bits; the logit is clamped
// to +-kLogitLimit, in units of 1/256, before it becomes a probability.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/codec/binary_coder.h"

namespace octavo {

inline constexpr int kLabelNeighbors = 32;
inline constexpr int kLabelHidden = 16;
inline constexpr int kLabelFirstCategories = 40;
inline constexpr int kLabelSecondCategories = 4;
/// Known states of a neighbor, each with "has the label" and "has not".
inline constexpr int kLabelStates = 6;
inline constexpr int kLabelRows =
    kLabelNeighbors * kLabelStates + kLabelFirstCategories + kLabelSecondCategories;
inline constexpr int kLabelWeights = (kLabelRows + 1) * kLabelHidden;

inline constexpr int kLogitLimit = 11 * 256;

/// What a network is asked about. neighbor[i] = 2 * state + equal, state 0 (outside the brick) ..
/// 3.
struct LabelQuestion {
  std::array<std::uint8_t, kLabelNeighbors> neighbor;
  std::uint8_t first = 0;
  std::uint8_t second = 0;
};

/// Weights as the format has them: row (6 * neighbor + 2 * (state - 1) + equal), then the rows of
/// the first and of the second category, then the row of output weights.
using LabelWeights = std::array<std::int8_t, kLabelWeights>;

/// Units of the weights: a hidden sum of kLabelUnit times an output weight of kLabelUnit is a logit
/// of 1.
inline constexpr int kLabelUnit = 16;

class LabelNet {
 public:
  explicit LabelNet(const LabelWeights& weights);

  /// The logit of "yes", in units of 1/256.
  int logit(const LabelQuestion& question) const;

 private:
  using Row = std::array<std::int16_t, kLabelHidden>;

  /// Row 8 * neighbor + state code; those of state 0 are zero.
  alignas(32) std::array<Row, kLabelNeighbors * 8> neighbor_{};
  alignas(32) std::array<Row, kLabelFirstCategories + kLabelSecondCategories> category_{};
  alignas(32) Row out_{};
};

namespace detail {
/// Entry logit + kLogitLimit.
extern const std::array<std::uint16_t, 2 * kLogitLimit + 1> kProbability;
}

/// 65536 / (1 + exp(-logit / 256)), by a table and linear interpolation, within 16 .. 65520.
/// Requires a logit within +-kLogitLimit.
inline Probability probability_of(int logit) {
  return detail::kProbability[static_cast<std::size_t>(logit + kLogitLimit)];
}

inline int LabelNet::logit(const LabelQuestion& question) const {
  // First layer: one row per input.
  Row sum = category_[question.first];
  const auto add = [&](const Row& row) {
    for (std::size_t j = 0; j < kLabelHidden; ++j) {
      sum[j] = static_cast<std::int16_t>(sum[j] + row[j]);
    }
  };
  add(category_[kLabelFirstCategories + std::size_t{question.second}]);
  for (std::size_t i = 0; i < kLabelNeighbors; ++i) add(neighbor_[8 * i + question.neighbor[i]]);

  // Second layer.
  std::int32_t total = 0;
  for (std::size_t j = 0; j < kLabelHidden; ++j) total += std::max<int>(sum[j], 0) * out_[j];
  static_assert(256 % (kLabelUnit * kLabelUnit) == 0);
  return std::clamp(total * (256 / (kLabelUnit * kLabelUnit)), -kLogitLimit, kLogitLimit);
}

}  // namespace octavo
