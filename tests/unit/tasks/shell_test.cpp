#include "octavo/tasks/shell.h"

#include <random>

#include "octavo/ops/mask/shell.h"
#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseLabels;
using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kShellSize = {80, 70, 66};

class Shell : public testing::TaskFiles {
 protected:
  void SetUp() override {
    std::mt19937 random(21);
    mask_ = testing::random_mask(kShellSize, random);
    options_.input = write("mask.8vo", mask_);
  }

  DenseMask mask_;
  ShellOptions options_;
};

TEST_F(Shell, LeavesAreCountedAndNothingIsWrittenUnlessAsked) {
  const ShellResult result = shell(options_, context_);
  const MaskTree tree = testing::tree_of(mask_);
  EXPECT_EQ(result.leaves, leaf_count(tree));
  EXPECT_EQ(result.kept, leaf_count(shell(tree)));
  EXPECT_LT(result.kept, result.leaves);
  EXPECT_EQ(result.file_bytes, 0u);
}

TEST_F(Shell, WhatIsKeptIsOfTheMaskAndHoldsItsSurface) {
  options_.output = {folder_.file("shell.8vo")};
  const ShellResult result = shell(options_, context_);
  EXPECT_EQ(result.file_bytes, std::filesystem::file_size(options_.output->path));
  const DenseLabels kept = read(options_.output->path);
  const std::vector<Index3> steps = testing::neighbor_steps(6);
  std::uint64_t voxels = 0;
  std::size_t wrong = 0;
  for_each_voxel(kShellSize, [&](const Index3& p) {
    voxels += kept.at(p) != 0 ? 1u : 0u;
    const bool is_surface =
        mask_.at(p) != 0 && std::any_of(steps.begin(), steps.end(), [&](const Index3& step) {
          const Index3 q = testing::moved(p, step);
          return !box_of(kShellSize).contains(q) || mask_.at(q) == 0;
        });
    if (kept.at(p) != 0 ? mask_.at(p) == 0 : is_surface) ++wrong;
  });
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(voxels, result.voxels);
}

}  // namespace
}  // namespace octavo
