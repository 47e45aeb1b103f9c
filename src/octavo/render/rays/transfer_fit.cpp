#include "octavo/render/rays/transfer_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "octavo/render/window.h"

namespace octavo {

namespace {

constexpr std::size_t kFitBins = 256;

/// The bin at which values above differ most from those below: variance between the two classes.
std::size_t otsu_bin(const std::array<double, kFitBins>& counts) {
  double all = 0;
  double sum = 0;
  for (std::size_t i = 0; i < kFitBins; ++i) {
    all += counts[i];
    sum += counts[i] * static_cast<double>(i);
  }
  double below = 0;
  double sum_below = 0;
  double best = -1;
  std::size_t bin = kFitBins / 2;
  for (std::size_t i = 0; i + 1 < kFitBins; ++i) {
    below += counts[i];
    sum_below += counts[i] * static_cast<double>(i);
    if (!(below > 0 && below < all)) continue;
    const double apart = sum_below / below - (sum - sum_below) / (all - below);
    const double between = below * (all - below) * apart * apart;
    if (between > best) {
      best = between;
      bin = i;
    }
  }
  return bin;
}

/// How often values are in bins of a window. Where they fall off from dark to bright without a
/// heap of their own, as fluorescence does, bins are shares of a logarithm: 1 + kTail times the
/// share of the window.
class FitBins {
 public:
  FitBins(const std::vector<double>& values, double low, double high, double tail)
      : low_(low), high_(high), tail_(tail) {
    for (const double value : values) {
      const double share = std::clamp((value - low) / (high - low), 0.0, 1.0);
      const double place = tail > 0 ? std::log1p(tail * share) / std::log1p(tail) : share;
      const auto bin = static_cast<std::size_t>(place * static_cast<double>(kFitBins));
      ++counts_[std::min(bin, kFitBins - 1)];
    }
    bin_ = otsu_bin(counts_);
  }

  double threshold() const {
    const double place = static_cast<double>(bin_ + 1) / kFitBins;
    const double share = tail_ > 0 ? std::expm1(place * std::log1p(tail_)) / tail_ : place;
    return low_ + (high_ - low_) * share;
  }

  /// Whether fewer values lie at the threshold than farther up.
  bool has_valley() const {
    const std::size_t first = std::clamp(bin_, kNearBins, kLastMiddle);
    double most = 0;
    for (std::size_t i = first; i < kLastMiddle; ++i) most = std::max(most, around(i));
    return most > kHeap * around(first);
  }

  /// Moves the threshold to the bottom of the valley that it lies in.
  void descend() {
    bin_ = std::clamp(bin_, kNearBins + 1, kLastMiddle - 1);
    while (bin_ > kNearBins + 1 && around(bin_ - 1) < around(bin_)) --bin_;
    while (bin_ + 1 < kLastMiddle && around(bin_ + 1) < around(bin_)) ++bin_;
  }

 private:
  static constexpr std::size_t kNearBins = 4;
  static constexpr std::size_t kLastMiddle = kFitBins - kNearBins - 1;
  static constexpr double kHeap = 1.1;

  double around(std::size_t bin) const {
    double sum = 0;
    for (std::size_t i = bin - kNearBins; i <= bin + kNearBins; ++i) sum += counts_[i];
    return sum;
  }

  double low_;
  double high_;
  double tail_;
  std::array<double, kFitBins> counts_{};
  std::size_t bin_ = 0;
};

constexpr double kTail = 100;

}  // namespace

TransferFunction fitted_transfer(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return usual_transfer_function();
  const Window window = robust_window(values);
  const double low = window.center - window.width / 2;
  const double high = window.center + window.width / 2;
  const auto [minimum, maximum] = std::minmax_element(values.begin(), values.end());
  if (!(*minimum < *maximum) || !(low < high)) return usual_transfer_function();

  // The threshold, within the window: a few bright voxels do not move it.
  FitBins plain(values, low, high, 0);
  plain.descend();
  const double threshold =
      plain.has_valley() ? plain.threshold() : FitBins(values, low, high, kTail).threshold();

  // What lies above it.
  std::erase_if(values, [&](double value) { return value < threshold; });
  const auto quantile = [&](double share) {
    const auto place = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  if (values.empty()) return usual_transfer_function();
  const double first = quantile(0.25);
  const double third = quantile(0.75);
  const double last = std::max(quantile(0.99), third);
  return {{{threshold, {110, 84, 66}, 0},
           {std::max(first, threshold), {196, 156, 120}, 0.08},
           {third, {236, 214, 184}, 0.3},
           {last, {255, 250, 240}, 0.7}},
          std::nullopt,
          false,
          std::nullopt};
}

}  // namespace octavo
