// Learns the weights of the prediction by reweighted least squares on a sample of the details.
//
// Least squares alone would follow the few large residuals. Samples are weighted so that the fit
// comes close to the bits that residuals take: first by the steps among their neighbors, then,
// round after round, by the residual that the last fit leaves as well.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <string_view>

#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/grey/grey_training.h"
#include "octavo/codec/grey/least_squares.h"
#include "octavo/threads/parallel_for.h"

namespace octavo::grey {

namespace {

/// Samples by level group and split axis: more where there are more details.
constexpr std::int64_t kTapSamples[kGroups][3] = {
    {120000, 60000, 30000}, {60000, 30000, 15000}, {30000, 15000, 15000}};
/// Of a split, one in so many pairs at most: neighboring pairs tell much the same.
constexpr std::int64_t kPairsOfSample = 3;
constexpr std::int64_t kEnoughOfSplit = 8000;
constexpr std::int32_t kMaxDifference = 32000;
constexpr double kTapRidge = 1e-4;
/// Rounds of a fit: one in so many samples takes part, the first weighted by steps alone.
constexpr std::size_t kRounds[] = {12, 4, 4, 2, 1};
constexpr std::size_t kTrialRounds[] = {1};  ///< when an order is tried
constexpr std::size_t kFewInRound = 2000;
/// One in so many samples when an order is tried, and when weights are refined.
constexpr std::int64_t kTrialShare = 6;
constexpr std::int64_t kRefiningShare = 6;
/// What the weights before weigh in a refinement, relative to the samples.
constexpr double kStartTrust = 0.003;

/// Neighborhoods and details of the pairs of a split axis.
struct AxisSamples {
  std::vector<std::int16_t> features;  ///< tap_count for each detail
  std::vector<std::int32_t> details;
  /// By activity, which of them; class 0 is not predicted and has none.
  std::array<std::vector<std::uint32_t>, kClasses> of_class;
};
using TapSamples = std::array<AxisSamples, 3>;

/// Where a row of taps of an axis stands in the order of decoding.
enum class TapRowState { decoded, ahead, own };

/// The own row and its partner are decoded up to the pair.
TapRowState state_of(int axis, int r) {
  constexpr std::string_view kStates[3] = {"dadadaddaa", "ddooaddddaaa", "dddddoadoaaa"};
  const char state = kStates[axis][static_cast<std::size_t>(r)];
  return state == 'd' ? TapRowState::decoded : state == 'a' ? TapRowState::ahead : TapRowState::own;
}

/// 8 neighbors less a mean, within +-kMaxDifference.
struct Differences {
  explicit Differences(std::int32_t mean)
      : from(static_cast<std::int16_t>(mean)),
        lowest(static_cast<std::int16_t>(std::max(mean - kMaxDifference, -32768))),
        highest(static_cast<std::int16_t>(std::min(mean + kMaxDifference, 32767))) {}

  void put(const std::int16_t* __restrict taps, int first, int last,
           std::int16_t* __restrict to) const {
    for (int i = first; i < last; ++i) {
      to[i] = static_cast<std::int16_t>(std::min(std::max(taps[i], lowest), highest) - from);
    }
  }

