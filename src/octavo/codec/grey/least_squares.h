// Weighted linear least squares by normal equations, for a few dozen unknowns and many samples.
//
// Sums run in the order of the samples with plain IEEE operations (no fused multiply-add, no
// reordering), so that a model trained anywhere is the same to the last bit.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace octavo {

/// The normal equations of targets[i] ~ sum_k w[k] * features[i * n + k].
struct NormalEquations {
  /// unknowns  a multiple of 16
  explicit NormalEquations(int unknowns);
  int n;
  std::vector<double> matrix;  ///< n x n, row-major, upper triangle
  std::vector<double> right;   ///< n
};

/// Adds samples with the given weights (empty: all 1). features: count x n int16.
void accumulate(NormalEquations& equations, std::span<const std::int16_t> features,
                std::span<const std::int32_t> targets, std::span<const float> sample_weights);

/// The unknowns. `ridge` is added to the diagonal relative to itself; singular systems give finite
/// values.
std::vector<double> solve(const NormalEquations& equations, double ridge);

/// Solves a dense symmetric system in place by elimination; `right` becomes the unknowns.
void eliminate(int n, std::vector<double>& matrix, std::vector<double>& right, double ridge);

}  // namespace octavo
