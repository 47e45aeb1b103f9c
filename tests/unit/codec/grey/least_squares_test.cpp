#include "octavo/codec/grey/least_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>

#include "octavo/codec/simd_level.h"

namespace octavo {
namespace {

constexpr std::size_t kUnknowns = 80;

struct Problem {
  std::vector<std::int16_t> features;
  std::vector<std::int32_t> targets;
  std::vector<float> roots;

  std::span<const std::int16_t> of(std::size_t sample) const {
    return std::span(features).subspan(sample * kUnknowns, kUnknowns);
  }
};

/// Targets are a sum of features 0, 17 and 79 with the weights 0.5, -1.25 and 2. Multiples of 4
/// make it an integer: rounding toward 0 would ask for smaller weights.
Problem make_problem(std::size_t count, int range) {
  std::mt19937 random(11);
  Problem problem;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < kUnknowns; ++k) {
      const auto value = static_cast<int>(random() % static_cast<unsigned>(2 * range + 1)) - range;
      problem.features.push_back(static_cast<std::int16_t>(value / 4 * 4));
    }
    const auto f = problem.of(i);
    problem.targets.push_back((2 * f[0] - 5 * f[17] + 8 * f[79]) / 4);
    problem.roots.push_back(1.0f / static_cast<float>(1 + random() % 7));
  }
  return problem;
}

TEST(LeastSquares, MeasuresAreThoseOfTheDefinition) {
  const Problem problem = make_problem(9, 32000);
  std::vector<std::int16_t> weights(kUnknowns);
  for (std::size_t k = 0; k < kUnknowns; ++k) weights[k] = static_cast<std::int16_t>(k * 37 % 700);
  for (std::size_t i = 0; i < problem.targets.size(); ++i) {
    std::int32_t sum = 0;
    std::int32_t maximum = 0;
    std::int64_t predicted = 0;
    for (std::size_t k = 0; k < kUnknowns; ++k) {
      const std::int32_t f = problem.of(i)[k];
      sum += std::abs(f);
      maximum = std::max(maximum, std::abs(f));
      predicted += std::int64_t{f} * weights[k];
    }
    const SampleMeasures measured = measure(problem.of(i), weights);
    EXPECT_EQ(measured.sum, sum);
    EXPECT_EQ(measured.maximum, maximum);
    EXPECT_EQ(measured.predicted, predicted);
    EXPECT_EQ(measure(problem.of(i), {}).predicted, 0);
  }
}

/// An odd count, and one that leaves a last block of a single sample.
TEST(LeastSquares, SumsAreThoseOfTheScaledSamples) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{65}, std::size_t{500}}) {
    const Problem problem = make_problem(count, 900);
    NormalEquations equations(kUnknowns);
    double total = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const SampleMeasures measured = measure(problem.of(i), {});
      equations.add(problem.of(i), problem.targets[i], measured, problem.roots[i]);
      const auto largest = std::max(measured.maximum, std::abs(problem.targets[i]));
      total += problem.roots[i] * static_cast<float>(largest);
    }
    equations.finish();
    const double unit = static_cast<double>(count) * 4094 / (8 * total);
    // Rounding moves a scaled number by up to a half.
    for (const std::size_t k : {std::size_t{0}, std::size_t{5}, std::size_t{79}}) {
      for (std::size_t j = k; j < kUnknowns; j += 13) {
        double expected = 0;
        double bound = 1;
        double right = 0;
        double right_bound = 1;
        for (std::size_t i = 0; i < count; ++i) {
          const double scale = problem.roots[i] * unit;
          const double a = problem.of(i)[k] * scale;
          const double b = problem.of(i)[j] * scale;
          const double t = problem.targets[i] * scale;
          if (std::abs(a) > 4094 || std::abs(b) > 4094 || std::abs(t) > 4094) continue;
          expected += a * b;
          bound += (std::abs(a) + std::abs(b)) / 2 + 1;
          right += a * t;
          right_bound += (std::abs(a) + std::abs(t)) / 2 + 1;
        }
        EXPECT_NEAR(equations.matrix()[k * kUnknowns + j], expected, bound) << count;
        EXPECT_NEAR(equations.right()[k], right, right_bound) << count;
      }
    }
  }
}

TEST(LeastSquares, FindsTheWeightsThatMadeTheTargets) {
  for (const int range : {40, 700, 32000}) {
    const Problem problem = make_problem(3001, range);
    NormalEquations equations(kUnknowns);
    for (std::size_t i = 0; i < problem.targets.size(); ++i) {
      equations.add(problem.of(i), problem.targets[i], measure(problem.of(i), {}),
                    problem.roots[i]);
    }
    equations.finish();
    const std::vector<double> found = solve(equations.matrix(), equations.right(), 0);
    for (std::size_t k = 0; k < kUnknowns; ++k) {
      const double expected = k == 0 ? 0.5 : k == 17 ? -1.25 : k == 79 ? 2.0 : 0.0;
      EXPECT_NEAR(found[k], expected, 0.01) << "range " << range << " unknown " << k;
    }
  }
}

TEST(LeastSquares, EveryInstructionSetGivesTheSame) {
  const Problem problem = make_problem(333, 5000);
  const std::vector<std::int16_t> weights(kUnknowns, 77);
  const auto sums = [&] {
    NormalEquations equations(kUnknowns);
    std::vector<std::int32_t> predicted;
    for (std::size_t i = 0; i < problem.targets.size(); ++i) {
      const SampleMeasures measured = measure(problem.of(i), weights);
      predicted.push_back(measured.predicted);
      equations.add(problem.of(i), problem.targets[i], measured, problem.roots[i]);
    }
    equations.finish();
    return std::tuple(predicted, solve(equations.matrix(), equations.right(), 1e-4));
  };
  const auto best = sums();
  for (const char* const level : {"sse4", "avx2", "avx512", "neon"}) {
    const std::int64_t targets = simd_targets_of(level);
    if (targets == 0) continue;
    const SimdTargetsInUse in_use(targets);
    EXPECT_EQ(sums(), best) << level;
  }
}

TEST(LeastSquares, SingularSystemsGiveFiniteValues) {
  for (const double weight : solve(std::vector<double>(256), std::vector<double>(16), 1e-4)) {
    EXPECT_TRUE(std::isfinite(weight));
  }
}

}  // namespace
}  // namespace octavo
