// Sums for every instruction set that Highway knows, chosen at run time; solving in plain C++.

#include "octavo/codec/grey/least_squares.h"

#include <algorithm>
#include <cstddef>

#include "octavo/codec/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/codec/grey/least_squares.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// One lane per column of the matrix, so that sums come out alike for any number of lanes.
constexpr hn::CappedTag<float, 8> kColumns{};
constexpr std::size_t kRows = 4;  ///< rows of the matrix summed at a time

/// matrix[k0 ..][j ..] += scaled[.][k0 ..] * plain[.][j ..] over `count` samples of `n` features.
template <std::size_t kVectors>
HWY_INLINE void add_tile(const float* scaled, const float* plain, std::size_t count,
                         std::size_t n, std::size_t k0, std::size_t j, double* matrix) {
  using Columns = hn::Vec<decltype(kColumns)>;
  constexpr std::size_t kLanes = MaxLanes(kColumns);
  Columns sums[kRows][kVectors];
  for (auto& row : sums) {
    for (auto& sum : row) sum = hn::Zero(kColumns);
  }
  for (std::size_t i = 0; i < count; ++i, scaled += n, plain += n) {
    Columns features[kVectors];
    for (std::size_t v = 0; v < kVectors; ++v) {
      features[v] = hn::LoadU(kColumns, plain + j + v * kLanes);
    }
    for (std::size_t row = 0; row < kRows; ++row) {
      const auto factor = hn::Set(kColumns, scaled[k0 + row]);
      for (std::size_t v = 0; v < kVectors; ++v) {
        sums[row][v] = hn::Add(sums[row][v], hn::Mul(factor, features[v]));
      }
    }
  }
  alignas(64) float lanes[kLanes];
  for (std::size_t row = 0; row < kRows; ++row) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      hn::Store(sums[row][v], kColumns, lanes);
      double* const out = matrix + (k0 + row) * n + j + v * kLanes;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        out[lane] += static_cast<double>(lanes[lane]);
      }
    }
  }
}

/// The upper triangle, from the diagonal's block of 16 columns on.
void add_products(const float* scaled, const float* plain, std::size_t count, std::size_t n,
                  double* matrix) {
  constexpr std::size_t kStep = 16;
  for (std::size_t k = 0; k < n; k += kRows) {
    for (std::size_t j = k / kStep * kStep; j < n; j += kStep) {
      add_tile<kStep / MaxLanes(kColumns)>(scaled, plain, count, n, k, j, matrix);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo {

HWY_EXPORT(add_products);

namespace {

constexpr std::size_t kBlock = 256;  ///< samples whose sums are kept in single precision

}  // namespace

NormalEquations::NormalEquations(int unknowns)
    : n(unknowns),
      matrix(static_cast<std::size_t>(unknowns) * static_cast<std::size_t>(unknowns)),
      right(static_cast<std::size_t>(unknowns)) {}

void accumulate(NormalEquations& equations, std::span<const std::int16_t> features,
                std::span<const std::int32_t> targets, std::span<const float> sample_weights) {
  const auto n = static_cast<std::size_t>(equations.n);
  std::vector<float> plain(kBlock * n);
  std::vector<float> scaled(kBlock * n);
  for (std::size_t from = 0; from < targets.size(); from += kBlock) {
    const std::size_t count = std::min(kBlock, targets.size() - from);
    for (std::size_t i = 0; i < count; ++i) {
      const float weight = sample_weights.empty() ? 1.0f : sample_weights[from + i];
      const auto target = static_cast<double>(targets[from + i]);
      for (std::size_t k = 0; k < n; ++k) {
        const auto feature = static_cast<float>(features[(from + i) * n + k]);
        plain[i * n + k] = feature;
        scaled[i * n + k] = feature * weight;
        equations.right[k] += static_cast<double>(scaled[i * n + k]) * target;
      }
    }
    HWY_DYNAMIC_DISPATCH(add_products)(scaled.data(), plain.data(), count, n,
                                       equations.matrix.data());
  }
}

std::vector<double> solve(const NormalEquations& equations, double ridge) {
  const int n = equations.n;
  std::vector<double> matrix(equations.matrix.size());
  for (int row = 0; row < n; ++row) {
    for (int column = row; column < n; ++column) {
      const auto upper = static_cast<std::size_t>(row * n + column);
      matrix[upper] = matrix[static_cast<std::size_t>(column * n + row)] = equations.matrix[upper];
    }
  }
  std::vector<double> unknowns = equations.right;
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
#endif
