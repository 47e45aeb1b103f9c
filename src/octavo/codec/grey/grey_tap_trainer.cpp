// Learns the weights of the prediction by reweighted least squares on a sample of the details.
//
// Least squares alone would follow the few large residuals. Samples are weighted so that the fit
// comes close to the bits that residuals take: first by the steps among their neighbors, then,
// twice, by the residual that the last fit leaves as well.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string_view>

#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/grey/grey_training.h"
#include "octavo/codec/grey/least_squares.h"

namespace octavo::grey {

namespace {

/// Samples by level group and split axis: more where there are more details.
constexpr std::int64_t kTapSamples[kGroups][3] = {
    {120000, 60000, 30000}, {60000, 30000, 15000}, {30000, 15000, 15000}};
constexpr std::int32_t kMaxDifference = 32000;
constexpr double kTapRidge = 1e-4;
/// Rounds of a fit: one in so many samples takes part, the first weighted by steps alone.
constexpr std::size_t kRounds[] = {12, 4, 1};
constexpr std::size_t kTrialRounds[] = {1};  ///< when an order is tried
constexpr std::size_t kFewInRound = 2000;
constexpr std::int64_t kTrialShare = 6;  ///< one in so many samples when an order is tried

/// Neighborhoods and details of one activity class.
struct TapSamples {
  std::vector<std::int16_t> features;  ///< tap_count for each detail
  std::vector<std::int32_t> details;
};

/// By activity; class 0 is not predicted and has none.
using ClassSamples = std::array<TapSamples, kClasses>;
using AxisSamples = std::array<ClassSamples, 3>;

/// Where a row of taps of an axis stands in the order of decoding.
enum class TapRowState { decoded, ahead, own };

/// The own row and its partner are decoded up to the pair.
TapRowState state_of(int axis, int r) {
  constexpr std::string_view kStates[3] = {"dadadaddaa", "ddooaddddaaa", "dddddoadoaaa"};
  const char state = kStates[axis][static_cast<std::size_t>(r)];
  return state == 'd' ? TapRowState::decoded : state == 'a' ? TapRowState::ahead : TapRowState::own;
}

std::int16_t difference(std::int32_t tap, std::int32_t mean) {
  return static_cast<std::int16_t>(std::clamp(tap - mean, -kMaxDifference, kMaxDifference));
}

/// The differences between the neighbors of pair (x, y, z) and its mean, as taps see them.
void append_features(const Stage& stage, Workspace<std::int16_t>& work,
                     SampleGrid<std::int16_t>& ahead, const Index3& pair,
                     std::vector<std::int16_t>& features) {
  const int axis = stage.axis;
  const std::int64_t along = pair_stretch(axis) * pair.x;
  const std::int16_t* const decoded = first_of_row(work.fine, axis, pair.y, pair.z) + along;
  const std::int16_t* const means = first_of_row(ahead, axis, pair.y, pair.z) + along;
  const std::int32_t mean = *means;
  const std::size_t length = features.size();
  features.resize(length + static_cast<std::size_t>(tap_count(axis)));
  std::int16_t* feature = features.data() + length;
  for (int r = 0; r < TapRows<std::int16_t>::kCount[axis]; ++r, feature += 8) {
    const std::int64_t offset = TapRows<std::int16_t>::kOffsets[axis][r];
    const TapRowState state = state_of(axis, r);
    const std::int16_t* const taps = (state == TapRowState::decoded ? decoded : means) + offset;
    for (int i = 0; i < 8; ++i) feature[i] = difference(taps[i], mean);
    if (state != TapRowState::own) continue;
    for (int i = 0; i < 3; ++i) feature[i] = difference(decoded[offset + i], mean);
  }
}

/// Takes about `wanted` samples from a split whose samples are known: one out of each of as many
/// equal shares.
void take_samples(const Stage& stage, Workspace<std::int16_t>& work,
                  const Target<std::int16_t>& target, std::int64_t wanted, std::uint32_t seed,
                  ClassSamples& samples) {
  static thread_local SampleGrid<std::int16_t> ahead;
  repeat_along(work.means, ahead, stage.axis, work.fine.size());
  copy_margins(ahead, work.fine);
  const std::int64_t total = stage.pairs.voxel_count();
  const std::int64_t shares = std::min(wanted, total);
  std::uint32_t state = seed * 2654435761u + 12345u;
  for (std::int64_t share = 0; share < shares; ++share) {
    state = state * 1664525u + 1013904223u;
    const std::int64_t at = ((share << 16) + (state >> 16)) * total / shares >> 16;
    const std::int64_t row = at / stage.pairs.x;
    const Index3 pair{at % stage.pairs.x, row % stage.pairs.y, row / stage.pairs.y};
    const std::size_t activity = work.activities.row(pair.y, pair.z)[pair.x];
    if (activity == 0 || work.limits.row(pair.y, pair.z)[pair.x] == 0) continue;
    append_features(stage, work, ahead, pair, samples[activity].features);
    samples[activity].details.push_back(target_detail(target, stage.axis, pair.x, pair.y, pair.z));
  }
}

/// The samples of the levels of a group that each training sample gives, by axis and class.
/// share  of the usual number of samples, one in that many
std::vector<AxisSamples> gather(const Parameters& p, const std::vector<TrainingSample>& training,
                                int group, std::int64_t share) {
  std::vector<AxisSamples> by_sample(training.size());
  // Samples are exact whatever predicts them, so the cheap predictor will do on the way.
  Parameters gathering = p;
  if (p.quantizer.detail_step == 0) gathering.predictor = Predictor::means;
  tbb::parallel_for(std::size_t{0}, training.size(), [&](std::size_t i) {
    const TrainingSample& sample = training[i];
    for (int level = group; level < group + levels_of_group(group); ++level) {
      if (level + 1 >= sample.shape.level_count) break;
      walk_level(gathering, sample, level, Margins::all,
                 [&](const Stage& stage, Workspace<std::int16_t>& work,
                     const Target<std::int16_t>& target, const PartNumber& part) {
                   const std::int64_t wanted = kTapSamples[group][stage.axis] / share /
                                               static_cast<std::int64_t>(training.size()) /
                                               part.count;
                   const auto seed = static_cast<std::uint32_t>(
                       static_cast<std::int64_t>(i) * part.count + part.number + 1);
                   take_samples(stage, work, target, wanted, seed,
                                by_sample[i][static_cast<std::size_t>(stage.axis)]);
                 });
    }
  });
  return by_sample;
}

/// The magnitude of a sample's residual under the fitted weights.
float residual_magnitude(const std::int16_t* features, std::int32_t detail,
                         const std::vector<float>& fitted) {
  float parts[8] = {};
  for (std::size_t k = 0; k < fitted.size(); k += 8) {
    for (std::size_t lane = 0; lane < 8; ++lane) {
      parts[lane] += fitted[k + lane] * static_cast<float>(features[k + lane]);
    }
  }
  float predicted = 0;
  for (const float part : parts) predicted += part;
  return std::fabs(static_cast<float>(detail) - predicted);
}

/// 1 + the mean step from a sample to its neighbors.
float mean_step(const std::int16_t* features, std::size_t taps) {
  std::int32_t sum = 0;
  for (std::size_t k = 0; k < taps; ++k) sum += std::abs(std::int32_t{features[k]});
  return 1.0f + static_cast<float>(sum) / static_cast<float>(taps);
}

/// Without `fitted`: 1 / step. With it: 1 / ((1 + |residual|) * sqrt(step)).
std::vector<float> sample_weights(const TapSamples& samples, std::size_t taps,
                                  const std::vector<double>* fitted) {
  std::vector<float> weights(samples.details.size());
  std::vector<float> w;
  if (fitted != nullptr) w.assign(fitted->begin(), fitted->end());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const std::int16_t* const f = samples.features.data() + i * taps;
    const float step = mean_step(f, taps);
    weights[i] = 1.0f / step;
    if (fitted == nullptr) continue;
    weights[i] = 1.0f / ((1.0f + residual_magnitude(f, samples.details[i], w)) * std::sqrt(step));
  }
  return weights;
}

/// One in `every` of the samples, from the first on.
TapSamples thinned(const TapSamples& samples, std::size_t taps, std::size_t first,
                   std::size_t every) {
  TapSamples few;
  for (std::size_t i = first; i < samples.details.size(); i += every) {
    const auto from = samples.features.begin() + static_cast<std::ptrdiff_t>(i * taps);
    few.features.insert(few.features.end(), from, from + static_cast<std::ptrdiff_t>(taps));
    few.details.push_back(samples.details[i]);
  }
  return few;
}

std::vector<double> fit_taps(const std::vector<const TapSamples*>& samples, std::size_t count,
                             int taps, std::span<const std::size_t> rounds) {
  std::vector<double> fitted;
  const auto n = static_cast<std::size_t>(taps);
  for (const std::size_t round : rounds) {
    const std::size_t every = std::clamp<std::size_t>(count / kFewInRound, 1, round);
    const std::vector<double>* const last = fitted.empty() ? nullptr : &fitted;
    NormalEquations equations(taps);
    std::size_t first = every / 2;
    for (const TapSamples* s : samples) {
      if (every == 1) {
        accumulate(equations, s->features, s->details, sample_weights(*s, n, last));
        continue;
      }
      const TapSamples few = thinned(*s, n, first, every);
      accumulate(equations, few.features, few.details, sample_weights(few, n, last));
      // The next training sample goes on where this one ends.
      first += few.details.size() * every - s->details.size();
    }
    fitted = solve(equations, kTapRidge);
  }
  return fitted;
}

void set_weights(std::int16_t* weights, const std::vector<double>& fitted, int axis, int step) {
  std::int32_t sum = 0;
  for (int tap = 0; tap < tap_count(axis); ++tap) {
    if (tap == center_tap(axis)) continue;
    const double scaled = fitted[static_cast<std::size_t>(tap)] * (1 << kWeightBits) / (1 << step);
    const auto limit = static_cast<double>(16000 >> step);
    const auto rounded = static_cast<std::int32_t>(std::lround(std::clamp(scaled, -limit, limit)));
    weights[tap] = static_cast<std::int16_t>(rounded * (1 << step));
    sum += weights[tap];
  }
  // The center takes the rest, so that weights sum to zero; what 16 bits cannot hold is not worth
  // having.
  if (sum < -32767 || sum > 32767) {
    std::fill_n(weights, kMaxTaps, std::int16_t{0});
    return;
  }
  weights[center_tap(axis)] = static_cast<std::int16_t>(-sum);
}

/// Learns p.weights of a group from its samples.
void fit_weights(Parameters& p, const std::vector<AxisSamples>& by_sample, int group,
                 std::span<const std::size_t> rounds) {
  tbb::parallel_for(0, 3 * (kClasses - 1), [&](int task) {
    const int axis = task % 3;
    const int activity = 1 + task / 3;
    std::vector<const TapSamples*> all;
    std::size_t count = 0;
    for (const AxisSamples& one : by_sample) {
      all.push_back(&one[static_cast<std::size_t>(axis)][static_cast<std::size_t>(activity)]);
      count += all.back()->details.size();
    }
    if (count < kFewSamples) return;
    set_weights(p.weights[group][axis][activity], fit_taps(all, count, tap_count(axis), rounds),
                axis, p.weight_step);
  });
}

/// The logarithm to base 2 of n > 0 in 1/256, linear between powers of two.
std::uint64_t logarithm(std::uint64_t n) {
  const int whole = bit_length(n) - 1;
  return (static_cast<std::uint64_t>(whole) << 8) + ((n << 8 >> whole) - 256);
}

/// Sums for the least squares of details on the steps between the means beside them.
struct MeanSums {
  double step_squares = 0;
  double products = 0;
};
using ClassMeanSums = std::array<std::array<MeanSums, kClasses>, 3>;

/// Details weigh 1 / (1 + step): large steps would decide alone.
void add_means(const Stage& stage, Workspace<std::int16_t>& work,
               const Target<std::int16_t>& target, ClassMeanSums& sums) {
  const std::int64_t along = pair_step<std::int16_t>(stage.axis);
  auto& of_classes = sums[static_cast<std::size_t>(stage.axis)];
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
      const std::int16_t* const means = work.means.row(y, z);
      const std::uint8_t* const activities = work.activities.row(y, z);
      for (std::int64_t x = 0; x < stage.pairs.x; ++x) {
        const double step = means[x - along] - means[x + along];
        const double weight = 1 / (1 + std::fabs(step));
        MeanSums& s = of_classes[activities[x]];
        s.step_squares += weight * step * step;
        s.products += weight * step * target_detail(target, stage.axis, x, y, z);
      }
    }
  }
}

}  // namespace

