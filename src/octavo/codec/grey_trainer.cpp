// Learns a grey model: weights of the prediction by reweighted least squares, then contexts and
// frequencies (grey_context_trainer.cpp).

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string_view>

#include "octavo/codec/grey_codec.h"
#include "octavo/codec/grey_portable.h"
#include "octavo/codec/grey_training.h"
#include "octavo/codec/least_squares.h"
#include "octavo/codec/voxel_walk.h"

namespace octavo::grey {

namespace {

/// Samples by level group and split axis: more where there are more details.
constexpr std::int64_t kTapSamples[kGroups][3] = {
    {120000, 60000, 30000}, {60000, 30000, 15000}, {30000, 15000, 15000}};
constexpr std::int32_t kMaxDifference = 32000;
constexpr int kWeightStep = 3;
constexpr int kCoarseWeightStep = 5;         ///< for models that count beside what they code
constexpr std::size_t kFewBricks = 32;       ///< fewer are the whole group
constexpr std::uint64_t kLittleBytes = 1 << 18;
constexpr double kTapRidge = 1e-4;
constexpr std::size_t kOrderBricks = 8;  ///< bricks that orders are tried on
constexpr std::size_t kTrialBricks = 8;  ///< bricks that ways to quantise are tried on
constexpr std::int64_t kTrialShare = 6;  ///< one in so many samples when an order is tried
constexpr double kMuchBackground = 0.4;  ///< of the voxels, where edges are tried
constexpr std::uint64_t kEdgeHandicap = 3;  ///< percent that edges must save
constexpr double kWorthwhile = 0.0005;   ///< what another order must save
/// Steps of an orthonormal coefficient to try, in tenths of the maximum error.
constexpr int kDetailSteps[] = {14, 16, 18, 22};

/// Six times the median non-zero step between neighbours along x.
std::int32_t learn_threshold(const std::vector<Lesson>& lessons) {
  std::vector<std::int64_t> counts(65536);
  std::int64_t total = 0;
  for (const Lesson& lesson : lessons) {
    const auto& steps = lesson.brick.steps[0];
    const auto& samples = !steps[0].empty() ? steps[0] : !steps[1].empty() ? steps[1] : steps[2];
    for (std::size_t i = 1; i < samples.size(); i += 7) {
      const int step = std::abs(samples[i] - samples[i - 1]);
      if (step == 0) continue;
      ++counts[static_cast<std::size_t>(step)];
      ++total;
    }
  }
  if (total < 100) return 8;
  std::int64_t below = 0;
  std::int32_t median = 0;
  while (below * 2 < total) below += counts[static_cast<std::size_t>(++median)];
  return std::clamp(median * 6, 8, kMaxThreshold);
}

/// Neighbourhoods and details of one activity class.
struct TapSamples {
  std::vector<std::int16_t> features;
  std::vector<std::int32_t> details;
};
using ClassSamples = std::array<TapSamples, kClasses>;

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

/// Takes about `wanted` samples from a split whose samples are known.
void take_samples(const Stage& stage, Workspace<std::int16_t>& work,
                  const Truth<std::int16_t>& truth, Thinning thinning, ClassSamples& samples) {
  static thread_local SampleGrid<std::int16_t> ahead;
  repeat_along(work.means, ahead, stage.axis, work.fine.size());
  copy_margins(ahead, work.fine);
  const int axis = stage.axis;
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
      const std::int16_t* const decoded_row = first_of_row(work.fine, axis, y, z);
      const std::int16_t* const ahead_row = first_of_row(ahead, axis, y, z);
      const std::uint8_t* const activities = work.activities.row(y, z);
      const std::uint16_t* const limits = work.limits.row(y, z);
      for (std::int64_t x = 0; x < stage.pairs.x; ++x) {
        if (activities[x] == 0 || limits[x] == 0 || !thinning.keeps_next()) continue;
        const std::int16_t* const decoded = decoded_row + pair_stretch(axis) * x;
        const std::int16_t* const means = ahead_row + pair_stretch(axis) * x;
        const std::int32_t mean = *means;
        TapSamples& s = samples[activities[x]];
        const std::size_t length = s.features.size();
        s.features.resize(length + static_cast<std::size_t>(tap_count(axis)));
        std::int16_t* feature = s.features.data() + length;
        for (int r = 0; r < TapRows<std::int16_t>::kCount[axis]; ++r) {
          const std::int64_t offset = TapRows<std::int16_t>::kOffsets[axis][r];
          const TapRowState state = state_of(axis, r);
          const std::int16_t* const taps =
              (state == TapRowState::decoded ? decoded : means) + offset;
          for (int i = 0; i < 8; ++i) feature[i] = difference(taps[i], mean);
          if (state == TapRowState::own) {
            for (int i = 0; i < 3; ++i) feature[i] = difference(decoded[offset + i], mean);
          }
          feature += 8;
        }
        s.details.push_back(true_detail(truth, axis, x, y, z));
      }
    }
  }
}

