#include "octavo/codec/least_squares.h"

#include <cstddef>

namespace octavo {

namespace {

constexpr int kMaxUnknowns = 96;
constexpr int kLane = 8;

/// matrix += weight * features * features^T (from the diagonal's block of 8 columns on).
__attribute__((always_inline)) inline void add_sample(NormalEquations& equations,
                                                      const float* features, float target,
                                                      float weight) {
  const int n = equations.n;
  for (int k = 0; k < n; ++k) {
    const float scaled = features[k] * weight;
    if (scaled == 0) continue;
    equations.right[static_cast<std::size_t>(k)] += scaled * target;
    float* const row = equations.matrix.data() + static_cast<std::ptrdiff_t>(k) * n;
    for (int j = k / kLane * kLane; j < n; ++j) row[j] += scaled * features[j];
  }
}

__attribute__((always_inline)) inline void accumulate_all(NormalEquations& equations,
                                                          std::span<const std::int16_t> features,
                                                          std::span<const std::int32_t> targets,
                                                          std::span<const float> sample_weights) {
  alignas(32) float values[kMaxUnknowns];
  const auto n = static_cast<std::size_t>(equations.n);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    for (std::size_t k = 0; k < n; ++k) values[k] = features[i * n + k];
    const float weight = sample_weights.empty() ? 1.0f : sample_weights[i];
    add_sample(equations, values, static_cast<float>(targets[i]), weight);
  }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void accumulate_avx2(NormalEquations& equations,
                                                     std::span<const std::int16_t> features,
                                                     std::span<const std::int32_t> targets,
                                                     std::span<const float> sample_weights) {
  accumulate_all(equations, features, targets, sample_weights);
}
#endif

}  // namespace

NormalEquations::NormalEquations(int unknowns)
    : n(unknowns),
      matrix(static_cast<std::size_t>(unknowns) * static_cast<std::size_t>(unknowns)),
      right(static_cast<std::size_t>(unknowns)) {}

void accumulate(NormalEquations& equations, std::span<const std::int16_t> features,
                std::span<const std::int32_t> targets, std::span<const float> sample_weights) {
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2");
  if (has_avx2) return accumulate_avx2(equations, features, targets, sample_weights);
#endif
  accumulate_all(equations, features, targets, sample_weights);
}

std::vector<double> solve(const NormalEquations& equations, double ridge) {
  const int n = equations.n;
  std::vector<double> matrix(equations.matrix.size());
  for (int row = 0; row < n; ++row) {
    for (int column = row; column < n; ++column) {
      const auto upper = static_cast<std::size_t>(row * n + column);
      const double value = static_cast<double>(equations.matrix[upper]);
      matrix[upper] = matrix[static_cast<std::size_t>(column * n + row)] = value;
    }
  }
  std::vector<double> unknowns(equations.right.begin(), equations.right.end());
  eliminate(n, matrix, unknowns, ridge);
  return unknowns;
}

void eliminate(int n, std::vector<double>& matrix, std::vector<double>& right, double ridge) {
  const auto at = [&](int row, int column) -> double& {
    return matrix[static_cast<std::size_t>(row * n + column)];
  };
  const auto r = [&](int row) -> double& { return right[static_cast<std::size_t>(row)]; };
  double trace = 0;
  for (int i = 0; i < n; ++i) trace += at(i, i);
  for (int i = 0; i < n; ++i) at(i, i) = at(i, i) * (1 + ridge) + 1e-6 * trace / n + 1e-9;
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      const double factor = at(j, i) / at(i, i);
      if (factor == 0) continue;
      for (int k = i; k < n; ++k) at(j, k) -= factor * at(i, k);
      r(j) -= factor * r(i);
    }
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) r(i) -= at(i, k) * r(k);
    r(i) /= at(i, i);
  }
}

}  // namespace octavo
