// Weighted linear least squares by normal equations, for a few dozen unknowns and many samples.
//
//      sample            f[0] .. f[n-1], t           16 bits
//      scaled by r       round(r f[k]), round(r t)   12 bits and a sign
//      64 samples        sums of products            32 bits
//      all               matrix, right side          double
//
// r is the root of the sample's weight in a unit that suits most samples, or less where one would
// not fit.
//
// Invariant
//   All sums are of integers and exact.
// Consequence
//   A model trained anywhere is the same to the last bit: sums come out alike for any number of
//   lanes and any order of the samples, and solving is plain IEEE arithmetic.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace octavo {

/// What the weight of a sample may depend on.
struct SampleMeasures {
  std::int32_t sum = 0;        ///< of the magnitudes of its features
  std::int32_t maximum = 0;    ///< of them
  std::int32_t predicted = 0;  ///< the sum of features times weights
};

/// Asks memory for the features of a sample that is used so many samples later: they lie about, and
/// are far more than a cache holds.
inline constexpr std::size_t kFetchedAhead = 8;
void fetch_features(std::span<const std::int16_t> features);

/// features  of which none is -32768; a multiple of 16, at most 128
/// weights   as many; or none, then nothing is predicted
SampleMeasures measure(std::span<const std::int16_t> features,
                       std::span<const std::int16_t> weights);

/// The normal equations of target ~ sum_k w[k] * features[k].
class NormalEquations {
 public:
  /// count  of the unknowns, a multiple of 16, at most 128
  explicit NormalEquations(std::size_t count);

  /// Adds a sample. The features must stay where they are until finish().
  /// measured  those of the features
  /// root      of its weight, above 0
  void add(std::span<const std::int16_t> features, std::int32_t target,
           const SampleMeasures& measured, float root);

  /// Makes the sums.
  void finish();

  /// Row-major, of which the upper triangle counts.
  const std::vector<double>& matrix() const { return matrix_; }
  const std::vector<double>& right() const { return right_; }

 private:
  struct Sample {
    const std::int16_t* features;
    std::int32_t target;
    std::int32_t maximum;  ///< magnitude of features and target, at least 1
    float root;
  };

  std::size_t n_;
  std::vector<Sample> samples_;
  std::vector<double> matrix_;
  std::vector<double> right_;
};

/// Solves a symmetric system given by its upper triangle, which is used up. `ridge` is added to the
/// diagonal relative to itself; singular systems give finite values.
std::vector<double> solve(std::vector<double> matrix, std::vector<double> right, double ridge);

}  // namespace octavo