/// 1 / (1 + |residual|) of every sample under the fitted weights: with them least squares come
/// closer to least absolute residuals, which is what the bits follow.
std::vector<float> weights_by_residual(const TapSamples& samples,
                                       const std::vector<double>& fitted) {
  const std::vector<float> w(fitted.begin(), fitted.end());
  std::vector<float> weights(samples.details.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const std::int16_t* f = samples.features.data() + i * w.size();
    float parts[8] = {};
    for (std::size_t k = 0; k < w.size(); k += 8) {
      for (std::size_t lane = 0; lane < 8; ++lane) {
        parts[lane] += w[k + lane] * static_cast<float>(f[k + lane]);
      }
    }
    float foreseen = 0;
    for (const float part : parts) foreseen += part;
    weights[i] = 1.0f / (std::fabs(static_cast<float>(samples.details[i]) - foreseen) + 1.0f);
  }
  return weights;
}

/// Least squares on a part of the samples, then weighted by its residuals on all of them.
std::vector<double> fit_taps(const std::vector<const TapSamples*>& samples, std::size_t count,
                             int taps) {
  std::size_t part = std::min(count, std::max<std::size_t>(count / 3, 2000));
  NormalEquations first(taps);
  for (const TapSamples* s : samples) {
    const std::size_t taken = std::min(part, s->details.size());
    part -= taken;
    accumulate(first, std::span(s->features).first(taken * static_cast<std::size_t>(taps)),
               std::span(s->details).first(taken), {});
  }
  const std::vector<double> fitted = solve(first, kTapRidge);
  NormalEquations second(taps);
  for (const TapSamples* s : samples) {
    accumulate(second, s->features, s->details, weights_by_residual(*s, fitted));
  }
  return solve(second, kTapRidge);
}

void set_weights(std::int16_t* weights, const std::vector<double>& fitted, int axis, int step) {
  std::int32_t sum = 0;
  for (int tap = 0; tap < tap_count(axis); ++tap) {
    if (tap == centre_tap(axis)) continue;
    const double scaled = fitted[static_cast<std::size_t>(tap)] * (1 << kWeightBits) / (1 << step);
    const auto limit = static_cast<double>(16000 >> step);
    const auto rounded = static_cast<std::int32_t>(std::lround(std::clamp(scaled, -limit, limit)));
    weights[tap] = static_cast<std::int16_t>(rounded * (1 << step));
    sum += weights[tap];
  }
  // The centre takes the rest, so that weights sum to zero; what 16 bits cannot hold is not worth
  // having.
  if (sum < -32767 || sum > 32767) {
    std::fill_n(weights, kMaxTaps, std::int16_t{0});
    return;
  }
  weights[centre_tap(axis)] = static_cast<std::int16_t>(-sum);
}

/// share: of the usual number of samples, one in that many.
void learn_weights(Parameters& p, const std::vector<Lesson>& lessons, int group,
                   std::int64_t share = 1) {
  std::vector<std::array<ClassSamples, 3>> by_lesson(lessons.size());
  // Samples are exact whatever predicts them, so the cheap predictor will do on the way.
  Parameters gathering = p;
  if (p.quantizer.detail_step == 0) gathering.predictor = Predictor::means;
  tbb::parallel_for(std::size_t{0}, lessons.size(), [&](std::size_t i) {
    const Lesson& lesson = lessons[i];
    for (int level = group; level < group + levels_of_group(group); ++level) {
      if (level + 1 >= lesson.shape.level_count) break;
      walk_level(gathering, lesson, level, [&](const Stage& stage, Workspace<std::int16_t>& work,
                                   const Truth<std::int16_t>& truth) {
        const std::int64_t wanted =
            kTapSamples[group][stage.axis] / share / static_cast<std::int64_t>(lessons.size());
        take_samples(stage, work, truth,
                     Thinning(wanted, stage.pairs.voxel_count(), static_cast<std::uint32_t>(i) + 1),
                     by_lesson[i][static_cast<std::size_t>(stage.axis)]);
      });
    }
  });
  tbb::parallel_for(0, 3 * (kClasses - 1), [&](int task) {
    const int axis = task % 3;
    const int activity = 1 + task / 3;
    std::vector<const TapSamples*> all;
    std::size_t count = 0;
    for (const auto& lesson : by_lesson) {
      all.push_back(
          &lesson[static_cast<std::size_t>(axis)][static_cast<std::size_t>(activity)]);
      count += all.back()->details.size();
    }
    if (count < kFewSamples) return;
    set_weights(p.weights[group][axis][activity], fit_taps(all, count, tap_count(axis)), axis,
                p.weight_step);
  });
}

