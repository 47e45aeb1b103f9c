#include "octavo/ops/mask/morphology.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "octavo/core/error.h"
#include "octavo/core/size_tolerance.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/ops/mask/surface_voxels.h"
#include "support/dense_mask.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using testing::DenseMask;

bool is_within(const Index3& step, double radius_mm, const Point3& spacing_mm) {
  long double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const long double mm =
        static_cast<long double>(step[axis]) * spacing_mm[static_cast<std::size_t>(axis)];
    sum += mm * mm;
  }
  return std::sqrt(sum) <= static_cast<long double>(radius_mm) * (1 + kSizeTolerance);
}

// Every step of the volume that lies within the radius, in all directions.
std::vector<Index3> ball_of(double radius_mm, const Point3& spacing_mm, const Size3& size) {
  std::vector<Index3> steps;
  for (std::int64_t z = 1 - size.z; z < size.z; ++z)
    for (std::int64_t y = 1 - size.y; y < size.y; ++y)
      for (std::int64_t x = 1 - size.x; x < size.x; ++x)
        if (is_within({x, y, z}, radius_mm, spacing_mm)) steps.push_back({x, y, z});
  return steps;
}

// Every voxel of `value` gives it to the voxels one of the steps away; outside nothing happens.
DenseMask spread(const DenseMask& mask, std::uint8_t value, const std::vector<Index3>& steps) {
  DenseMask made = mask;
  const Box volume = box_of(mask.size);
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    if (mask.at(p) != value) return;
    for (const Index3& s : steps) {
      const Index3 q{p.x + s.x, p.y + s.y, p.z + s.z};
      if (volume.contains(q)) made.at(q) = value;
    }
  });
  return made;
}

void expect_morphology(const DenseMask& mask, const Reach& reach,
                       const std::vector<Index3>& steps) {
  NoProgress progress;
  const MaskTree tree = testing::tree_of(mask);
  const DenseMask grown = spread(mask, 1, steps);
  const DenseMask shrunk = spread(mask, 0, steps);
  const MaskTree dilated = dilate(tree, reach, progress);
  ASSERT_TRUE(is_valid(dilated));
  ASSERT_EQ(dilated, testing::tree_of(grown));
  ASSERT_EQ(erode(tree, reach, progress), testing::tree_of(shrunk));
  ASSERT_EQ(opening(tree, reach, progress), testing::tree_of(spread(shrunk, 1, steps)));
  ASSERT_EQ(closing(tree, reach, progress), testing::tree_of(spread(grown, 0, steps)));
}

TEST(Morphology, IsThatOfEveryVoxelWithABallInMillimeters) {
  std::mt19937 random(1);
  const Point3 spacings[] = {{1, 1, 1}, {0.5, 0.75, 2}, {3, 0.9, 0.4}};
  for (const Size3& size : {Size3{1, 1, 1}, {5, 3, 7}, {65, 64, 63}, {130, 67, 21}, {17, 1, 90},
                            {3, 280, 2}}) {
    for (const Point3& spacing : spacings) {
      for (const double radius : {0.0, 0.6, 1.0, 2.3}) {
        const DenseMask mask = testing::random_mask(size, random);
        SCOPED_TRACE(::testing::Message() << size.x << " " << size.y << " " << size.z << " by "
                                          << radius << " at " << spacing[0]);
        expect_morphology(mask, Reach::within_mm(radius, spacing, size),
                          ball_of(radius, spacing, size));
      }
    }
  }
}

TEST(Morphology, IsThatOfEveryVoxelInNoise) {
  std::mt19937 random(2);
  DenseMask mask{{70, 66, 65}, {}};
  for (const unsigned one_in : {2U, 30U, 3000U}) {
    mask.voxels.clear();
    for (std::int64_t i = 0; i < mask.size.voxel_count(); ++i) {
      mask.voxels.push_back(random() % one_in == 0 ? 1 : 0);
    }
    expect_morphology(mask, Reach::within_mm(2, {1, 0.8, 0.7}, mask.size),
                      ball_of(2, {1, 0.8, 0.7}, mask.size));
  }
}

