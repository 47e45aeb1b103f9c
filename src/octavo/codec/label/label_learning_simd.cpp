// The inner loops of training for every instruction set that Highway knows, chosen at run time.

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "octavo/codec/label/label_learning.h"
#include "octavo/codec/simd_level.h"

#include "octavo/codec/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/codec/label/label_learning_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

LabelRowsSeen learn_labels(LabelLearner& learner, const LabelBatch& batch) {
  return portable_label_learning_functions().learn(learner, batch);
}

void step_labels(LabelLearner& learner, const LabelRowsSeen& seen, float rate) {
  portable_label_learning_functions().step(learner, seen, rate);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<float, kLabelHidden> kLanes{};
using Lanes = hn::Vec<decltype(kLanes)>;

/// Sums of samples are made side by side: each addition of one waits for the one before.
constexpr std::size_t kAtOnce = 4;

/// The row of a neighbor's weights or gradients, from lane `j` of `rows` on.
template <class T>
HWY_INLINE T* row_of(T* rows, std::size_t neighbor, const LabelQuestion& question) {
  const std::size_t code = question.neighbor.data()[neighbor];
  return rows + kLabelHidden * (LabelLearner::kCodes * neighbor + code);
}
template <class T>
HWY_INLINE T* first_row_of(T* rows, const LabelQuestion& question) {
  return rows + kLabelHidden * (LabelLearner::kFirst + question.first);
}
template <class T>
HWY_INLINE T* second_row_of(T* rows, const LabelQuestion& question) {
  return rows + kLabelHidden * (LabelLearner::kSecond + question.second);
}

/// The sums over the rows of some questions.
HWY_INLINE void add_rows(const float* weights, const LabelSample* const* samples, Lanes* sums) {
  for (std::size_t s = 0; s < kAtOnce; ++s) sums[s] = hn::Zero(kLanes);
  for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
    for (std::size_t s = 0; s < kAtOnce; ++s) {
      sums[s] = hn::Add(sums[s], hn::Load(kLanes, row_of(weights, i, samples[s]->question)));
    }
  }
  for (std::size_t s = 0; s < kAtOnce; ++s) {
    const LabelQuestion& question = samples[s]->question;
    sums[s] = hn::Add(sums[s], hn::Load(kLanes, first_row_of(weights, question)));
    sums[s] = hn::Add(sums[s], hn::Load(kLanes, second_row_of(weights, question)));
  }
}

HWY_INLINE void add_to_row(Lanes slope, float* row) {
  hn::Store(hn::Add(hn::Load(kLanes, row), slope), kLanes, row);
}

/// What rows the questions of a batch add.
HWY_INLINE LabelRowsSeen rows_seen(const LabelBatch& batch) {
  constexpr hn::FixedTag<std::uint8_t, 16> bytes;
  alignas(16) static constexpr std::uint8_t kBits[16] = {1, 2, 4, 8, 16, 32, 64, 128};
  const auto bits = hn::Load(bytes, kBits);
  LabelRowsSeen seen;
  auto low = hn::Zero(bytes);
  auto high = hn::Zero(bytes);
  for (const LabelSample* const sample : batch) {
    const LabelQuestion& question = sample->question;
    const std::uint8_t* const codes = question.neighbor.data();
    low = hn::Or(low, hn::TableLookupBytes(bits, hn::LoadU(bytes, codes)));
    high = hn::Or(high, hn::TableLookupBytes(bits, hn::LoadU(bytes, codes + 16)));
    seen.first |= std::uint64_t{1} << question.first;
    seen.second |= std::uint64_t{1} << question.second;
  }
  hn::StoreU(low, bytes, seen.codes.data());
  hn::StoreU(high, bytes, seen.codes.data() + 16);
  return seen;
}

