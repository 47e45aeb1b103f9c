#include "octavo/mesh/deviation_search.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

constexpr int kRefinements = 5;         // between two steps
constexpr int kByPowerLaw = 2;          // of them; later ones stay nearer to the middle
constexpr double kNearEnough = 0.98;    // of the limit
constexpr double kNarrow = 1.01;        // of two sums that are not told apart

}  // namespace

DeviationSearch::DeviationSearch(std::uint64_t limit, double first, double farthest)
    : limit_(limit), first_(first), farthest_(farthest), tried_(first) {}

std::optional<double> DeviationSearch::next() const {
  if (tried_ <= 0) return std::nullopt;
  return tried_ - base_.sum;
}

std::optional<double> DeviationSearch::best_deviation() const {
  if (!best_) return std::nullopt;
  return best_->sum;
}

TrialFate DeviationSearch::found(std::uint64_t triangle_count) {
  const Trial trial{tried_, triangle_count};
  fewest_ = std::min(fewest_, triangle_count);
  const bool had_best = best_.has_value();

  // What it is good for
  TrialFate fate = TrialFate::dropped;
  if (triangle_count <= limit_) {
    fate = TrialFate::best;
    best_ = trial;
  } else if (!had_best) {
    fate = TrialFate::base;
    const bool is_stalled = static_cast<double>(triangle_count) >
                            kStalledShare * static_cast<double>(base_.triangle_count);
    stalls_ = is_stalled ? stalls_ + 1 : 0;
    base_ = trial;
  } else {
    too_many_ = trial;
  }

  // Loosen further, or look between
  if (!best_) {
    tried_ = trial.sum < farthest_ && stalls_ < kMostStalledSteps ? kLoosening * trial.sum : 0;
    return fate;
  }
  const double low = too_many_ ? too_many_->sum : base_.sum;
  const bool is_first = base_.sum == 0 && !had_best;
  const bool is_near =
      static_cast<double>(best_->triangle_count) >= kNearEnough * static_cast<double>(limit_);
  const bool is_narrow = best_->sum < kNarrow * low;
  const bool is_done = is_first || is_near || is_narrow || ++refinements_ > kRefinements;
  tried_ = is_done ? 0 : between();
  return fate;
}

/// Where a power law of sums and triangles has the limit.
double DeviationSearch::between() const {
  const Trial low = too_many_ ? *too_many_ : base_;
  const auto log_of = [](std::uint64_t count) {
    return std::log(static_cast<double>(std::max<std::uint64_t>(count, 1)));
  };
  // A little below the limit, so that what is tried is likelier to be taken.
  const double aim = log_of(limit_) + std::log((1 + kNearEnough) / 2);
  const double fall = log_of(low.triangle_count) - log_of(best_->triangle_count);
  const double share = fall > 0 ? (log_of(low.triangle_count) - aim) / fall : 0.5;
  const double from = std::log(low.sum);
  const double to = std::log(best_->sum);
  const double rim = refinements_ > kByPowerLaw ? 0.35 : 0.1;
  return std::exp(from + std::clamp(share, rim, 1 - rim) * (to - from));
}

}  // namespace octavo
