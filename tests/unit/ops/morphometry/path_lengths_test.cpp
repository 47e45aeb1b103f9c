#include "octavo/ops/morphometry/path_lengths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "octavo/core/error.h"
#include "support/dense_mask.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

template <class Inside>
std::optional<PathLengths> paths_of(const Size3& size, const Point3& spacing, int axis,
                                    Inside inside) {
  std::vector<std::uint8_t> pores(static_cast<std::size_t>(size.voxel_count()));
  std::size_t at = 0;
  testing::for_each_voxel(size, [&](const Index3& p) { pores[at++] = inside(p) ? 1 : 0; });
  NoProgress progress;
  return path_lengths(pores, size, spacing, axis, progress);
}

TEST(PathLengths, OfStraightPoresAreOne) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto paths = paths_of({12, 9, 10}, {0.5, 0.7, 0.2}, axis, [&](const Index3& p) {
      return p[(axis + 1) % 3] % 3 == 0;
    });
    ASSERT_TRUE(paths.has_value());
    EXPECT_NEAR(paths->tortuosity, 1, 1e-6);
    EXPECT_NEAR(paths->shortest, 1, 1e-6);
    EXPECT_EQ(paths->reached_share, 1);
  }
}

TEST(PathLengths, OfASlantedPoreAreThoseOfItsDiagonal) {
  // A channel that goes one voxel aside for each one ahead.
  const auto paths = paths_of({120, 30, 100}, {1, 1, 1}, 2, [](const Index3& p) {
    return std::abs(p.x - p.z - 8) <= 5;
  });
  ASSERT_TRUE(paths.has_value());
  EXPECT_NEAR(paths->tortuosity, std::sqrt(2), 0.06);
}

TEST(PathLengths, OfAMazeAreItsWays) {
  // Walls across with openings at opposite ends: 20 aside for each 4 ahead.
  const auto is_free = [](const Index3& p) {
    if (p.z % 4 != 3) return true;
    return p.z % 8 == 3 ? p.x == 0 : p.x == 20;
  };
  const auto paths = paths_of({21, 3, 40}, {1, 1, 1}, 2, is_free);
  ASSERT_TRUE(paths.has_value());
  const double expected = (9 * 20.0 + 39) / 39;
  EXPECT_GT(paths->tortuosity, 0.85 * expected);
  EXPECT_LT(paths->tortuosity, 1.1 * expected);
}

TEST(PathLengths, WhereNoWayLeadsThroughThereAreNone) {
  EXPECT_FALSE(paths_of({8, 8, 8}, {1, 1, 1}, 0, [](const Index3& p) { return p.x != 4; }));
  EXPECT_FALSE(paths_of({8, 8, 1}, {1, 1, 1}, 2, [](const Index3&) { return true; }));
  const auto half = paths_of({8, 8, 8}, {1, 1, 1}, 2, [](const Index3& p) {
    return p.x < 4 || (p.x > 4 && p.z > 2);
  });
  ASSERT_TRUE(half.has_value());
  EXPECT_NEAR(half->reached_share, 4.0 / 7, 1e-9);
}

TEST(PathLengths, SayHowManyVoxelsAreReachedAndStopWhenAsked) {
  const Size3 size = {60, 50, 40};
  const std::vector<std::uint8_t> pores(static_cast<std::size_t>(size.voxel_count()), 1);
  testing::StoppingProgress watching(1 << 30);
  ASSERT_TRUE(path_lengths(pores, size, {1, 1, 1}, 0, watching));
  EXPECT_EQ(watching.done_, size.voxel_count());
  testing::StoppingProgress stopping;
  EXPECT_THROW(path_lengths(pores, size, {1, 1, 1}, 0, stopping), Error);
}

}  // namespace
}  // namespace octavo