  std::int16_t from;
  std::int16_t lowest;
  std::int16_t highest;
};

/// The differences between the neighbors of pair (x, y, z) and its mean, as taps see them.
void append_features(const Stage& stage, Workspace<std::int16_t>& work,
                     SampleGrid<std::int16_t>& ahead, const Index3& pair,
                     std::vector<std::int16_t>& features) {
  const int axis = stage.axis;
  const std::int64_t along = pair_stretch(axis) * pair.x;
  const std::int16_t* const decoded = first_of_row(work.fine, axis, pair.y, pair.z) + along;
  const std::int16_t* const means = first_of_row(ahead, axis, pair.y, pair.z) + along;
  const Differences differences(*means);
  const std::size_t length = features.size();
  features.resize(length + static_cast<std::size_t>(tap_count(axis)));
  std::int16_t* feature = features.data() + length;
  for (int r = 0; r < TapRows<std::int16_t>::kCount[axis]; ++r, feature += 8) {
    const std::int64_t offset = TapRows<std::int16_t>::kOffsets[axis][r];
    const TapRowState state = state_of(axis, r);
    differences.put((state == TapRowState::decoded ? decoded : means) + offset, 0, 8, feature);
    if (state == TapRowState::own) differences.put(decoded + offset, 0, 3, feature);
  }
}

/// Takes about `wanted` samples from a split whose samples are known: one out of each of as many
/// equal shares.
void take_samples(const Stage& stage, Workspace<std::int16_t>& work,
                  const Target<std::int16_t>& target, std::int64_t wanted, std::uint32_t seed,
                  AxisSamples& samples) {
  static thread_local SampleGrid<std::int16_t> ahead;
  repeat_along(work.means, ahead, stage.axis, work.fine.size());
  copy_margins(ahead, work.fine);
  const std::int64_t total = stage.pairs.voxel_count();
  const std::int64_t shares = std::min(wanted, total);
  const auto expected = samples.details.size() + static_cast<std::size_t>(shares);
  samples.features.reserve(expected * static_cast<std::size_t>(tap_count(stage.axis)));
  std::uint32_t state = seed * 2654435761u + 12345u;
  for (std::int64_t share = 0; share < shares; ++share) {
    state = state * 1664525u + 1013904223u;
    const std::int64_t at = ((share << 16) + (state >> 16)) * total / shares >> 16;
    const std::int64_t row = at / stage.pairs.x;
    const Index3 pair{at % stage.pairs.x, row % stage.pairs.y, row / stage.pairs.y};
    const std::size_t activity = work.activities.row(pair.y, pair.z)[pair.x];
    if (activity == 0 || work.limits.row(pair.y, pair.z)[pair.x] == 0) continue;
    samples.of_class[activity].push_back(static_cast<std::uint32_t>(samples.details.size()));
    append_features(stage, work, ahead, pair, samples.features);
    samples.details.push_back(target_detail(target, stage.axis, pair.x, pair.y, pair.z));
  }
}

/// The samples of the levels of a group that each training sample gives, by axis and class.
/// share  of the usual number of samples, one in that many
std::vector<TapSamples> gather(const Parameters& p, const std::vector<TrainingSample>& training,
                               int group, std::int64_t share) {
  std::vector<TapSamples> by_sample(training.size());
  // Exact details need no prediction on the way.
  const bool is_exact = p.quantizer.detail_step == 0;
  Parameters gathering = p;
  if (is_exact) gathering.predictor = Predictor::means;
  parallel_for(std::size_t{0}, training.size(), [&](std::size_t i) {
    const TrainingSample& sample = training[i];
    for (int level = group; level < group + levels_of_group(group); ++level) {
      if (level + 1 >= sample.shape.level_count) break;
      walk_level(gathering, sample, level, Margins::all,
                 [&](const Stage& stage, Workspace<std::int16_t>& work,
                     const Target<std::int16_t>& target, const PartNumber& part) {
                   if (is_exact) measure_split(gathering, stage, work, target);
                   else predict_split(gathering, stage, work, target);
                   const std::int64_t wanted = std::min(
                       kTapSamples[group][stage.axis] / share /
                           static_cast<std::int64_t>(training.size()) / part.count,
                       std::max(kEnoughOfSplit, stage.pairs.voxel_count() / kPairsOfSample));
                   const auto seed = static_cast<std::uint32_t>(
                       static_cast<std::int64_t>(i) * part.count + part.number + 1);
                   take_samples(stage, work, target, wanted, seed,
                                by_sample[i][static_cast<std::size_t>(stage.axis)]);
                 });
    }
  });
  return by_sample;
}

/// The root of a sample's weight. `residual` is what a fit leaves of its detail; without one, the
/// first fit is to be made. 1 / step, or 1 / ((1 + |residual|) * sqrt(step)).
float weight_root(const SampleMeasures& measured, std::size_t taps,
                  std::optional<float> residual) {
  const float step = 1.0f + static_cast<float>(measured.sum) / static_cast<float>(taps);
  if (!residual) return 1.0f / std::sqrt(step);
  return 1.0f / std::sqrt((1.0f + std::fabs(*residual)) * std::sqrt(step));
}

/// The samples of an activity class among those of a split axis, in order.
struct ClassSamples {
  std::vector<const AxisSamples*> of_axis;
  std::size_t activity = 0;
  std::size_t count = 0;
};

/// Calls f(features, detail) for one in `every` of the samples, from the `first` on.
template <class F>
void for_some_samples(const ClassSamples& samples, std::size_t taps, std::size_t every,
                      std::size_t first, F&& f) {
  std::size_t next = first;
  for (const AxisSamples* const s : samples.of_axis) {
    const std::vector<std::uint32_t>& numbers = s->of_class[samples.activity];
    const auto features = [&](std::size_t i) {
      return std::span(s->features.data() + numbers[i] * taps, taps);
    };
    for (; next < numbers.size(); next += every) {
      const std::size_t ahead = next + kFetchedAhead * every;
      if (ahead < numbers.size()) fetch_features(features(ahead));
      f(features(next), s->details[numbers[next]]);
    }
    next -= numbers.size();
  }
}

/// Adds one in `every` of the samples. weights: of the fit before, Q12; none: there was none
void add_samples(const ClassSamples& samples, std::size_t taps, std::size_t every,
                 std::span<const std::int16_t> weights, NormalEquations& equations) {
  const std::size_t first = every - 1 - every / 2;
  for_some_samples(samples, taps, every, first, [&](auto features, std::int32_t detail) {
    const SampleMeasures measured = measure(features, weights);
    std::optional<float> residual;
    if (!weights.empty()) {
      residual = static_cast<float>(detail) -
                 static_cast<float>(measured.predicted) / (1 << kWeightBits);
    }
    equations.add(features, detail, measured, weight_root(measured, taps, residual));
  });
}

/// Weights as a fit gives them, rounded to Q12.
std::vector<std::int16_t> rounded(const std::vector<double>& fitted) {
  std::vector<std::int16_t> weights;
  for (const double weight : fitted) {
    weights.push_back(static_cast<std::int16_t>(
        std::lround(std::clamp<double>(weight * (1 << kWeightBits), -16000, 16000))));
  }
  return weights;
}

std::vector<double> fit_taps(const ClassSamples& samples, int taps,
                             std::span<const std::size_t> rounds) {
  std::vector<double> fitted;
  const auto n = static_cast<std::size_t>(taps);
  for (const std::size_t round : rounds) {
    const std::size_t every = std::clamp<std::size_t>(samples.count / kFewInRound, 1, round);
    NormalEquations equations(n);
    add_samples(samples, n, every, rounded(fitted), equations);
    equations.finish();
    fitted = solve(equations.matrix(), equations.right(), kTapRidge);
  }
  return fitted;
}

/// Whether details take fewer bits without these weights, by one in so many samples. Squares follow
/// the steps at edges, where details are all or nothing.
bool is_better_without(const ClassSamples& samples, std::span<const std::int16_t> weights) {
  constexpr std::size_t kEvery = 4;
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  for_some_samples(samples, weights.size(), kEvery, 0, [&](auto features, std::int32_t detail) {
    const std::int32_t predicted = measure(features, weights).predicted >> (kWeightBits - 4);
    with += logarithm(16 + static_cast<std::uint64_t>(std::abs(16 * detail - predicted)));
    without += logarithm(16 + static_cast<std::uint64_t>(std::abs(16 * detail)));
  });
  return without <= with;
}

/// Weights between those of another model and those that fit samples best.
std::vector<double> refine_taps(const ClassSamples& samples, int taps, const std::int16_t* start) {
  const auto n = static_cast<std::size_t>(taps);
  NormalEquations equations(n);
  add_samples(samples, n, 1, {start, n}, equations);
  equations.finish();
  std::vector<double> matrix = equations.matrix();
  std::vector<double> right = equations.right();
  for (std::size_t k = 0; k < n; ++k) {
    double& own = matrix[k * n + k];
    right[k] += kStartTrust * own * start[k] / (1 << kWeightBits);
    own += kStartTrust * own;
  }
  return solve(std::move(matrix), std::move(right), kTapRidge);
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

/// Learns p.weights of a group from its samples. Where `refines`, weights that are there are a
/// start.
void fit_weights(Parameters& p, const std::vector<TapSamples>& by_sample, int group,
                 std::span<const std::size_t> rounds, bool refines) {
  parallel_for(0, 3 * (kClasses - 1), [&](int task) {
    const int axis = task % 3;
    const int activity = 1 + task / 3;
    ClassSamples samples{{}, static_cast<std::size_t>(activity), 0};
    for (const TapSamples& one : by_sample) {
      samples.of_axis.push_back(&one[static_cast<std::size_t>(axis)]);
      samples.count += samples.of_axis.back()->of_class[samples.activity].size();
    }
    if (samples.count < kFewSamples) return;
    std::int16_t* const weights = p.weights[group][axis][activity];
    const int taps = tap_count(axis);
    const bool has_start = std::any_of(weights, weights + taps, [](int w) { return w != 0; });
    set_weights(weights,
                refines && has_start ? refine_taps(samples, taps, weights)
                                     : fit_taps(samples, taps, rounds),
                axis, p.weight_step);
    if (is_better_without(samples, {weights, static_cast<std::size_t>(taps)})) {
      std::fill_n(weights, kMaxTaps, std::int16_t{0});
    }
  });
}

}  // namespace

void learn_weights(Parameters& p, const std::vector<TrainingSample>& training, int group) {
  fit_weights(p, gather(p, training, group, 1), group, kRounds, false);
}

void refine_weights(Parameters& p, const std::vector<TrainingSample>& training, int group) {
  fit_weights(p, gather(p, training, group, kRefiningShare), group, kRounds, true);
}

void coarsen_weights(Parameters& p) {
  for (auto& group : p.weights) {
    for (int axis = 0; axis < 3; ++axis) {
      for (auto& weights : group[axis]) {
        std::vector<double> fine;
        for (int tap = 0; tap < tap_count(axis); ++tap) {
          fine.push_back(static_cast<double>(weights[tap]) / (1 << kWeightBits));
        }
        set_weights(weights, fine, axis, p.weight_step);
      }
    }
  }
}

double detail_cost(Parameters p, const std::vector<TrainingSample>& training) {
  fit_weights(p, gather(p, training, 0, kTrialShare), 0, kTrialRounds, false);
  std::vector<std::uint64_t> costs(training.size());
  parallel_for(std::size_t{0}, training.size(), [&](std::size_t i) {
    walk_level(p, training[i], 0,
               [&](const Stage& stage, Workspace<std::int16_t>& work,
                   const Target<std::int16_t>& target, const PartNumber&) {
                 predict_split(p, stage, work, target);
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

}  // namespace octavo::grey
