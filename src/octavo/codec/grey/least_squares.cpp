// Sums for every instruction set that Highway knows, chosen at run time; solving in plain C++.

#include "octavo/codec/grey/least_squares.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "octavo/codec/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/codec/grey/least_squares.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

/// Unknowns come in steps of 16: whole vectors of any of these.
[[maybe_unused]] constexpr std::size_t kStep = 16;

#if HWY_TARGET == HWY_SCALAR

/// Products of both halves of two pairs, modulo 2^32.
std::uint32_t pair_product(std::int32_t a, std::int32_t b) {
  const auto low = [](std::int32_t pair) { return std::int32_t{static_cast<std::int16_t>(pair)}; };
  return static_cast<std::uint32_t>(low(a) * low(b)) +
         static_cast<std::uint32_t>((a >> 16) * (b >> 16));
}

SampleMeasures measure_features(const std::int16_t* features, const std::int16_t* weights,
                                std::size_t n) {
  SampleMeasures result;
  std::uint32_t predicted = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const std::int32_t magnitude = std::abs(std::int32_t{features[k]});
    result.sum += magnitude;
    result.maximum = std::max(result.maximum, magnitude);
    if (weights != nullptr) predicted += static_cast<std::uint32_t>(features[k] * weights[k]);
  }
  result.predicted = static_cast<std::int32_t>(predicted);
  return result;
}

void scale_features(const std::int16_t* features, float scale, bool is_second, std::size_t n,
                    std::int32_t* pairs) {
  for (std::size_t k = 0; k < n; ++k) {
    const auto scaled = static_cast<std::uint32_t>(
        std::lrint(static_cast<float>(features[k]) * scale));
    pairs[k] = static_cast<std::int32_t>(
        is_second ? static_cast<std::uint32_t>(pairs[k]) | scaled << 16 : scaled & 0xffff);
  }
}

void add_products(const std::int32_t* pairs, const std::int32_t* targets, std::size_t count,
                  std::size_t n, double* matrix, double* right) {
  const auto sum = [&](const std::int32_t* factors, std::size_t factor_step, std::size_t j) {
    std::uint32_t total = 0;
    for (std::size_t i = 0; i < count; ++i) {
      total += pair_product(factors[i * factor_step], pairs[i * n + j]);
    }
    return static_cast<double>(static_cast<std::int32_t>(total));
  };
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t j = k; j < n; ++j) matrix[k * n + j] += sum(pairs + k, n, j);
    right[k] += sum(targets, 1, k);
  }
}

#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<std::int32_t, kStep> kSums{};
constexpr hn::Repartition<std::int16_t, decltype(kSums)> kPairs{};
constexpr hn::Rebind<float, decltype(kSums)> kScaled{};
constexpr hn::Rebind<std::int16_t, decltype(kSums)> kNarrow{};
constexpr hn::CappedTag<std::int16_t, kStep> kFeatures{};
constexpr hn::Repartition<std::int32_t, decltype(kFeatures)> kFeatureSums{};
using Sums = hn::Vec<decltype(kSums)>;

SampleMeasures measure_features(const std::int16_t* features, const std::int16_t* weights,
                                std::size_t n) {
  const auto zero = hn::Zero(kFeatures);
  const auto ones = hn::Set(kFeatures, std::int16_t{1});
  auto maximum = zero;
  auto sum = hn::Zero(kFeatureSums);
  auto sum_more = sum;
  auto predicted = sum;
  auto predicted_more = sum;
  for (std::size_t k = 0; k < n; k += hn::MaxLanes(kFeatures)) {
    const auto f = hn::LoadU(kFeatures, features + k);
    const auto magnitude = hn::Max(f, hn::Sub(zero, f));
    maximum = hn::Max(maximum, magnitude);
    sum = hn::ReorderWidenMulAccumulate(kFeatureSums, magnitude, ones, sum, sum_more);
    if (weights == nullptr) continue;
    predicted = hn::ReorderWidenMulAccumulate(kFeatureSums, f, hn::LoadU(kFeatures, weights + k),
                                              predicted, predicted_more);
  }
  SampleMeasures result;
  result.sum = hn::GetLane(hn::SumOfLanes(kFeatureSums, hn::Add(sum, sum_more)));
  result.maximum = hn::GetLane(hn::MaxOfLanes(kFeatures, maximum));
  result.predicted =
      hn::GetLane(hn::SumOfLanes(kFeatureSums, hn::Add(predicted, predicted_more)));
  return result;
}