TEST(Morphology, IsThatOfNeighborsTakenSoManyTimes) {
  std::mt19937 random(3);
  NoProgress progress;
  for (const Size3& size : {Size3{5, 3, 7}, {65, 64, 63}, {130, 67, 21}, {3, 280, 2}}) {
    for (const Connectivity connectivity : testing::kConnectivities) {
      std::vector<Index3> steps(1);
      for (std::size_t i = 0; i < static_cast<std::size_t>(connectivity); ++i) {
        steps.push_back({kDirections[i].x, kDirections[i].y, kDirections[i].z});
      }
      const DenseMask mask = testing::random_mask(size, random);
      DenseMask grown = mask;
      for (int count = 1; count <= 4; ++count) {
        grown = spread(grown, 1, steps);
        const Reach reach = Reach::in_steps(count, connectivity, size);
        ASSERT_EQ(dilate(testing::tree_of(mask), reach, progress), testing::tree_of(grown))
            << static_cast<int>(connectivity) << " times " << count;
      }
    }
  }
}

// Radii far beyond a cube of 64^3: cubes are settled whole.
TEST(Morphology, TakesRadiiLongerThanCubes) {
  std::mt19937 random(4);
  NoProgress progress;
  const Size3 size{330, 290, 270};
  const Point3 spacing{1, 1.25, 0.8};
  DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  std::vector<Index3> points;
  for (int i = 0; i < 3; ++i) {
    const auto below = [&](std::int64_t n) {
      return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
    };
    points.push_back({below(size.x), below(size.y), below(size.z)});
    mask.at(points.back()) = 1;
  }
  for (const double radius : {40.0, 130.0, 1e6}) {
    DenseMask grown{size, std::vector<std::uint8_t>(mask.voxels.size())};
    testing::for_each_voxel(size, [&](const Index3& p) {
      grown.at(p) = std::any_of(points.begin(), points.end(), [&](const Index3& q) {
        return is_within({p.x - q.x, p.y - q.y, p.z - q.z}, radius, spacing);
      });
    });
    const Reach reach = Reach::within_mm(radius, spacing, size);
    const MaskTree dilated = dilate(testing::tree_of(mask), reach, progress);
    ASSERT_TRUE(is_valid(dilated));
    EXPECT_EQ(dilated, testing::tree_of(grown)) << radius;
    for (DenseMask* const each : {&mask, &grown}) {
      for (auto& voxel : each->voxels) voxel ^= std::uint8_t{1};
    }
    EXPECT_EQ(erode(testing::tree_of(mask), reach, progress), testing::tree_of(grown)) << radius;
    for (auto& voxel : mask.voxels) voxel ^= std::uint8_t{1};
  }
}

TEST(Morphology, OpensToLessAndClosesToMoreAndOnlyOnce) {
  std::mt19937 random(5);
  NoProgress progress;
  const Size3 size{140, 90, 80};
  DenseMask mask = testing::random_mask(size, random);
  for (auto& voxel : mask.voxels) voxel ^= static_cast<std::uint8_t>(random() % 500 == 0);
  const MaskTree tree = testing::tree_of(mask);
  const Reach reach = Reach::within_mm(3.3, {1, 0.9, 1.4}, size);
  const MaskTree opened = opening(tree, reach, progress);
  const MaskTree closed = closing(tree, reach, progress);
  EXPECT_TRUE(combine(opened, tree, SetOperation::subtract).is_empty());
  EXPECT_TRUE(combine(tree, closed, SetOperation::subtract).is_empty());
  EXPECT_FALSE(opened == tree);
  EXPECT_FALSE(closed == tree);
  EXPECT_EQ(opening(opened, reach, progress), opened);
  EXPECT_EQ(closing(closed, reach, progress), closed);
}

