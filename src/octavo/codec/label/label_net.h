// The probability of a yes/no question about a label, from the labels around it: a two-layer
// network in integers.
//
//      32 neighbors x 6 states --+
//      2 categories -------------+--> sum of int8 rows --> 16 x max(0, .) --> weighted sum -->
//      logit
//
// Every neighbor adds one row of 16 weights, chosen by what is known of it and whether it has the
// label asked for; so do two categories (position and history of the child, level). No input is
// multiplied: the first layer is additions of 16 lanes. Rows, sums and the logit are integers,
// equal on every machine and in every order.
//
// Rows of neighbors 2k and 2k+1 are added when a model is made, for each of the 8 x 8 things known
// of both, and so are those of the categories: a question adds 17 rows instead of 34.
//
// Ranges: a row entry is at most 127 in size, so a sum of 34 fits in 16 bits; the logit is clamped
// to +-kLogitLimit, in units of 1/256, before it becomes a probability.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/codec/entropy/binary_coder.h"

namespace octavo {

inline constexpr std::size_t kLabelNeighbors = 32;
inline constexpr std::size_t kLabelPairs = kLabelNeighbors / 2;
inline constexpr std::size_t kLabelHidden = 16;
inline constexpr std::size_t kLabelFirstCategories = 40;
inline constexpr std::size_t kLabelSecondCategories = 4;
/// Known states of a neighbor, each with "has the label" and "has not".
inline constexpr std::size_t kLabelStates = 6;
inline constexpr std::size_t kLabelRows =
    kLabelNeighbors * kLabelStates + kLabelFirstCategories + kLabelSecondCategories;
inline constexpr std::size_t kLabelWeights = (kLabelRows + 1) * kLabelHidden;

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
static_assert(kLabelUnit * kLabelUnit == 256, "a weighted sum is a logit without scaling");

class LabelNet {
 public:
  explicit LabelNet(const LabelWeights& weights);

  /// Rows of 16 weights. That of pair k with codes a and b starts at pair_offset(k, a, b).
  const std::int16_t* pairs() const { return rows_.data(); }
  /// The sum of the rows of two categories.
  const std::int16_t* categories(std::size_t first, std::size_t second) const {
    return rows_.data() + kCategoriesAt +
           kLabelHidden * (kLabelSecondCategories * first + second);
  }
  const std::int16_t* out() const { return rows_.data() + kOutAt; }

  static constexpr std::size_t pair_offset(std::size_t pair, std::size_t a, std::size_t b) {
    return kLabelHidden * (64 * pair + 8 * b + a);
  }

 private:
  static constexpr std::size_t kCategoriesAt = kLabelHidden * 64 * kLabelPairs;
  static constexpr std::size_t kOutAt =
      kCategoriesAt + kLabelHidden * kLabelFirstCategories * kLabelSecondCategories;

  alignas(64) std::array<std::int16_t, kOutAt + kLabelHidden> rows_{};
};

/// The logit of "yes", in units of 1/256: the reference.
int label_logit(const LabelNet& net, const LabelQuestion& question);

namespace detail {
/// Entry logit + kLogitLimit.
extern const std::array<std::uint16_t, 2 * kLogitLimit + 1> kProbability;
}

/// 65536 / (1 + exp(-logit / 256)), by a table and linear interpolation, within 16 .. 65520; a
/// logit beyond +-kLogitLimit counts as this limit.
[[gnu::always_inline]] inline Probability probability_of(int logit) {
  const int within = std::min(std::max(logit, -kLogitLimit), kLogitLimit);
  return detail::kProbability[static_cast<std::size_t>(within + kLogitLimit)];
}

}  // namespace octavo