/// Puts a scaled sample into the lower halves of `pairs`, or into the upper ones above another.
void scale_features(const std::int16_t* features, float scale, bool is_second, std::size_t n,
                    std::int32_t* pairs) {
  const auto factor = hn::Set(kScaled, scale);
  for (std::size_t k = 0; k < n; k += hn::MaxLanes(kSums)) {
    const auto f = hn::PromoteTo(kSums, hn::LoadU(kNarrow, features + k));
    const auto scaled = hn::NearestInt(hn::Mul(hn::ConvertTo(kScaled, f), factor));
    const auto lower = hn::And(scaled, hn::Set(kSums, 0xffff));
    hn::StoreU(is_second ? hn::Or(hn::LoadU(kSums, pairs + k), hn::ShiftLeft<16>(scaled)) : lower,
               kSums, pairs + k);
  }
}

/// out[.] += the lanes of a vector.
HWY_INLINE void add_to(Sums numbers, double* out) {
#if HWY_HAVE_FLOAT64
  const hn::Half<decltype(kSums)> half;
  const hn::Rebind<double, decltype(half)> real;
  const auto add = [&](auto some, double* to) HWY_ATTR {
    hn::StoreU(hn::Add(hn::LoadU(real, to), hn::PromoteTo(real, some)), real, to);
  };
  add(hn::LowerHalf(half, numbers), out);
  add(hn::UpperHalf(half, numbers), out + hn::MaxLanes(half));
#else
  alignas(64) std::int32_t lanes[hn::MaxLanes(kSums)];
  hn::Store(numbers, kSums, lanes);
  for (std::size_t lane = 0; lane < hn::MaxLanes(kSums); ++lane) out[lane] += lanes[lane];
#endif
}

/// sums[.][0 .. 15] += products of the pairs factors[.] and columns[0 .. 15] over `count` pairs of
/// samples, `n` apart; as many of the factors as vectors of 16 columns leave registers for.
template <std::size_t kRows>
HWY_INLINE void add_tile(const std::int32_t* factors, std::size_t factor_step,
                         const std::int32_t* columns, std::size_t n, std::size_t count,
                         double* sums, std::size_t sums_step) {
  constexpr std::size_t kLanes = hn::MaxLanes(kSums);
  constexpr std::size_t kVectors = kStep / kLanes;
  Sums products[kRows][kVectors];
  Sums more[kRows][kVectors];
  for (std::size_t row = 0; row < kRows; ++row) {
    for (std::size_t v = 0; v < kVectors; ++v) products[row][v] = more[row][v] = hn::Zero(kSums);
  }
  for (std::size_t i = 0; i < count; ++i, factors += factor_step, columns += n) {
    Sums column[kVectors];
    for (std::size_t v = 0; v < kVectors; ++v) {
      column[v] = hn::LoadU(kSums, columns + v * kLanes);
    }
    for (std::size_t row = 0; row < kRows; ++row) {
      const auto factor = hn::BitCast(kPairs, hn::Set(kSums, factors[row]));
      for (std::size_t v = 0; v < kVectors; ++v) {
        products[row][v] = hn::ReorderWidenMulAccumulate(
            kSums, factor, hn::BitCast(kPairs, column[v]), products[row][v], more[row][v]);
      }
    }
  }
  for (std::size_t row = 0; row < kRows; ++row) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      add_to(hn::RearrangeToOddPlusEven(products[row][v], more[row][v]),
             sums + row * sums_step + v * kLanes);
    }
  }
}