/// Sums for the least squares of details on the steps between the means beside them.
struct MeanSums {
  double step_squares = 0;
  double products = 0;
};
using ClassMeanSums = std::array<std::array<MeanSums, kClasses>, 3>;

/// Details weigh 1 / (1 + step): large steps would decide alone.
void add_means(const Stage& stage, Workspace<std::int16_t>& work,
               const Truth<std::int16_t>& truth, ClassMeanSums& sums) {
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
        s.products += weight * step * true_detail(truth, stage.axis, x, y, z);
      }
    }
  }
}

void learn_mean_weights(Parameters& p, const std::vector<Lesson>& lessons, int group) {
  std::vector<ClassMeanSums> by_lesson(lessons.size());
  tbb::parallel_for(std::size_t{0}, lessons.size(), [&](std::size_t i) {
    for (int level = group; level < group + levels_of_group(group); ++level) {
      if (level + 1 >= lessons[i].shape.level_count) break;
      walk_level(p, lessons[i], level, [&](const Stage& stage, Workspace<std::int16_t>& work,
                                       const Truth<std::int16_t>& truth) {
        add_means(stage, work, truth, by_lesson[i]);
      });
    }
  });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t activity = 1; activity < kClasses; ++activity) {
      MeanSums sum;
      for (const ClassMeanSums& one : by_lesson) {
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

/// What a model is learnt from, and how well it does.
struct School {
  std::span<const TrainingBrick> bricks;
  CodecSettings settings;
  ValueMap value_map = {};
};

/// A kind of model.
struct Plan {
  Predictor predictor;
  Quantizer quantizer = {};
  int weight_step = kWeightStep;
  bool has_edges = false;
};

Parameters learn(const School& school, const Plan& plan, const AxisOrder& order) {
  Parameters p = default_parameters();
  p.axis_order = order;
  p.predictor = plan.predictor;
  p.quantizer = plan.quantizer;
  p.weight_step = plan.weight_step;
  p.value_map = school.value_map;
  p.has_edges = plan.has_edges;
  const std::vector<Lesson> lessons = make_lessons(school.bricks, p);
  if (lessons.empty()) return p;
  p.activity_threshold = learn_threshold(lessons);
  // Coarse groups first: quantised levels are learnt on what the coarser ones leave.
  for (int group = kGroups - 1; group >= 0; --group) {
    if (p.predictor == Predictor::means) learn_mean_weights(p, lessons, group);
    else learn_weights(p, lessons, group);
  }
  learn_contexts(p, lessons);
  learn_frequencies(p, lessons);
  return p;
}

/// The bits that details of level 0 need, up to a factor and a constant, when predicted by weights
/// learnt from these lessons.
double detail_cost(const std::vector<Lesson>& lessons, const AxisOrder& order) {
  Parameters p = default_parameters();
  p.axis_order = order;
  p.weight_step = kWeightStep;
  p.activity_threshold = learn_threshold(lessons);
  learn_weights(p, lessons, 0, kTrialShare);
  std::vector<double> costs(lessons.size());
  tbb::parallel_for(std::size_t{0}, lessons.size(), [&](std::size_t i) {
    walk_level(p, lessons[i], 0,
               [&](const Stage& stage, Workspace<std::int16_t>& work, const auto&) {
                 for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
                   for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
                     const std::int32_t* const residuals = work.residuals.row(y, z);
                     for (std::int64_t x = 0; x < stage.pairs.x; ++x) {
                       costs[i] += std::log2(1.0 + std::abs(residuals[x]));
                     }
                   }
                 }
               });
  });
  return std::accumulate(costs.begin(), costs.end(), 0.0);
}

/// The order of the axes whose details come out smallest on a few bricks.
AxisOrder learn_order(const School& school) {
  if (school.settings.axis_order) return *school.settings.axis_order;
  if (school.settings.preset == Preset::fast) return kStraightOrder;
  std::vector<TrainingBrick> few;
  const std::size_t count = std::min(school.bricks.size(), kOrderBricks);
  for (std::size_t i = 0; i < count; ++i) {
    few.push_back(school.bricks[(2 * i + 1) * school.bricks.size() / (2 * count)]);
  }
  AxisOrder best = kStraightOrder;
  double least = 0;
  for (const AxisOrder& order : kAxisOrders) {
    Parameters p = default_parameters();
    p.axis_order = order;
    p.value_map = school.value_map;
    const std::vector<Lesson> lessons = make_lessons(few, p);
    if (lessons.empty()) return kStraightOrder;
    double cost = detail_cost(lessons, order);
    // The straight order is the fastest; another one must be worth it.
    if (order == kStraightOrder) cost *= 1 - kWorthwhile;
    if (order == kStraightOrder || cost < least) {
      least = cost;
      best = order;
    }
  }
  return best;
}

