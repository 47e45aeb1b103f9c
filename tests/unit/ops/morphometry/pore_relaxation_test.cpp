#include "octavo/ops/morphometry/pore_relaxation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace octavo {
namespace {

/// Sums over pores of one vector times what makes up for another one.
double product(PoreRelaxation& relaxation, const std::vector<double>& a,
               const std::vector<double>& b) {
  const std::vector<float>& relaxed = relaxation.relaxed(b);
  double sum = 0;
  for (std::size_t i = 1; i < a.size(); ++i) sum += a[i] * static_cast<double>(relaxed[i]);
  return sum;
}

TEST(PoreRelaxation, IsSymmetricAndPositiveInPoresOfAnyForm) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const NoProgress progress;
  const Size3 size = {19, 14, 17};
  const Point3 spacings[] = {{1, 1, 1}, {0.3, 1, 2}};
  for (const unsigned percent : {38U, 60U, 100U}) {
    std::vector<std::uint8_t> pores(static_cast<std::size_t>(size.voxel_count()));
    for (std::uint8_t& pore : pores) pore = random() % 100 < percent ? 1 : 0;
    for (const Point3& spacing : spacings) {
      const PoreNetwork network(pores, size, spacing, 1, progress);
      ASSERT_GT(network.count(), 100U);
      PoreRelaxation relaxation(network);
      EXPECT_GT(relaxation.level_count(), 3U);
      EXPECT_LT(relaxation.cluster_count(), 2 * network.count());
      std::vector<double> a(network.count() + 1);
      std::vector<double> b(network.count() + 1);
      for (int times = 0; times < 5; ++times) {
        for (std::size_t i = 1; i < a.size(); ++i) {
          a[i] = normal(random);
          b[i] = normal(random);
        }
        const double size_a = product(relaxation, a, a);
        const double size_b = product(relaxation, b, b);
        EXPECT_GT(size_a, 0);
        EXPECT_GT(size_b, 0);
        const double ab = product(relaxation, a, b);
        EXPECT_NEAR(ab, product(relaxation, b, a), 1e-5 * std::sqrt(size_a * size_b));
      }
    }
  }
}

TEST(PoreRelaxation, MakesUpForSmoothImbalanceAtOnce) {
  // A source in every pore of a long channel: what relaxing pore by pore alone would need as many
  // steps for as it is long.
  const NoProgress progress;
  const Size3 size = {2, 2, 400};
  const PoreNetwork network(std::vector<std::uint8_t>(1600, 1), size, {1, 1, 1}, 2, progress);
  PoreRelaxation relaxation(network);
  std::vector<double> source(network.count() + 1, 1.0);
  source[0] = 0;
  const std::vector<float>& relaxed = relaxation.relaxed(source);
  // At rest a parabola whose vertex is length^2 / 8.
  const double middle = static_cast<double>(relaxed[800]);
  EXPECT_GT(middle, 0.4 * 400 * 400 / 8);
  EXPECT_LT(middle, 1.6 * 400 * 400 / 8);
}

TEST(PoreRelaxation, OfNoPoresHasNoLevels) {
  const NoProgress progress;
  const PoreNetwork network(std::vector<std::uint8_t>(27), {3, 3, 3}, {1, 1, 1}, 0, progress);
  EXPECT_EQ(PoreRelaxation(network).level_count(), 0U);
}

}  // namespace
}  // namespace octavo
