// The inner loops of training: what a batch of questions says of the weights, and a step of them.
//
// Nearly all time goes into adding rows of 16 weights; the loops are compiled once per instruction
// set (label_learning_simd.cpp) and once in plain C++ (label_learning_portable.cpp). Every sum has
// one order, so that all give the same bits: IEEE additions, products, quotients and roots, lane by
// lane, and across lanes from the first to the last.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "octavo/codec/label/label_net.h"

namespace octavo {

/// A question to learn from, and what its answer should be.
struct LabelSample {
  LabelQuestion question;
  bool answer = false;
};

/// Questions learned from at a time.
inline constexpr std::size_t kLabelBatch = 64;
using LabelBatch = std::array<const LabelSample*, kLabelBatch>;

/// A network while it is trained, in units of its weights. A question adds up the row of each of
/// its neighbors, by what is known of it, and those of its categories:
///
///     8 rows per neighbor | 40 of the first category | 4 of the second | the weights of the output
///
/// Rows 0 and 1 of a neighbor, for those outside the brick, are 0 and stay so.
struct LabelLearner {
  static constexpr std::size_t kCodes = 8;
  static constexpr std::size_t kFirst = kLabelNeighbors * kCodes;
  static constexpr std::size_t kSecond = kFirst + kLabelFirstCategories;
  static constexpr std::size_t kOut = kSecond + kLabelSecondCategories;

  using Row = std::array<float, kLabelHidden>;
  using Rows = std::array<Row, kOut + 1>;

  alignas(64) Rows start{};
  alignas(64) Rows weights{};
  alignas(64) Rows gradients{};  ///< sums over the batch; of rows that are moved 0 between batches
  alignas(64) Rows means{};      ///< of gradients
  alignas(64) Rows squares{};    ///< of gradients
  float threshold = 0;           ///< towards `start`, after every step
};

/// The rows that a batch adds, bit by bit.
struct LabelRowsSeen {
  std::array<std::uint8_t, kLabelNeighbors> codes{};
  std::uint64_t first = 0;
  std::uint64_t second = 0;

  /// Calls visit(row) for each of them that is not 0 by definition, and for the output.
  template <class Visit>
  void for_each(Visit visit) const {
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      for (std::uint32_t left = codes[i] & 0xfcu; left != 0; left &= left - 1) {
        visit(LabelLearner::kCodes * i + static_cast<std::size_t>(std::countr_zero(left)));
      }
    }
    for (std::uint64_t left = first; left != 0; left &= left - 1) {
      visit(LabelLearner::kFirst + static_cast<std::size_t>(std::countr_zero(left)));
    }
    for (std::uint64_t left = second; left != 0; left &= left - 1) {
      visit(LabelLearner::kSecond + static_cast<std::size_t>(std::countr_zero(left)));
    }
    visit(LabelLearner::kOut);
  }
};

struct LabelLearningFunctions {
  /// Adds up the gradients of a batch.
  LabelRowsSeen (*learn)(LabelLearner& learner, const LabelBatch& batch);
  /// Moves the rows of a batch against their gradients. Stochastic gradient descent after Kingma
  /// and Ba 2015 (Adam), followed by a soft threshold towards the start weights, which leaves most
  /// of them where they are.
  void (*step)(LabelLearner& learner, const LabelRowsSeen& seen, float rate);
};

/// The fastest functions this machine has, or those that OCTAVO_SIMD asks for (simd_level.h). All
/// give the same results.
const LabelLearningFunctions& label_learning_functions();

/// The functions of one instruction set, "scalar" for the portable ones (others: simd_level.h);
/// nothing when the machine lacks it.
std::optional<LabelLearningFunctions> label_learning_functions_of(std::string_view level);

const LabelLearningFunctions& portable_label_learning_functions();

namespace detail {

inline constexpr float kMeanDecay = 0.9f;
inline constexpr float kSquareDecay = 0.995f;
inline constexpr float kSmallestRoot = 1e-4f;

/// How far the probability of "yes" is from what it should be.
inline float error_of(float logit, bool answer) {
  const float units = std::clamp(logit * 256.0f, -float{kLogitLimit}, float{kLogitLimit});
  return static_cast<float>(probability_of(static_cast<int>(units))) / 65536.0f -
         (answer ? 1.0f : 0.0f);
}

}  // namespace detail

}  // namespace octavo
