#include <algorithm>
#include <cmath>

#include "octavo/codec/label/label_learning.h"

namespace octavo {

namespace {

using Row = LabelLearner::Row;

// Calls visit(row) for the rows that a question adds, in their order.
template <class Visit>
void for_each_row(const LabelQuestion& question, Visit visit) {
  for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
    visit(LabelLearner::kCodes * i + question.neighbor[i]);
  }
  visit(LabelLearner::kFirst + question.first);
  visit(LabelLearner::kSecond + question.second);
}

LabelRowsSeen learn(LabelLearner& learner, const LabelBatch& batch) {
  LabelRowsSeen seen;
  const Row& out = learner.weights[LabelLearner::kOut];
  Row& out_gradient = learner.gradients[LabelLearner::kOut];
  for (const LabelSample* const sample : batch) {
    const LabelQuestion& question = sample->question;
    Row sum{};
    for_each_row(question, [&](std::size_t i) {
      const Row& row = learner.weights[i];
      for (std::size_t j = 0; j < kLabelHidden; ++j) sum[j] += row[j];
    });
    float logit = 0;
    for (std::size_t j = 0; j < kLabelHidden; ++j) logit += std::max(sum[j], 0.0f) * out[j];
    const float error = detail::error_of(logit, sample->answer);
    Row slope{};
    for (std::size_t j = 0; j < kLabelHidden; ++j) {
      out_gradient[j] += error * std::max(sum[j], 0.0f);
      slope[j] = sum[j] > 0 ? error * out[j] : 0.0f;
    }
    for_each_row(question, [&](std::size_t i) {
      Row& row = learner.gradients[i];
      for (std::size_t j = 0; j < kLabelHidden; ++j) row[j] += slope[j];
    });
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      seen.codes[i] = static_cast<std::uint8_t>(seen.codes[i] | 1u << question.neighbor[i]);
    }
    seen.first |= std::uint64_t{1} << question.first;
    seen.second |= std::uint64_t{1} << question.second;
  }
  return seen;
}

void step_row(LabelLearner& learner, std::size_t i, float rate) {
  using detail::kMeanDecay;
  using detail::kSquareDecay;
  Row& weights = learner.weights[i];
  const Row& start = learner.start[i];
  for (std::size_t j = 0; j < kLabelHidden; ++j) {
    const float gradient = learner.gradients[i][j] / static_cast<float>(kLabelBatch);
    float& mean = learner.means[i][j];
    float& square = learner.squares[i][j];
    mean = kMeanDecay * mean + (1 - kMeanDecay) * gradient;
    square = kSquareDecay * square + (1 - kSquareDecay) * gradient * gradient;
    const float scale = rate / (std::sqrt(square) + detail::kSmallestRoot);
    const float move = weights[j] - scale * mean - start[j];
    const float kept = std::max(std::abs(move) - scale * learner.threshold, 0.0f);
    weights[j] = start[j] + (move < 0 ? -kept : kept);
  }
  learner.gradients[i] = {};
}

void step(LabelLearner& learner, const LabelRowsSeen& seen, float rate) {
  seen.for_each([&](std::size_t row) { step_row(learner, row, rate); });
}

}  // namespace

const LabelLearningFunctions& portable_label_learning_functions() {
  static constexpr LabelLearningFunctions kFunctions = {learn, step};
  return kFunctions;
}

}  // namespace octavo
