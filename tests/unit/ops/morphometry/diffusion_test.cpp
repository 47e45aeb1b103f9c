#include "octavo/ops/morphometry/diffusion.h"

#include <gtest/gtest.h>

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/ops/morphometry/pore_clusters.h"
#include "support/dense_mask.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using testing::for_each_voxel;

std::optional<PoreDiffusion> diffusion_of(const std::vector<std::uint8_t>& pores,
                                          const Size3& size, const Point3& spacing, int axis) {
  NoProgress progress;
  return pore_diffusion(pores, size, spacing, axis, static_cast<double>(size.voxel_count()),
                        progress);
}

template <class Pore>
std::optional<PoreDiffusion> diffusion_of(const Size3& size, const Point3& spacing, int axis,
                                          Pore pore) {
  std::vector<std::uint8_t> pores;
  for_each_voxel(size, [&](const Index3& p) { pores.push_back(pore(p) ? 1 : 0); });
  return diffusion_of(pores, size, spacing, axis);
}

/// The same by elimination, of the equations of all pores: those that lead nowhere get a leak too
/// small to count, so that they have an answer.
double eliminated(const std::vector<std::uint8_t>& pores, const Size3& size,
                  const Point3& spacing, int axis) {
  const auto count = pores.size();
  std::vector<std::vector<double>> rows(count, std::vector<double>(count + 1));
  const auto at = [&](const Index3& p) {
    return static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x);
  };
  const auto conductance = [&](int a) {
    const auto i = static_cast<std::size_t>(a);
    return spacing[(i + 1) % 3] * spacing[(i + 2) % 3] / spacing[i];
  };
  const double end = 2 * conductance(axis);
  for_each_voxel(size, [&](const Index3& p) {
    std::vector<double>& row = rows[at(p)];
    row[at(p)] = 1e-14;
    if (pores[at(p)] == 0) return;
    for (int a = 0; a < 3; ++a) {
      for (const int step : {-1, 1}) {
        Index3 q = p;
        q[a] += step;
        if (q[a] < 0 || q[a] >= size[a]) {
          if (a == axis) row[at(p)] += end;
          if (a == axis && step < 0) row[count] += end;
        } else if (pores[at(q)] != 0) {
          row[at(p)] += conductance(a);
          row[at(q)] -= conductance(a);
        }
      }
    }
  });
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t best = i;
    for (std::size_t j = i; j < count; ++j) {
      if (std::abs(rows[j][i]) > std::abs(rows[best][i])) best = j;
    }
    std::swap(rows[i], rows[best]);
    for (std::size_t j = 0; j < count; ++j) {
      const double share = rows[j][i] / rows[i][i];
      if (j == i || share == 0) continue;
      for (std::size_t k = i; k <= count; ++k) rows[j][k] -= share * rows[i][k];
    }
  }
  double flux = 0;
  for_each_voxel(size, [&](const Index3& p) {
    if (p[axis] + 1 != size[axis] || pores[at(p)] == 0) return;
    flux += end * rows[at(p)][count] / rows[at(p)][at(p)];
  });
  const double length = spacing[static_cast<std::size_t>(axis)] * static_cast<double>(size[axis]);
  return flux * length * length /
         (static_cast<double>(count) * spacing[0] * spacing[1] * spacing[2]);
}

TEST(Diffusion, StraightPoresHaveNoTortuosity) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = diffusion_of({9, 8, 7}, {0.5, 1, 2}, axis, [&](const Index3& p) {
      return p[(axis + 1) % 3] % 3 == 0 && p[(axis + 2) % 3] % 2 == 0;
    });
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->tortuosity, 1, 1e-6);
    EXPECT_LE(found->error, kDiffusionError);
  }
}

TEST(Diffusion, LayersInSeriesAddTheirResistance) {
  // Free space, then a pore of a quarter of the area, so wide that the bend around its mouth counts
  // little: resistance between that of straight columns and that of layers in series.
  const auto found = diffusion_of({40, 40, 40}, {1, 1, 1}, 2, [](const Index3& p) {
    return p.z < 20 || (p.x < 20 && p.y < 20);
  });
  ASSERT_TRUE(found);
  const double series = 1 / (0.5 + 0.5 * 4);
  EXPECT_LT(found->effective, series);
  EXPECT_GT(found->effective, 0.25);
}

