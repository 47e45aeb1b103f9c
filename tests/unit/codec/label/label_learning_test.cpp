// The inner loops of training: every instruction set against the portable ones, bit by bit.
#include "octavo/codec/label/label_learning.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include "octavo/codec/label/label_start_weights.h"
#include "octavo/codec/label/label_trainer.h"

namespace octavo {
namespace {

std::vector<LabelSample> random_samples(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<LabelSample> samples(count);
  for (LabelSample& sample : samples) {
    for (std::uint8_t& code : sample.question.neighbor) {
      code = static_cast<std::uint8_t>(random() % 3 == 0 ? random() % 8 : 5);
    }
    sample.question.first = static_cast<std::uint8_t>(random() % kLabelFirstCategories);
    sample.question.second = static_cast<std::uint8_t>(random() % kLabelSecondCategories);
    sample.answer = random() % 4 == 0;
  }
  return samples;
}

std::unique_ptr<LabelLearner> random_learner(std::uint32_t seed) {
  std::mt19937 random(seed);
  auto learner = std::make_unique<LabelLearner>();
  for (std::size_t i = 0; i <= LabelLearner::kOut; ++i) {
    const bool is_zero =
        i < LabelLearner::kFirst && i % LabelLearner::kCodes < 2;  // outside the brick
    for (float& weight : learner->start[i]) {
      weight = is_zero ? 0 : static_cast<float>(static_cast<int>(random() % 255) - 127) / 16;
    }
  }
  learner->weights = learner->start;
  learner->threshold = 0.0001f;
  return learner;
}

// Learns from all whole batches of samples; returns the moved weights.
std::unique_ptr<LabelLearner> after_learning(const LabelLearningFunctions& functions,
                                             const std::vector<LabelSample>& samples) {
  auto learner = random_learner(1);
  for (std::size_t at = 0; at + kLabelBatch <= samples.size(); at += kLabelBatch) {
    LabelBatch batch;
    for (std::size_t i = 0; i < kLabelBatch; ++i) batch[i] = &samples[at + i];
    const LabelRowsSeen seen = functions.learn(*learner, batch);
    functions.step(*learner, seen, 0.01f);
  }
  return learner;
}

bool has_same_bits(const LabelLearner::Rows& a, const LabelLearner::Rows& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

TEST(LabelLearning, EveryInstructionSetGivesTheSameBits) {
  const auto samples = random_samples(40 * kLabelBatch, 2);
  const auto expected = after_learning(portable_label_learning_functions(), samples);
  EXPECT_FALSE(has_same_bits(expected->weights, expected->start));
  int compared = 0;
  for (const char* level : {"scalar", "sse4", "avx2", "avx512", "neon"}) {
    const auto functions = label_learning_functions_of(level);
    if (!functions) continue;
    ++compared;
    const auto found = after_learning(*functions, samples);
    EXPECT_TRUE(has_same_bits(found->weights, expected->weights)) << level;
    EXPECT_TRUE(has_same_bits(found->means, expected->means)) << level;
    EXPECT_TRUE(has_same_bits(found->squares, expected->squares)) << level;
  }
  EXPECT_GE(compared, 1);
}

TEST(LabelLearning, RowsThatNoQuestionAddsStayAsTheyAre) {
  std::vector<LabelSample> samples = random_samples(kLabelBatch, 3);
  for (LabelSample& sample : samples) {
    sample.question.neighbor.fill(6);
    sample.question.neighbor[7] = 1;
    sample.question.first = 39;
    sample.question.second = 0;
  }
  const auto learner = after_learning(label_learning_functions(), samples);
  for (std::size_t i = 0; i <= LabelLearner::kOut; ++i) {
    const bool is_added = i < LabelLearner::kFirst ? i % 8 == 6 && i / 8 != 7
                                                   : i == LabelLearner::kFirst + 39 ||
                                                         i == LabelLearner::kSecond ||
                                                         i == LabelLearner::kOut;
    EXPECT_EQ(learner->weights[i] != learner->start[i], is_added) << "row " << i;
  }
}

TEST(LabelTrainer, WeightsFollowTheAnswers) {
  std::vector<LabelSample> samples = random_samples(6000, 4);
  for (LabelSample& sample : samples) sample.answer = sample.question.neighbor[0] >= 5;
  const LabelWeights start = label_start_weights()[0];
  const LabelWeights moved = trained(start, samples, samples.size(), {.step = 2});
  EXPECT_NE(moved, start);
  const LabelNet before(start);
  const LabelNet after(moved);
  int better = 0;
  for (const LabelSample& sample : samples) {
    const int sign = sample.answer ? 1 : -1;
    better += sign * label_logit(after, sample.question) >
              sign * label_logit(before, sample.question);
  }
  // By chance it would be 3000, give or take 39.
  EXPECT_GT(better, 3500);
}

TEST(LabelTrainer, FewSamplesMoveNothing) {
  const LabelWeights start = label_start_weights()[1];
  EXPECT_EQ(trained(start, random_samples(499, 5), 499, {}), start);
}

}  // namespace
}  // namespace octavo