TEST(Morphology, LeavesFullAndEmptyVolumesAlone) {
  NoProgress progress;
  const Size3 size{100, 90, 80};
  const Reach reach = Reach::within_mm(5, {1, 1, 1}, size);
  for (const Box& box : {Box{}, box_of(size)}) {
    const MaskTree mask = box_mask(size, box);
    EXPECT_EQ(dilate(mask, reach, progress), mask);
    EXPECT_EQ(erode(mask, reach, progress), mask);
  }
}

TEST(Morphology, DoesNotDependOnThreads) {
  std::mt19937 random(6);
  NoProgress progress;
  const Size3 size{200, 180, 150};
  const MaskTree mask = testing::tree_of(testing::random_mask(size, random));
  const Reach reach = Reach::within_mm(7, {1, 1.5, 2}, size);
  MaskTree alone;
  tbb::task_arena(1).execute([&] { alone = closing(mask, reach, progress); });
  tbb::task_arena(4).execute([&] { EXPECT_EQ(closing(mask, reach, progress), alone); });
}

TEST(Morphology, StopsWhenAsked) {
  testing::StoppingProgress progress;
  const Size3 size{100, 90, 80};
  const Reach reach = Reach::within_mm(5, {1, 1, 1}, size);
  EXPECT_THROW(dilate(box_mask(size, {{5, 5, 5}, {20, 20, 20}}), reach, progress), Error);
}

