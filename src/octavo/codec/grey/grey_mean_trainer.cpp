// Learns the weights of the prediction from means by reweighted least squares on some rows of the
// details, as grey_tap_trainer.cpp does for those of neighbors.

#include <algorithm>
#include <cmath>
#include <optional>

#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/grey/grey_training.h"
#include "octavo/threads/parallel_for.h"

namespace octavo::grey {

namespace {

/// What a detail is predicted from when it is the means: the steps between those one and two away,
/// and what the detail behind has beyond a usual share of its step.
struct MeanSample {
  std::int32_t near = 0;
  std::int32_t far = 0;
  std::int32_t behind = 0;
  std::int32_t detail = 0;
};
using ClassMeanSamples = std::array<std::vector<MeanSample>, kClasses>;

/// Those of a split axis, of one training sample after the other: sums of real numbers depend on
/// their order.
struct AxisMeanSamples {
  const std::vector<std::array<ClassMeanSamples, 3>>& by_sample;
  std::size_t axis;

  template <class F>
  void for_each(std::size_t activity, F&& f) const {
    for (const auto& one : by_sample) {
      for (const MeanSample& sample : one[axis][activity]) f(sample);
    }
  }
  bool has(std::size_t activity) const {
    return std::any_of(by_sample.begin(), by_sample.end(),
                       [&](const auto& one) { return !one[axis][activity].empty(); });
  }
};

/// Weighted sums of products of the terms of samples.
struct MeanSums {
  double near_near = 0, near_far = 0, far_far = 0;
  double near_behind = 0, far_behind = 0, behind_behind = 0;
  double near_detail = 0, far_detail = 0, behind_detail = 0;

  void add(const MeanSample& s, double weight) {
    const double near = s.near;
    const double far = s.far;
    const double behind = s.behind;
    const double detail = s.detail;
    near_near += weight * near * near;
    near_far += weight * near * far;
    far_far += weight * far * far;
    near_behind += weight * near * behind;
    far_behind += weight * far * behind;
    behind_behind += weight * behind * behind;
    near_detail += weight * near * detail;
    far_detail += weight * far * detail;
    behind_detail += weight * behind * detail;
  }
};
using ClassMeanSums = std::array<MeanSums, kClasses>;

/// Samples of a split axis at a level, about; all there are where they are few. A few weights need
/// no more.
constexpr std::int64_t kMeanSamples = 150000;

/// Takes the pairs of one row in `every`.
void take_means(const Stage& stage, Workspace<std::int16_t>& work,
                const Target<std::int16_t>& target, std::int64_t every,
                ClassMeanSamples& samples) {
  constexpr int kUsualShare = 2;  // a logarithm
  const std::int64_t along = pair_step<std::int16_t>(stage.axis);
  const auto near_at = [along](const std::int16_t* means) {
    return std::int32_t{means[-along]} - means[along];
  };
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = z % every; y < stage.pairs.y; y += every) {
      const std::int16_t* const means = work.means.row(y, z);
      const std::uint8_t* const activities = work.activities.row(y, z);
      const std::uint16_t* const limits = work.limits.row(y, z);
      const std::int16_t* const means_behind = z > 0 ? work.means.row(y, z - 1) : nullptr;
      const std::uint16_t* const limits_behind = z > 0 ? work.limits.row(y, z - 1) : nullptr;
      for (std::int64_t x = 0; x < stage.pairs.x; ++x) {
        if (limits[x] == 0 || activities[x] == 0) continue;
        MeanSample sample{near_at(means + x), means[x - 2 * along] - means[x + 2 * along], 0,
                          target_detail(target, stage.axis, x, y, z)};
        if (z > 0 && limits_behind[x] != 0) {
          sample.behind = target_detail(target, stage.axis, x, y, z - 1) -
                          (near_at(means_behind + x) >> kUsualShare);
        }
        samples[activities[x]].push_back(sample);
      }
    }
  }
}

/// The weights of a class that explain most of the details, given the far share of slopes.
struct MeanWeights {
  double slope = 0;
  double behind = 0;
  double explained = 0;
};

MeanWeights fit_means(const MeanSums& s, double share) {
  const double slopes = s.near_near + share * (2 * s.near_far + share * s.far_far);
  const double both = s.near_behind + share * s.far_behind;
  const double slope_details = s.near_detail + share * s.far_detail;
  const double determinant = slopes * s.behind_behind - both * both;
  MeanWeights fitted;
  if (determinant > 1e-6 * slopes * s.behind_behind) {
    fitted.slope = (slope_details * s.behind_behind - s.behind_detail * both) / determinant;
    fitted.behind = (s.behind_detail * slopes - slope_details * both) / determinant;
  } else if (slopes > 0) {
    fitted.slope = slope_details / slopes;
  }
  fitted.explained = fitted.slope * slope_details + fitted.behind * s.behind_detail;
  return fitted;
}

constexpr double part_of(std::int32_t far_share) {
  return static_cast<double>(far_share) / (1 << kShareBits);
}