void learn_weights(Parameters& p, const std::vector<TrainingSample>& training, int group) {
  fit_weights(p, gather(p, training, group, 1), group, kRounds);
}

double detail_cost(Parameters p, const std::vector<TrainingSample>& training) {
  fit_weights(p, gather(p, training, 0, kTrialShare), 0, kTrialRounds);
  std::vector<std::uint64_t> costs(training.size());
  tbb::parallel_for(std::size_t{0}, training.size(), [&](std::size_t i) {
    walk_level(p, training[i], 0,
               [&](const Stage& stage, Workspace<std::int16_t>& work, const auto&,
                   const PartNumber&) {
                 for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
                   for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
                     const std::int32_t* const residuals = work.residuals.row(y, z);
                     for (std::int64_t x = 0; x < stage.pairs.x; ++x) {
                       const std::int32_t magnitude = std::abs(residuals[x]);
                       costs[i] += logarithm(1u + static_cast<std::uint32_t>(magnitude));
                     }
                   }
                 }
               });
  });
  const std::uint64_t cost = std::accumulate(costs.begin(), costs.end(), std::uint64_t{0});
  return static_cast<double>(cost);
}

void learn_mean_weights(Parameters& p, const std::vector<TrainingSample>& training, int group) {
  std::vector<ClassMeanSums> by_sample(training.size());
  tbb::parallel_for(std::size_t{0}, training.size(), [&](std::size_t i) {
    for (int level = group; level < group + levels_of_group(group); ++level) {
      if (level + 1 >= training[i].shape.level_count) break;
      walk_level(p, training[i], level,
                 [&](const Stage& stage, Workspace<std::int16_t>& work,
                     const Target<std::int16_t>& target, const PartNumber&) {
                   add_means(stage, work, target, by_sample[i]);
                 });
    }
  });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t activity = 1; activity < kClasses; ++activity) {
      MeanSums sum;
      for (const ClassMeanSums& one : by_sample) {
        sum.step_squares += one[axis][activity].step_squares;
        sum.products += one[axis][activity].products;
      }
      if (sum.step_squares < 1) continue;
      const double weight = sum.products / sum.step_squares * (1 << kWeightBits);
      p.mean_weights[group][axis][activity] = static_cast<std::int32_t>(
          std::lround(std::clamp<double>(weight, -kMaxMeanWeight, kMaxMeanWeight)));
    }
  }
}

}  // namespace octavo::grey
