#include "octavo/ops/mask/fill_holes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

// Floods the background part of `start`; true when it reaches the border.
bool flood(const DenseMask& mask, const Index3& start, Connectivity connectivity,
           DenseMask& is_seen, std::vector<Index3>& part) {
  bool is_open = false;
  part = {start};
  is_seen.at(start) = 1;
  for (std::size_t next = 0; next < part.size(); ++next) {
    const Index3 p = part[next];
    for (int axis = 0; axis < 3; ++axis) {
      is_open = is_open || p[axis] == 0 || p[axis] == mask.size[axis] - 1;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(connectivity); ++i) {
      const Direction& d = kDirections[i];
      const Index3 q{p.x + d.x, p.y + d.y, p.z + d.z};
      if (!box_of(mask.size).contains(q) || mask.at(q) != 0 || is_seen.at(q) != 0) continue;
      is_seen.at(q) = 1;
      part.push_back(q);
    }
  }
  return is_open;
}

// The background is joined by corners for an object joined by faces, and by faces otherwise.
DenseMask expected(const DenseMask& mask, Connectivity object, std::size_t max_voxels) {
  const Connectivity background =
      object == Connectivity::faces ? Connectivity::corners : Connectivity::faces;
  DenseMask filled = mask;
  DenseMask is_seen{mask.size, std::vector<std::uint8_t>(mask.voxels.size())};
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    if (mask.at(p) != 0 || is_seen.at(p) != 0) return;
    std::vector<Index3> part;
    if (flood(mask, p, background, is_seen, part) || part.size() > max_voxels) return;
    for (const Index3& q : part) filled.at(q) = 1;
  });
  return filled;
}

void expect_filled(const DenseMask& mask) {
  for (const Connectivity object : testing::kConnectivities) {
    for (const std::uint64_t max_voxels : {std::uint64_t{1} << 60, std::uint64_t{3}}) {
      const FilledHoles filled = fill_holes(testing::tree_of(mask), object, max_voxels);
      ASSERT_TRUE(is_valid(filled.mask));
      ASSERT_EQ(filled.mask, testing::tree_of(expected(mask, object, max_voxels)));
      ASSERT_EQ(filled.mask.voxel_count(),
                testing::tree_of(mask).voxel_count() + filled.voxel_count);
    }
  }
}

TEST(FillHoles, FillsWhatAFloodFromTheBorderDoesNotReach) {
  std::mt19937 random(1);
  for (const Size3& size : testing::odd_sizes()) {
    for (int turn = 0; turn < 3; ++turn) expect_filled(testing::random_mask(size, random));
  }
}

TEST(FillHoles, FillsThemInNoise) {
  std::mt19937 random(2);
  DenseMask mask{{70, 66, 65}, {}};
  for (const unsigned one_in : {2U, 4U, 8U}) {
    mask.voxels.clear();
    for (std::int64_t i = 0; i < mask.size.voxel_count(); ++i) {
      mask.voxels.push_back(static_cast<std::uint8_t>(random() % one_in != 0));
    }
    expect_filled(mask);
  }
}

// A hollow box whose only gap is one edge of its wall.
TEST(FillHoles, TakesTheBackgroundThroughEdgesOnlyWhenTheObjectIsJoinedByFaces) {
  DenseMask mask{{12, 12, 12}, std::vector<std::uint8_t>(12 * 12 * 12)};
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    const bool is_in = std::min({p.x, p.y, p.z}) >= 2 && std::max({p.x, p.y, p.z}) <= 9;
    const bool is_inner = std::min({p.x, p.y, p.z}) >= 3 && std::max({p.x, p.y, p.z}) <= 8;
    mask.at(p) = is_in && !is_inner ? 1 : 0;
  });
  for (std::int64_t z = 3; z <= 8; ++z) mask.at({2, 2, z}) = 0;
  const MaskTree tree = testing::tree_of(mask);
  EXPECT_EQ(fill_holes(tree, Connectivity::faces).hole_count, 0);
  EXPECT_EQ(fill_holes(tree, Connectivity::edges).voxel_count, 6 * 6 * 6);
  EXPECT_EQ(fill_holes(tree, Connectivity::corners).hole_count, 1);
  EXPECT_EQ(fill_holes(tree, Connectivity::corners, 215).kept_count, 1);
  EXPECT_EQ(fill_holes(tree, Connectivity::corners, 216).kept_count, 0);
}

TEST(FillHoles, LeavesFullAndEmptyVolumesAlone) {
  const Size3 size{100, 90, 80};
  for (const Box& box : {Box{}, box_of(size)}) {
    const MaskTree mask = box_mask(size, box);
    const FilledHoles filled = fill_holes(mask, Connectivity::corners);
    EXPECT_EQ(filled.mask, mask);
    EXPECT_EQ(filled.hole_count, 0);
  }
}

}  // namespace
}  // namespace octavo