TEST(Diffusion, IsThatOfAShortSystemSolvedByHand) {
  // Two voxels side by side, two planes; the second plane has one pore. The conductance is 1
  // between voxels and 2 to the ends; the concentration is 1 before the first plane, 0 behind all.
  //     a b    4 a - b - c = 2
  //     c      3 b - a     = 2
  //            3 c - a     = 0
  const auto found = diffusion_of({2, 1, 2}, {1, 1, 1}, 2, [](const Index3& p) {
    return p.z == 0 || p.x == 0;
  });
  ASSERT_TRUE(found);
  const double a = (2 + 2.0 / 3) / (4 - 2.0 / 3);
  const double c = a / 3;
  // Flux 2 c; length 2, area 2.
  EXPECT_NEAR(found->effective, 2 * c * 2 / 2, 1e-6);
  EXPECT_NEAR(found->tortuosity, 0.75 / found->effective, 1e-9);
}

TEST(Diffusion, IsThatOfEquationsSolvedByElimination) {
  std::mt19937 random(7);
  const Size3 sizes[] = {{7, 6, 5}, {1, 13, 9}, {4, 4, 12}, {11, 2, 7}, {3, 1, 1}};
  const Point3 spacings[] = {{1, 1, 1}, {0.1, 1, 7.3}, {3, 1, 1}, {0.005, 0.005, 0.0061}};
  int found_count = 0;
  for (const Size3& size : sizes) {
    for (const Point3& spacing : spacings) {
      for (const unsigned percent : {50U, 70U, 95U}) {
        std::vector<std::uint8_t> pores(static_cast<std::size_t>(size.voxel_count()));
        for (std::uint8_t& pore : pores) pore = random() % 100 < percent ? 1 : 0;
        for (int axis = 0; axis < 3; ++axis) {
          const auto found = diffusion_of(pores, size, spacing, axis);
          const double wanted = eliminated(pores, size, spacing, axis);
          if (!found) {
            EXPECT_LT(wanted, 1e-9);
            continue;
          }
          ++found_count;
          EXPECT_NEAR(found->effective / wanted, 1, 1e-7) << size.x << " along " << axis;
        }
      }
    }
  }
  EXPECT_GT(found_count, 60);
}

TEST(Diffusion, WindingChannelsOfOneVoxelAreAsLongAsTheyAre) {
  // Up one column, over, down the next, ... and out at the top of the last: a channel of voxels
  // side by side whose resistance is the sum of theirs.
  const Size3 size = {61, 1, 33};
  double voxels = 0;
  const auto found = diffusion_of(size, {1, 1, 1}, 2, [&](const Index3& p) {
    const bool is_turn = p.x % 2 == 1 && p.z == (p.x % 4 == 1 ? size.z - 2 : 1);
    const bool is_column = p.x % 2 == 0 && (p.z > 0 || p.x == 0) &&
                           (p.z < size.z - 1 || p.x == size.x - 1);
    voxels += is_turn || is_column ? 1 : 0;
    return is_turn || is_column;
  });
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->effective * voxels * 61 / 33, 1, 1e-7);
  EXPECT_LT(found->steps, 40);
}

TEST(Diffusion, DoesNotDependOnThreads) {
  std::mt19937 random(3);
  const Size3 size = {70, 60, 50};
  std::vector<std::uint8_t> pores(static_cast<std::size_t>(size.voxel_count()));
  for (std::uint8_t& pore : pores) pore = random() % 100 < 45 ? 1 : 0;
  std::optional<PoreDiffusion> by[2];
  for (int threads = 1; threads <= 2; ++threads) {
    auto& found = by[static_cast<std::size_t>(threads) - 1];
    tbb::task_arena arena(threads);
    arena.execute([&] { found = diffusion_of(pores, size, {1, 1, 1.7}, 1); });
    ASSERT_TRUE(found);
  }
  EXPECT_EQ(by[0]->effective, by[1]->effective);
  EXPECT_EQ(by[0]->steps, by[1]->steps);
  EXPECT_LT(by[0]->steps, 20);
}