TEST(Morphology, StaysBelowALimitOfMemory) {
  NoProgress progress;
  const Size3 size{256, 256, 256};
  const MaskTree mask = box_mask(size, {{127, 127, 127}, {128, 128, 128}});
  const Reach reach = Reach::within_mm(100, {1, 1, 1}, size);
  const std::uint64_t enough = 16 * dilate(mask, reach, progress).memory_bytes();
  EXPECT_EQ(dilate(mask, reach, progress, enough), dilate(mask, reach, progress));
  try {
    dilate(mask, reach, progress, std::uint64_t{1} << 16);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
}

TEST(Morphology, CountsTheCubesThatAreCoveredWhole) {
  // One voxel covers 16^3 cubes of 64^3: they cost memory though none of their voxels is stored.
  NoProgress progress;
  const Size3 size{1024, 1024, 1024};
  const MaskTree mask = box_mask(size, {{512, 512, 512}, {513, 513, 513}});
  const Reach reach = Reach::within_mm(1024, {1, 1, 1}, size);
  const MaskTree all = dilate(mask, reach, progress);
  EXPECT_EQ(all.voxel_count(), static_cast<std::uint64_t>(size.voxel_count()));
  EXPECT_LT(all.memory_bytes(), 1000U);
  EXPECT_THROW(dilate(mask, reach, progress, std::uint64_t{1} << 17), Error);
}

TEST(Morphology, CoversWhatTheVolumeHasOfACube) {
  // In a plane nothing reaches 63 steps along z. A far reach must not be visited row by row.
  NoProgress progress;
  const Size3 size{1500, 1300, 1};
  const MaskTree mask = box_mask(size, {{700, 600, 0}, {701, 601, 1}});
  const Reach far = Reach::within_mm(1e9, {1, 1, 1}, size);
  EXPECT_EQ(far.longest(), (Index3{1499, 1299, 0}));
  EXPECT_EQ(dilate(mask, far, progress), box_mask(size, box_of(size)));
  const MaskTree disc = dilate(mask, Reach::within_mm(500, {1, 1, 1}, size), progress);
  EXPECT_TRUE(is_valid(disc));
  std::uint64_t expected = 0;
  for (std::int64_t y = -500; y <= 500; ++y)
    for (std::int64_t x = -500; x <= 500; ++x) expected += x * x + y * y <= 500 * 500 ? 1 : 0;
  EXPECT_EQ(disc.voxel_count(), expected);
  EXPECT_LE(dilation_thread_bytes(far, size), std::uint64_t{1300} * 16 + 65536);
}

TEST(Reach, IsATableNoLargerThanTheVolumeOrTheLimit) {
  const Size3 size{40, 30, 20};
  EXPECT_EQ(Reach::within_mm(1e6, {1, 1, 1}, size).memory_bytes(), 30U * 20 * 4);
  EXPECT_EQ(Reach::in_steps(std::int64_t{1} << 60, Connectivity::faces, size).memory_bytes(),
            30U * 20 * 4);
  EXPECT_NO_THROW(Reach::within_mm(1e6, {1, 1, 1}, size, 30 * 20 * 4));
  for (const auto& make : {+[](const Size3& s) { return Reach::within_mm(99, {1, 1, 1}, s, 2399); },
                           +[](const Size3& s) {
                             return Reach::in_steps(99, Connectivity::edges, s, 2399);
                           }}) {
    try {
      make(size);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
    }
  }
}

TEST(Reach, TakesDecimalSpacingsAsTheyAreMeant) {
  const Size3 size{100, 100, 100};
  EXPECT_EQ(Reach::within_mm(0.3, {0.1, 0.1, 0.1}, size).longest(), (Index3{3, 3, 3}));
  EXPECT_EQ(Reach::within_mm(0.7, {0.1, 0.07, 0.35}, size).longest(), (Index3{7, 10, 2}));
  EXPECT_EQ(Reach::within_mm(0.29999, {0.1, 0.1, 0.1}, size).longest(), (Index3{2, 2, 2}));
  EXPECT_EQ(Reach::within_mm(1e300, {1, 1, 1}, size).longest(), (Index3{99, 99, 99}));
  const Reach pythagoras = Reach::within_mm(5, {1, 1, 1}, size);
  EXPECT_EQ(pythagoras.along_x(3, 0), 4);
  EXPECT_EQ(pythagoras.along_x(4, 3), 0);
  EXPECT_EQ(pythagoras.along_x(4, 4), -1);
  EXPECT_EQ(pythagoras.along_x(6, 0), -1);
}

TEST(Reach, RejectsWhatIsNoLength) {
  const Size3 size{4, 4, 4};
  for (const double radius : {-1.0, std::numeric_limits<double>::infinity(),
                              std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(Reach::within_mm(radius, {1, 1, 1}, size), Error);
  }
  EXPECT_THROW(Reach::in_steps(-1, Connectivity::faces, size), Error);
}

TEST(SurfaceVoxels, AreThoseWithAFaceOnSomethingElse) {
  std::mt19937 random(7);
  for (const Size3& size : testing::odd_sizes()) {
    const DenseMask mask = testing::random_mask(size, random);
    DenseMask surface{size, std::vector<std::uint8_t>(mask.voxels.size())};
    testing::for_each_voxel(size, [&](const Index3& p) {
      if (mask.at(p) == 0) return;
      for (std::size_t i = 0; i < 6; ++i) {
        const Direction& d = kDirections[i];
        const Index3 q{p.x + d.x, p.y + d.y, p.z + d.z};
        if (!box_of(size).contains(q) || mask.at(q) == 0) surface.at(p) = 1;
      }
    });
    const MaskTree found = surface_voxels(testing::tree_of(mask), NoProgress());
    ASSERT_TRUE(is_valid(found));
    ASSERT_EQ(found, testing::tree_of(surface));
  }
  const Size3 size{300, 270, 260};
  const MaskTree box = box_mask(size, {{1, 1, 1}, {260, 260, 258}});
  const MaskTree inner = box_mask(size, {{2, 2, 2}, {259, 259, 257}});
  EXPECT_EQ(surface_voxels(box, NoProgress()), combine(box, inner, SetOperation::subtract));
}

}  // namespace
}  // namespace octavo