LabelRowsSeen learn_labels(LabelLearner& learner, const LabelBatch& batch) {
  const LabelSample* const* const samples = batch.data();
  const float* const out = learner.weights[LabelLearner::kOut].data();
  alignas(64) float sums[kLabelBatch][kLabelHidden];
  alignas(64) float products[kLabelBatch][kLabelHidden];
  const auto zero = hn::Zero(kLanes);

  // What reaches the output.
  for (std::size_t sample = 0; sample < kLabelBatch; sample += kAtOnce) {
    for (std::size_t j = 0; j < kLabelHidden; j += hn::Lanes(kLanes)) {
      Lanes added[kAtOnce];
      add_rows(learner.weights.front().data() + j, samples + sample, added);
      for (std::size_t s = 0; s < kAtOnce; ++s) {
        hn::Store(added[s], kLanes, sums[sample + s] + j);
        const auto active = hn::Max(added[s], zero);
        hn::Store(hn::Mul(active, hn::Load(kLanes, out + j)), kLanes, products[sample + s] + j);
      }
    }
  }

  // The errors of the answers, eight at a time: a logit is summed up lane by lane.
  constexpr std::size_t kLogitsAtOnce = 8;
  float errors[kLabelBatch];
  for (std::size_t sample = 0; sample < kLabelBatch; sample += kLogitsAtOnce) {
    float logits[kLogitsAtOnce] = {};
    for (std::size_t j = 0; j < kLabelHidden; ++j) {
      for (std::size_t s = 0; s < kLogitsAtOnce; ++s) logits[s] += products[sample + s][j];
    }
    for (std::size_t s = 0; s < kLogitsAtOnce; ++s) {
      errors[sample + s] = detail::error_of(logits[s], samples[sample + s]->answer);
    }
  }

  // The gradients of the output, and of the rows of each question.
  for (std::size_t j = 0; j < kLabelHidden; j += hn::Lanes(kLanes)) {
    const auto weights = hn::Load(kLanes, out + j);
    float* const gradients = learner.gradients.front().data() + j;
    float* const out_gradients = gradients + kLabelHidden * LabelLearner::kOut;
    auto of_output = hn::Load(kLanes, out_gradients);
    for (std::size_t sample = 0; sample < kLabelBatch; ++sample) {
      const auto error = hn::Set(kLanes, errors[sample]);
      const auto sum = hn::Load(kLanes, sums[sample] + j);
      of_output = hn::Add(of_output, hn::Mul(error, hn::Max(sum, zero)));
      const auto slope = hn::IfThenElseZero(hn::Gt(sum, zero), hn::Mul(error, weights));
      const LabelQuestion& question = samples[sample]->question;
      for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
        add_to_row(slope, row_of(gradients, i, question));
      }
      add_to_row(slope, first_row_of(gradients, question));
      add_to_row(slope, second_row_of(gradients, question));
    }
    hn::Store(of_output, kLanes, out_gradients);
  }
  return rows_seen(batch);
}

HWY_INLINE void step_row(LabelLearner& learner, std::size_t i, float rate) {
  using detail::kMeanDecay;
  using detail::kSquareDecay;
  const auto set = [](float value) { return hn::Set(kLanes, value); };
  for (std::size_t j = 0; j < kLabelHidden; j += hn::Lanes(kLanes)) {
    const std::size_t at = kLabelHidden * i + j;
    float* const means = learner.means.front().data() + at;
    float* const squares = learner.squares.front().data() + at;
    float* const weights = learner.weights.front().data() + at;
    float* const gradients = learner.gradients.front().data() + at;
    // A quotient by a power of two.
    const auto gradient =
        hn::Mul(hn::Load(kLanes, gradients), set(1.0f / static_cast<float>(kLabelBatch)));
    const auto mean = hn::Add(hn::Mul(set(kMeanDecay), hn::Load(kLanes, means)),
                              hn::Mul(set(1 - kMeanDecay), gradient));
    const auto square =
        hn::Add(hn::Mul(set(kSquareDecay), hn::Load(kLanes, squares)),
                hn::Mul(hn::Mul(set(1 - kSquareDecay), gradient), gradient));
    const auto scale =
        hn::Div(set(rate), hn::Add(hn::Sqrt(square), set(detail::kSmallestRoot)));
    const auto start = hn::Load(kLanes, learner.start.front().data() + at);
    const auto move = hn::Sub(hn::Sub(hn::Load(kLanes, weights), hn::Mul(scale, mean)), start);
    const auto kept = hn::Max(hn::Sub(hn::Abs(move), hn::Mul(scale, set(learner.threshold))),
                              hn::Zero(kLanes));
    const auto signed_kept =
        hn::IfThenElse(hn::Lt(move, hn::Zero(kLanes)), hn::Neg(kept), kept);
    hn::Store(mean, kLanes, means);
    hn::Store(square, kLanes, squares);
    hn::Store(hn::Add(start, signed_kept), kLanes, weights);
    hn::Store(hn::Zero(kLanes), kLanes, gradients);
  }
}

void step_labels(LabelLearner& learner, const LabelRowsSeen& seen, float rate) {
  seen.for_each([&](std::size_t row) HWY_ATTR { step_row(learner, row, rate); });
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo {

HWY_EXPORT(learn_labels);
HWY_EXPORT(step_labels);

namespace {

/// Those for the best of `targets`; the portable ones for none.
LabelLearningFunctions functions_of(std::int64_t targets) {
  if (targets == 0) return portable_label_learning_functions();
  const SimdTargetsInUse in_use(targets);
  return {HWY_DYNAMIC_DISPATCH(learn_labels), HWY_DYNAMIC_DISPATCH(step_labels)};
}

}  // namespace

const LabelLearningFunctions& label_learning_functions() {
  static const LabelLearningFunctions functions = functions_of(chosen_simd_targets());
  return functions;
}

std::optional<LabelLearningFunctions> label_learning_functions_of(std::string_view level) {
  if (level == "scalar") return portable_label_learning_functions();
  const std::int64_t targets = simd_targets_of(level);
  if (targets == 0) return std::nullopt;
  return functions_of(targets);
}

}  // namespace octavo
#endif