/// Adds `count` pairs of samples: the matrix from the diagonal's block of 16 columns on.
void add_products(const std::int32_t* pairs, const std::int32_t* targets, std::size_t count,
                  std::size_t n, double* matrix, double* right) {
  constexpr std::size_t kRows = hn::MaxLanes(kSums) / 2;  // 8 vectors of sums
  for (std::size_t k = 0; k < n; k += kRows) {
    for (std::size_t j = k / kStep * kStep; j < n; j += kStep) {
      add_tile<kRows>(pairs + k, n, pairs + j, n, count, matrix + k * n + j, n);
    }
  }
  for (std::size_t j = 0; j < n; j += kStep) {
    add_tile<1>(targets, 1, pairs + j, n, count, right + j, n);
  }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo {

HWY_EXPORT(measure_features);
HWY_EXPORT(scale_features);
HWY_EXPORT(add_products);

namespace {

constexpr std::size_t kBlock = 64;  ///< samples whose sums fit in 32 bits
constexpr float kLargest = 4094;    ///< scaled magnitude; rounded, below 2^12
constexpr double kHeadroom = 8;     ///< from the mean magnitude to the largest

/// Two samples a row: the second in the upper halves. Starts with zeros.
struct PairBlock {
  explicit PairBlock(std::size_t n) : rows(kBlock / 2 * n), targets(kBlock / 2) {}
  std::vector<std::int32_t> rows;
  std::vector<std::int32_t> targets;
};

}  // namespace

void fetch_features(std::span<const std::int16_t> features) {
  constexpr std::size_t kLine = 64 / sizeof(std::int16_t);
  for (std::size_t k = 0; k < features.size(); k += kLine) {
    __builtin_prefetch(features.data() + k);
  }
  __builtin_prefetch(features.data() + features.size() - 1);
}

SampleMeasures measure(std::span<const std::int16_t> features,
                       std::span<const std::int16_t> weights) {
  return HWY_DYNAMIC_DISPATCH(measure_features)(
      features.data(), weights.empty() ? nullptr : weights.data(), features.size());
}

NormalEquations::NormalEquations(std::size_t count)
    : n_(count), matrix_(count * count), right_(count) {}

void NormalEquations::add(std::span<const std::int16_t> features, std::int32_t target,
                          const SampleMeasures& measured, float root) {
  samples_.push_back(
      {features.data(), target, std::max({measured.maximum, std::abs(target), 1}), root});
}

void NormalEquations::finish() {
  // The unit: most samples fit with room to spare
  double total = 0;
  for (const Sample& sample : samples_) {
    total += static_cast<double>(sample.root) * static_cast<double>(sample.maximum);
  }
  const auto unit = static_cast<float>(static_cast<double>(samples_.size()) *
                                       static_cast<double>(kLargest) / (kHeadroom * total));

  PairBlock block(n_);
  std::size_t waiting = 0;
  const auto sum_up = [&] {
    // The upper halves of a last single sample are 0.
    HWY_DYNAMIC_DISPATCH(add_products)(block.rows.data(), block.targets.data(), (waiting + 1) / 2,
                                       n_, matrix_.data(), right_.data());
    waiting = 0;
  };
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const Sample& sample = samples_[i];
    fetch_features({samples_[std::min(i + kFetchedAhead, samples_.size() - 1)].features, n_});
    const float scale =
        std::min(sample.root * unit, kLargest / static_cast<float>(sample.maximum));
    const bool is_second = waiting % 2 != 0;
    HWY_DYNAMIC_DISPATCH(scale_features)(sample.features, scale, is_second, n_,
                                         block.rows.data() + waiting / 2 * n_);
    const auto scaled =
        static_cast<std::uint32_t>(std::lrint(static_cast<float>(sample.target) * scale));
    std::int32_t& pair = block.targets[waiting / 2];
    pair = static_cast<std::int32_t>(is_second ? static_cast<std::uint32_t>(pair) | scaled << 16
                                               : scaled & 0xffff);
    if (++waiting == kBlock) sum_up();
  }
  sum_up();
  samples_.clear();
}

std::vector<double> solve(std::vector<double> matrix, std::vector<double> right, double ridge) {
  const std::size_t n = right.size();
  double trace = 0;
  for (std::size_t i = 0; i < n; ++i) trace += matrix[i * n + i];
  const double minimum = 1e-6 * trace / static_cast<double>(n) + 1e-9;
  for (std::size_t i = 0; i < n; ++i) matrix[i * n + i] = matrix[i * n + i] * (1 + ridge) + minimum;
  // What is left of a symmetric matrix stays symmetric: its upper triangle will do.
  for (std::size_t i = 0; i < n; ++i) {
    const double* const pivot = matrix.data() + i * n;
    for (std::size_t j = i + 1; j < n; ++j) {
      const double factor = pivot[j] / pivot[i];
      if (factor == 0) continue;
      double* const row = matrix.data() + j * n;
      for (std::size_t k = j; k < n; ++k) row[k] -= factor * pivot[k];
      right[j] -= factor * right[i];
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) right[i] -= matrix[i * n + k] * right[k];
    right[i] /= matrix[i * n + i];
  }
  return right;
}

}  // namespace octavo
#endif
