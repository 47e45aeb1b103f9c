#include "octavo/ops/mask/set_operations.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

bool expected(SetOperation operation, bool a, bool b) {
  switch (operation) {
    case SetOperation::unite: return a || b;
    case SetOperation::intersect: return a && b;
    case SetOperation::subtract: return a && !b;
    case SetOperation::exclusive_or: break;
  }
  return a != b;
}

constexpr SetOperation kOperations[] = {SetOperation::unite, SetOperation::intersect,
                                        SetOperation::subtract, SetOperation::exclusive_or};

void expect_combined(const DenseMask& a, const DenseMask& b) {
  const MaskTree tree_a = testing::tree_of(a);
  const MaskTree tree_b = testing::tree_of(b);
  for (const SetOperation operation : kOperations) {
    DenseMask result = a;
    for (std::size_t i = 0; i < a.voxels.size(); ++i) {
      result.voxels[i] = expected(operation, a.voxels[i] != 0, b.voxels[i] != 0) ? 1 : 0;
    }
    const MaskTree found = combine(tree_a, tree_b, operation);
    ASSERT_TRUE(is_valid(found));
    ASSERT_EQ(found, testing::tree_of(result)) << static_cast<int>(operation);
  }
}

TEST(Combine, IsTheOperationOnEveryVoxel) {
  std::mt19937 random(1);
  for (const Size3& size : testing::odd_sizes()) {
    for (int turn = 0; turn < 5; ++turn) {
      expect_combined(testing::random_mask(size, random), testing::random_mask(size, random));
    }
  }
}

TEST(Combine, IsTheOperationOnNoise) {
  // Words enough that the work is split.
  std::mt19937 random(2);
  const Size3 size{200, 180, 150};
  DenseMask a = testing::random_mask(size, random);
  DenseMask b = testing::random_mask(size, random);
  for (auto& voxel : a.voxels) voxel ^= static_cast<std::uint8_t>(random() % 5 == 0);
  for (auto& voxel : b.voxels) voxel ^= static_cast<std::uint8_t>(random() % 7 == 0);
  expect_combined(a, b);
  expect_combined(a, {size, std::vector<std::uint8_t>(a.voxels.size(), 1)});
  expect_combined({size, std::vector<std::uint8_t>(a.voxels.size())}, b);
}

TEST(Complement, IsEveryOtherVoxelOfTheVolume) {
  std::mt19937 random(3);
  for (const Size3& size : testing::odd_sizes()) {
    DenseMask mask = testing::random_mask(size, random);
    const MaskTree tree = testing::tree_of(mask);
    for (auto& voxel : mask.voxels) voxel ^= 1;
    EXPECT_EQ(complement(tree), testing::tree_of(mask));
    EXPECT_EQ(complement(complement(tree)), tree);
  }
}

TEST(Combine, RejectsMasksOfOtherVolumes) {
  EXPECT_THROW(combine(MaskTree({4, 4, 4}), MaskTree({4, 4, 5}), SetOperation::unite), Error);
}

}  // namespace
}  // namespace octavo