/// Bytes that a model and a few of the training bricks take.
std::uint64_t cost(const School& school, const Parameters& parameters, std::size_t count) {
  const GreyCodec codec(parameters);
  count = std::min(school.bricks.size(), count);
  std::vector<std::uint64_t> bytes(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const TrainingBrick& brick = school.bricks[i * school.bricks.size() / count];
    for (const Bytes& segment : codec.encode(brick.shape, brick.view).segments) {
      bytes[i] += segment.size();
    }
  });
  return std::accumulate(bytes.begin(), bytes.end(), codec.serialized().size());
}

/// Which part of the voxels of these bricks holds the smallest value of its brick.
double background_share(std::span<const TrainingBrick> bricks) {
  std::int64_t background = 0;
  std::int64_t voxels = 0;
  for (const TrainingBrick& brick : bricks) {
    const std::int64_t min = range_of(brick.view).min;
    for_each_voxel(brick.view, [&](std::int64_t voxel) { background += voxel == min; });
    voxels += brick.view.size.voxel_count();
  }
  return static_cast<double>(background) / static_cast<double>(std::max<std::int64_t>(voxels, 1));
}

/// The ways to keep within a maximum error: rounding the voxels; or rounding the details, with
/// several steps, and correcting the voxels that end up beyond it.
std::vector<Quantizer> quantizers_for(std::int64_t max_error) {
  const std::int64_t step = 2 * max_error + 1;
  std::vector<Quantizer> all = {{step, 0, 0}};
  if (max_error == 0) return all;
  for (const int tenths : kDetailSteps) {
    const std::int64_t detail_step = max_error * tenths * 256 / 10;
    if (detail_step <= kMaxDetailStep) {
      all.push_back({1, static_cast<std::int32_t>(detail_step), step});
    }
  }
  return all;
}

}  // namespace

}  // namespace octavo::grey

namespace octavo {

std::unique_ptr<BrickCodec> train_grey_model(VoxelType type, std::span<const TrainingBrick> bricks,
                                             const CodecSettings& settings) {
  using namespace grey;
  if (!is_integer(type))
    throw Error(ErrorKind::invalid_argument, "float voxels have no grey codec");
  if (settings.max_error < 0 || 2 * settings.max_error + 1 > kMaxVoxelStep) {
    throw Error(ErrorKind::invalid_argument, "the maximum error is out of range");
  }
  School school{bricks, settings};
  // A scan that may change has no values of its own.
  if (settings.max_error == 0) {
    school.value_map = learn_value_map(bricks, settings.preset == Preset::small);
  }
  const AxisOrder order = learn_order(school);
  const Predictor predictor =
      settings.preset == Preset::fast ? Predictor::means : Predictor::neighbours;
  std::vector<Plan> others;
  for (const Quantizer& quantizer : quantizers_for(settings.max_error)) {
    others.push_back({predictor, quantizer});
  }
  std::size_t trial = kTrialBricks;
  Parameters best = learn(school, others.front(), order);
  others.erase(others.begin());
  if (settings.max_error == 0 && settings.preset == Preset::small && bricks.size() < kFewBricks) {
    // These bricks are all there are: where they take little, the model counts.
    trial = bricks.size();
    if (cost(school, best, trial) < kLittleBytes) {
      others = {{Predictor::means}, {Predictor::neighbours, {}, kCoarseWeightStep}};
    }
  }
  if (settings.max_error == 0 && background_share(bricks) >= kMuchBackground) {
    others.push_back({predictor, {}, kWeightStep, true});
    if (predictor != Predictor::means) others.push_back({Predictor::means, {}, kWeightStep, true});
  }
  if (others.empty()) return std::make_unique<GreyCodec>(best);
  std::uint64_t least = cost(school, best, trial);
  for (const Plan& plan : others) {
    const Parameters p = learn(school, plan, order);
    std::uint64_t bytes = cost(school, p, trial);
    // Edges make decoding slower.
    if (plan.has_edges) bytes += bytes * kEdgeHandicap / 100;
    if (bytes >= least) continue;
    least = bytes;
    best = p;
  }
  return std::make_unique<GreyCodec>(best);
}

}  // namespace octavo
