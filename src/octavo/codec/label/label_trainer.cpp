#include "octavo/codec/label/label_trainer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

namespace octavo {

namespace {

constexpr std::size_t kRows = kLabelRows;
constexpr std::size_t kOut = kRows;  // the output weights stand behind the rows
constexpr std::size_t kLanes = kLabelHidden;
constexpr std::size_t kBatch = 64;
constexpr float kLastRate = 0.00005f;
constexpr float kMeanDecay = 0.9f;
constexpr float kSquareDecay = 0.995f;
constexpr float kSmallest = 1e-4f;
constexpr std::size_t kFewest = 500;

using Row = std::array<float, kLanes>;
using Matrix = std::array<Row, kRows + 1>;
using Sample = LabelSamples::Sample;

/// The rows a question adds up.
struct ActiveRows {
  std::array<std::uint16_t, kLabelNeighbors + 2> row{};
  std::size_t count = 0;

  explicit ActiveRows(const LabelQuestion& question) {
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      if (question.neighbor[i] >= 2) add(kLabelStates * i + question.neighbor[i] - 2u);
    }
    add(kLabelNeighbors * kLabelStates + std::size_t{question.first});
    add(kLabelNeighbors * kLabelStates + kLabelFirstCategories + std::size_t{question.second});
  }
  void add(std::size_t i) { row[count++] = static_cast<std::uint16_t>(i); }
};

/// Stochastic gradient descent after Kingma and Ba 2015 (Adam), each step followed by a soft
/// threshold towards the start weights, which leaves most of them where they are.
class Trainer {
 public:
  Trainer(const LabelWeights& start, float threshold) : threshold_(threshold) {
    for (std::size_t i = 0; i <= kRows; ++i) {
      for (std::size_t j = 0; j < kLanes; ++j) {
        start_[i][j] = static_cast<float>(start[i * kLanes + j]) / kLabelUnit;
      }
    }
    weights_ = start_;
  }

  void learn(const Sample& sample) {
    const ActiveRows active(sample.question);
    Row sum{};
    for (std::size_t k = 0; k < active.count; ++k) {
      const Row& row = weights_[active.row[k]];
      for (std::size_t j = 0; j < kLanes; ++j) sum[j] += row[j];
    }
    float logit = 0;
    for (std::size_t j = 0; j < kLanes; ++j) logit += std::max(sum[j], 0.0f) * weights_[kOut][j];
    const float error = probability(logit) - (sample.answer ? 1.0f : 0.0f);
    Row slope{};
    for (std::size_t j = 0; j < kLanes; ++j) {
      gradient_[kOut][j] += error * std::max(sum[j], 0.0f);
      slope[j] = sum[j] > 0 ? error * weights_[kOut][j] : 0.0f;
    }
    for (std::size_t k = 0; k < active.count; ++k) {
      touch(active.row[k]);
      Row& row = gradient_[active.row[k]];
      for (std::size_t j = 0; j < kLanes; ++j) row[j] += slope[j];
    }
  }

  void step(float rate) {
    touch(kOut);
    for (const std::size_t row : touched_) {
      is_touched_[row] = false;
      step_row(row, rate);
    }
    touched_.clear();
  }

  LabelWeights quantized(int step) const {
    LabelWeights result{};
    for (std::size_t i = 0; i <= kRows; ++i) {
      for (std::size_t j = 0; j < kLanes; ++j) {
        const auto start = static_cast<int>(std::lrint(start_[i][j] * kLabelUnit));
        const float move = (weights_[i][j] - start_[i][j]) * kLabelUnit;
        const auto steps = static_cast<int>(std::lrint(move / static_cast<float>(step)));
        result[i * kLanes + j] = moved(start, step * steps, step);
      }
    }
    return result;
  }

 private:
  static float probability(float logit) {
    const float units = std::clamp(logit * 256.0f, -float{kLogitLimit}, float{kLogitLimit});
    return static_cast<float>(probability_of(static_cast<int>(units))) / 65536.0f;
  }

  static std::int8_t moved(int start, int move, int step) {
    while (start + move > 127) move -= step;
    while (start + move < -127) move += step;
    return static_cast<std::int8_t>(start + move);
  }

  void touch(std::size_t row) {
    if (is_touched_[row]) return;
    is_touched_[row] = true;
    touched_.push_back(row);
  }

  void step_row(std::size_t i, float rate) {
    for (std::size_t j = 0; j < kLanes; ++j) {
      const float gradient = gradient_[i][j] / static_cast<float>(kBatch);
      gradient_[i][j] = 0;
      mean_[i][j] = kMeanDecay * mean_[i][j] + (1 - kMeanDecay) * gradient;
      square_[i][j] = kSquareDecay * square_[i][j] + (1 - kSquareDecay) * gradient * gradient;
      const float scale = rate / (std::sqrt(square_[i][j]) + kSmallest);
      const float move = weights_[i][j] - scale * mean_[i][j] - start_[i][j];
      const float kept = std::max(std::abs(move) - scale * threshold_, 0.0f);
      weights_[i][j] = start_[i][j] + (move < 0 ? -kept : kept);
    }
  }

  float threshold_;
  Matrix start_{};
  Matrix weights_{};
  Matrix gradient_{};
  Matrix mean_{};
  Matrix square_{};
  std::array<bool, kRows + 1> is_touched_{};
  std::vector<std::size_t> touched_;
};

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
  if (seen_count_++ % stride_ != 0) return;
  if (list_.size() == capacity_) {
    for (std::size_t i = 0; i < capacity_ / 2; ++i) list_[i] = list_[2 * i];
    list_.resize(capacity_ / 2);
    stride_ *= 2;
  }
  list_.push_back({question, answer});
}

LabelWeights trained(const LabelWeights& start, std::span<const Sample> samples,
                     std::uint64_t seen_count, const LabelTraining& training) {
  if (samples.size() < kFewest) return start;
  const auto trainer =
      std::make_unique<Trainer>(start, training.move_cost / static_cast<float>(seen_count));
  const std::vector<std::uint32_t> order = shuffled(samples.size());
  const std::size_t batches = samples.size() / kBatch;
  const std::size_t steps = batches * static_cast<std::size_t>(training.epochs);
  for (std::size_t batch = 0; batch < steps; ++batch) {
    const std::size_t first = batch % batches * kBatch;
    for (std::size_t i = first; i < first + kBatch; ++i) trainer->learn(samples[order[i]]);
    const float done = static_cast<float>(batch) / static_cast<float>(steps);
    trainer->step(training.rate * (1 - done) + kLastRate);
  }
  return trainer->quantized(training.step);
}

}  // namespace octavo