std::int32_t best_far_share(const ClassMeanSums& sums) {
  const auto explained = [&](std::int32_t share) {
    double total = 0;
    for (std::size_t activity = 1; activity < kClasses; ++activity) {
      total += fit_means(sums[activity], part_of(share)).explained;
    }
    return total;
  };
  std::int32_t best = 0;
  double most = explained(0);
  for (std::int32_t share = -kMaxShare; share <= kMaxShare; ++share) {
    const double part = explained(share);
    if (part <= most) continue;
    most = part;
    best = share;
  }
  return best;
}

/// What weights leave of a detail.
double residual_of(const MeanSample& sample, double far_share, const MeanWeights& weights) {
  return sample.detail - weights.slope * (sample.near + far_share * sample.far) -
         weights.behind * sample.behind;
}

/// 1 / steps, or 1 / ((1 + |residual|) * sqrt(steps)) where a fit was made: large steps would
/// decide alone.
double weight_of(const MeanSample& sample, std::optional<double> residual) {
  const double steps =
      1.0 + std::abs(sample.near) + std::abs(sample.far) + std::abs(sample.behind);
  if (!residual) return 1 / steps;
  return 1 / ((1 + std::fabs(*residual)) * std::sqrt(steps));
}

/// About the bits, times 256, that residuals of samples take.
std::uint64_t code_length(const AxisMeanSamples& samples, std::size_t activity, double far_share,
                          const MeanWeights& weights) {
  constexpr double kPart = 16;  // of a step between details
  std::uint64_t length = 0;
  samples.for_each(activity, [&](const MeanSample& sample) {
    const double residual = std::fabs(residual_of(sample, far_share, weights));
    length += logarithm(static_cast<std::uint64_t>(kPart + kPart * residual));
  });
  return length;
}

/// Far share and weights of a split axis.
struct MeanFit {
  std::int32_t far_share = 0;
  std::array<MeanWeights, kClasses> of_class;
};

/// Fits by squares first, then nearer to the bits that residuals take. Squares follow the steps at
/// edges, where details are all or nothing: a class that does better without a prediction has none.
MeanFit fit_means(const AxisMeanSamples& samples) {
  constexpr int kMeanRounds = 3;
  MeanFit fit;
  for (int round = 0; round < kMeanRounds; ++round) {
    ClassMeanSums sums;
    const double share = part_of(fit.far_share);
    for (std::size_t activity = 1; activity < kClasses; ++activity) {
      // Of their own: compilers keep them in registers.
      MeanSums own;
      const MeanWeights fitted = fit.of_class[activity];
      samples.for_each(activity, [&](const MeanSample& sample) {
        std::optional<double> residual;
        if (round > 0) residual = residual_of(sample, share, fitted);
        own.add(sample, weight_of(sample, residual));
      });
      sums[activity] = own;
    }
    fit.far_share = best_far_share(sums);
    for (std::size_t activity = 1; activity < kClasses; ++activity) {
      fit.of_class[activity] = fit_means(sums[activity], part_of(fit.far_share));
    }
  }
  const double share = part_of(fit.far_share);
  for (std::size_t activity = 1; activity < kClasses; ++activity) {
    MeanWeights& fitted = fit.of_class[activity];
    if (code_length(samples, activity, share, {}) <=
        code_length(samples, activity, share, fitted)) {
      fitted = {};
    }
  }
  return fit;
}

/// A weight in units of 1 / 2^bits, at most `most`.
std::int32_t fixed_point(double weight, int bits, std::int32_t most) {
  return static_cast<std::int32_t>(
      std::lround(std::clamp<double>(weight * (1 << bits), -most, most)));
}

}  // namespace

void learn_mean_weights(Parameters& p, const std::vector<TrainingSample>& training, int group) {
  const bool is_exact = p.quantizer.detail_step == 0;
  std::vector<std::array<ClassMeanSamples, 3>> by_sample(training.size());
  parallel_for(std::size_t{0}, training.size(), [&](std::size_t i) {
    for (int level = group; level < group + levels_of_group(group); ++level) {
      if (level + 1 >= training[i].shape.level_count) break;
      walk_level(p, training[i], level,
                 [&](const Stage& stage, Workspace<std::int16_t>& work,
                     const Target<std::int16_t>& target, const PartNumber& part) {
                   if (is_exact) measure_split(p, stage, work, target);
                   else predict_split(p, stage, work, target);
                   const std::int64_t pairs = stage.pairs.voxel_count() * part.count *
                                              static_cast<std::int64_t>(training.size());
                   take_means(stage, work, target,
                              std::max<std::int64_t>(pairs / kMeanSamples, 1),
                              by_sample[i][static_cast<std::size_t>(stage.axis)]);
                 });
    }
  });
  parallel_for(std::size_t{0}, std::size_t{3}, [&](std::size_t axis) {
    const AxisMeanSamples samples{by_sample, axis};
    const MeanFit fit = fit_means(samples);
    p.far_shares[group][axis] = fit.far_share;
    for (std::size_t activity = 1; activity < kClasses; ++activity) {
      const MeanWeights& fitted = fit.of_class[activity];
      if (!samples.has(activity)) continue;
      p.mean_weights[group][axis][activity] =
          fixed_point(fitted.slope, kWeightBits, kMaxMeanWeight);
      p.behind_weights[group][axis][activity] = fixed_point(fitted.behind, kShareBits, kMaxShare);
    }
  });
}

}  // namespace octavo::grey