TEST(Diffusion, TakesNoMoreMemoryThanItSays) {
  // Graphs over pores of long voxels are the largest, above all in mazes one voxel wide.
  std::mt19937 random(5);
  const NoProgress progress;
  const Size3 size = {41, 41, 41};
  for (const unsigned percent : {35U, 50U, 101U}) {
    std::vector<std::uint8_t> pores;
    for_each_voxel(size, [&](const Index3& p) {
      const std::int64_t odd = p.x % 2 + p.y % 2 + p.z % 2;
      const bool is_maze = odd == 0 || (odd == 1 && random() % 100 < 60);
      pores.push_back((percent > 100 ? is_maze : random() % 100 < percent) ? 1 : 0);
    });
    for (const Point3& spacing : {Point3{1, 1, 1}, {1, 1, 5}, {0.3, 1, 2}, {1, 30, 5}}) {
      const PoreNetwork network(pores, size, spacing, 2, progress);
      const std::uint64_t count = network.count();
      ASSERT_GT(count, 1000U);
      std::uint64_t bytes = 41 * count;
      for (MergedPores made = merged(network);; made = merged(made.clusters, network)) {
        bytes += 25 * made.clusters.count() + 8 * made.clusters.links.size();
        if (!made.clusters.has_links()) break;
      }
      EXPECT_LT(bytes, pore_diffusion_bytes(0, count)) << percent << ' ' << spacing[1];
    }
  }
}

TEST(Diffusion, SpheresSlowItAsMaxwellSays) {
  // One ball in a cube of 40, porosity 1 - f: D_eff = D * (1 - f) / (1 + f / 2).
  const double radius = 12;
  double solid = 0;
  const auto found = diffusion_of({40, 40, 40}, {1, 1, 1}, 0, [&](const Index3& p) {
    const double x = static_cast<double>(p.x) - 19.5;
    const double y = static_cast<double>(p.y) - 19.5;
    const double z = static_cast<double>(p.z) - 19.5;
    const bool is_solid = x * x + y * y + z * z <= radius * radius;
    solid += is_solid ? 1 : 0;
    return !is_solid;
  });
  ASSERT_TRUE(found);
  const double f = solid / 64000;
  EXPECT_NEAR(found->effective, (1 - f) / (1 + f / 2), 0.01);
}

TEST(Diffusion, DeadEndsHoldStill) {
  const auto open = diffusion_of({5, 5, 9}, {1, 1, 1}, 2,
                                 [](const Index3& p) { return p.x == 2 && p.y == 2; });
  const auto with_ends = diffusion_of({5, 5, 9}, {1, 1, 1}, 2, [](const Index3& p) {
    return (p.y == 2 && (p.x == 2 || p.z == 4)) || (p.y == 0 && p.x == 0 && p.z < 5);
  });
  ASSERT_TRUE(open && with_ends);
  EXPECT_NEAR(with_ends->effective, open->effective, 1e-6);
  EXPECT_GT(with_ends->tortuosity, open->tortuosity);
  EXPECT_FALSE(diffusion_of({5, 5, 9}, {1, 1, 1}, 2, [](const Index3& p) { return p.z != 4; }));
}

TEST(Diffusion, SaysHowFarItIsAndStopsWhenAsked) {
  const Size3 size = {24, 24, 24};
  std::vector<std::uint8_t> pores;
  for_each_voxel(size, [&](const Index3& p) { pores.push_back(p.x % 5 < 3 || p.z % 7 == 0); });
  testing::StoppingProgress watching(1 << 30);
  const auto found = pore_diffusion(pores, size, {1, 1, 1}, 2, 24 * 24 * 24, watching);
  ASSERT_TRUE(found);
  EXPECT_EQ(watching.done_, kDiffusionParts);
  // Before the first step of the solution, and at one in its middle.
  for (const int answered : {0, watching.questions_ / 2}) {
    testing::StoppingProgress stopping(answered);
    EXPECT_THROW(pore_diffusion(pores, size, {1, 1, 1}, 2, 24 * 24 * 24, stopping), Error);
    EXPECT_LT(stopping.done_, kDiffusionParts);
    if (answered > 0) {
      EXPECT_GT(stopping.done_, kDiffusionParts / 10);
    }
  }
  testing::StoppingProgress closed(1 << 30);
  EXPECT_FALSE(pore_diffusion(std::vector<std::uint8_t>(pores.size()), size, {1, 1, 1}, 2,
                              24 * 24 * 24, closed));
  EXPECT_EQ(closed.done_, kDiffusionParts);
}

}  // namespace
}  // namespace octavo
