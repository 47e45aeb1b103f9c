#include "octavo/codec/label/label_trainer.h"

#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "octavo/codec/label/label_learning.h"

namespace octavo {

namespace {

constexpr float kLastRate = 0.00005f;
constexpr std::size_t kFewest = 500;

/// Calls visit(row of a learner, row of the weights of a model) for all rows.
template <class Visit>
void for_each_row(Visit visit) {
  std::size_t row = 0;
  for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
    for (std::size_t code = 2; code < LabelLearner::kCodes; ++code) {
      visit(LabelLearner::kCodes * i + code, row++);
    }
  }
  for (std::size_t i = LabelLearner::kFirst; i <= LabelLearner::kOut; ++i) visit(i, row++);
}

std::unique_ptr<LabelLearner> learner_from(const LabelWeights& start) {
  auto learner = std::make_unique<LabelLearner>();
  for_each_row([&](std::size_t to, std::size_t from) {
    for (std::size_t j = 0; j < kLabelHidden; ++j) {
      learner->start[to][j] = static_cast<float>(start[from * kLabelHidden + j]) / kLabelUnit;
    }
  });
  learner->weights = learner->start;
  return learner;
}

std::int8_t moved(int start, int move, int step) {
  while (start + move > 127) move -= step;
  while (start + move < -127) move += step;
  return static_cast<std::int8_t>(start + move);
}

/// The weights as integers, whole numbers of steps from the start.
LabelWeights quantized(const LabelLearner& learner, int step) {
  LabelWeights result{};
  for_each_row([&](std::size_t from, std::size_t to) {
    for (std::size_t j = 0; j < kLabelHidden; ++j) {
      const auto start = static_cast<int>(std::lrint(learner.start[from][j] * kLabelUnit));
      const float move = (learner.weights[from][j] - learner.start[from][j]) * kLabelUnit;
      const auto steps = static_cast<int>(std::lrint(move / static_cast<float>(step)));
      result[to * kLabelHidden + j] = moved(start, step * steps, step);
    }
  });
  return result;
}

/// A fixed permutation of 0 .. count-1 (Fisher-Yates with a linear congruential generator).
std::vector<std::uint32_t> shuffled(std::size_t count) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::uint64_t state = 1;
  for (std::size_t i = count; i > 1; --i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    std::swap(order[i - 1], order[(state >> 33) % i]);
  }
  return order;
}

}  // namespace

void LabelSamples::add(const LabelQuestion& question, bool answer) {
  if (list_.empty()) list_.reserve(capacity_);
  if (list_.size() == capacity_) {
    for (std::size_t i = 0; i < capacity_ / 2; ++i) list_[i] = list_[2 * i];
    list_.resize(capacity_ / 2);
    stride_ *= 2;
  }
  list_.push_back({question, answer});
}

LabelWeights trained(const LabelWeights& start, std::span<const LabelSample> samples,
                     std::uint64_t seen_count, const LabelTraining& training) {
  if (samples.size() < kFewest) return start;
  const LabelLearningFunctions& learning = label_learning_functions();
  const auto learner = learner_from(start);
  learner->threshold = training.move_cost / static_cast<float>(seen_count);
  const std::vector<std::uint32_t> order = shuffled(samples.size());
  const std::size_t batches = samples.size() / kLabelBatch;
  const std::size_t steps = batches * static_cast<std::size_t>(training.epochs);
  LabelBatch batch;
  for (std::size_t number = 0; number < steps; ++number) {
    const std::uint32_t* const first = order.data() + number % batches * kLabelBatch;
    const std::uint32_t* const next = order.data() + (number + 1) % batches * kLabelBatch;
    for (std::size_t i = 0; i < kLabelBatch; ++i) {
      batch[i] = &samples[first[i]];
      __builtin_prefetch(&samples[next[i]]);  // far apart, so that nobody else would
    }
    const LabelRowsSeen seen = learning.learn(*learner, batch);
    const float done = static_cast<float>(number) / static_cast<float>(steps);
    learning.step(*learner, seen, training.rate * (1 - done) + kLastRate);
  }
  return quantized(*learner, training.step);
}

}  // namespace octavo
