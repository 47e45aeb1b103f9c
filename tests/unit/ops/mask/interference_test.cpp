#include "octavo/ops/mask/interference.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "octavo/core/error.h"
#include "octavo/ops/mask/set_operations.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

void add_voxel(const Index3& p, VoxelExtent& to) {
  const Box one{p, {p.x + 1, p.y + 1, p.z + 1}};
  if (to.voxel_count++ == 0) to.box = one;
  for (int axis = 0; axis < 3; ++axis) {
    to.box.lo[axis] = std::min(to.box.lo[axis], one.lo[axis]);
    to.box.hi[axis] = std::max(to.box.hi[axis], one.hi[axis]);
  }
}

// 1: in a alone, 2: in b alone, 3: in both, 0: in none or outside.
int state_at(const DenseMask& a, const DenseMask& b, const Index3& p) {
  return box_of(a.size).contains(p) ? a.at(p) + 2 * b.at(p) : 0;
}

Interference expected(const DenseMask& a, const DenseMask& b, Connectivity connectivity) {
  Interference found;
  testing::for_each_voxel(a.size, [&](const Index3& p) {
    const int here = state_at(a, b, p);
    if (here == 3) add_voxel(p, found.overlap);
    if (here != 1 && here != 2) return;
    bool is_touched = false;
    for (std::size_t i = 0; i < static_cast<std::size_t>(connectivity); ++i) {
      const Direction& d = kDirections[i];
      if (state_at(a, b, {p.x + d.x, p.y + d.y, p.z + d.z}) != 3 - here) continue;
      is_touched = true;
      if (here == 1 && i < 6) ++found.face_pairs[d.x != 0 ? 0 : d.y != 0 ? 1 : 2];
    }
    if (is_touched) add_voxel(p, here == 1 ? found.contact_a : found.contact_b);
  });
  return found;
}

void expect_interference(const DenseMask& a, const DenseMask& b) {
  const MaskTree tree_a = testing::tree_of(a);
  const MaskTree tree_b = testing::tree_of(b);
  for (const Connectivity connectivity : testing::kConnectivities) {
    ASSERT_EQ(interference(tree_a, tree_b, connectivity), expected(a, b, connectivity))
        << a.size.x << " " << a.size.y << " " << a.size.z << " by "
        << static_cast<int>(connectivity);
  }
}

TEST(Interference, IsWhatEveryVoxelSays) {
  std::mt19937 random(1);
  for (const Size3& size : testing::odd_sizes()) {
    for (int turn = 0; turn < 6; ++turn) {
      expect_interference(testing::random_mask(size, random), testing::random_mask(size, random));
    }
  }
}

TEST(Interference, IsWhatEveryVoxelSaysOfMasksThatShareNothing) {
  std::mt19937 random(2);
  for (const Size3& size : testing::odd_sizes()) {
    for (int turn = 0; turn < 6; ++turn) {
      const DenseMask a = testing::random_mask(size, random);
      DenseMask b = testing::random_mask(size, random);
      for (std::size_t i = 0; i < a.voxels.size(); ++i) {
        if (a.voxels[i] != 0) b.voxels[i] = 0;
      }
      expect_interference(a, b);
    }
  }
}

TEST(Interference, IsFoundAcrossTheBordersOfLargeCubes) {
  const Size3 size{300, 270, 260};
  const MaskTree a = box_mask(size, {{0, 0, 0}, {256, 256, 128}});
  for (const auto& [b, faces] : std::initializer_list<std::pair<Box, std::uint64_t>>{
           {{{256, 0, 0}, {300, 270, 260}}, 256 * 128},
           {{{0, 0, 128}, {10, 256, 260}}, 10 * 256},
           {{{256, 256, 128}, {300, 270, 260}}, 0},
           {{{257, 0, 0}, {300, 270, 260}}, 0}}) {
    const Interference found = interference(a, box_mask(size, b), Connectivity::faces);
    EXPECT_EQ(found.face_pairs[0] + found.face_pairs[1] + found.face_pairs[2], faces);
    EXPECT_EQ(found.contact_a.voxel_count, faces);
    EXPECT_FALSE(found.is_overlap());
  }
  const MaskTree corner = box_mask(size, {{256, 256, 128}, {300, 270, 260}});
  EXPECT_EQ(interference(a, corner, Connectivity::edges).contact_a.voxel_count, 0);
  const Interference at_corner = interference(a, corner, Connectivity::corners);
  EXPECT_EQ(at_corner.contact_a, (VoxelExtent{1, {{255, 255, 127}, {256, 256, 128}}}));
  EXPECT_EQ(at_corner.contact_b, (VoxelExtent{1, {{256, 256, 128}, {257, 257, 129}}}));
  const Interference with_itself = interference(a, a, Connectivity::corners);
  EXPECT_EQ(with_itself.overlap, (VoxelExtent{256 * 256 * 128, {{0, 0, 0}, {256, 256, 128}}}));
  EXPECT_FALSE(with_itself.is_contact());
}

TEST(Interference, DoesNotDependOnThreadsAndTurnsWithItsMasks) {
  std::mt19937 random(3);
  const Size3 size{200, 180, 150};
  DenseMask a = testing::random_mask(size, random);
  DenseMask b = testing::random_mask(size, random);
  for (auto& voxel : a.voxels) voxel ^= static_cast<std::uint8_t>(random() % 50 == 0);
  const MaskTree tree_a = testing::tree_of(a);
  const MaskTree tree_b = testing::tree_of(b);
  Interference alone;
  tbb::task_arena(1).execute(
      [&] { alone = interference(tree_a, tree_b, Connectivity::corners); });
  tbb::task_arena(4).execute(
      [&] { EXPECT_EQ(interference(tree_a, tree_b, Connectivity::corners), alone); });
  EXPECT_EQ(alone, expected(a, b, Connectivity::corners));
  std::swap(alone.contact_a, alone.contact_b);
  EXPECT_EQ(interference(tree_b, tree_a, Connectivity::corners), alone);
}

TEST(Interference, RejectsVolumesOfOtherSizes) {
  EXPECT_THROW(interference(MaskTree({4, 4, 4}), MaskTree({4, 4, 5}), Connectivity::faces), Error);
}

}  // namespace
}  // namespace octavo
