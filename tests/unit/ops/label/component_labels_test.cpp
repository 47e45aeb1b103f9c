// Label maps of components against the labels of their voxels.
#include "octavo/ops/label/component_labels.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <random>

#include "octavo/core/error.h"
#include "support/dense_labels.h"
#include "support/dense_mask.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using testing::DenseLabels;

// The labels of the components that are kept, voxel by voxel.
LabelTree labels_of_voxels(const Components& found, std::size_t kept) {
  DenseLabels labels(found.mask().size());
  testing::for_each_voxel(labels.size, [&](const Index3& p) {
    const std::uint32_t label = found.label_of(p);
    labels.at(p) = label <= kept ? static_cast<std::int32_t>(label) : 0;
  });
  return testing::tree_of(labels);
}

TEST(ComponentLabels, AreThoseOfTheVoxels) {
  std::mt19937 random(11);
  std::vector<Size3> sizes = testing::odd_sizes();
  sizes.push_back({300, 70, 40});
  for (const Size3& size : sizes) {
    const MaskTree mask = testing::tree_of(testing::random_mask(size, random));
    for (const Connectivity connectivity : {Connectivity::faces, Connectivity::corners}) {
      const Components found(mask, connectivity);
      const std::size_t count = found.components().size();
      for (const std::size_t kept : {std::size_t{0}, std::size_t{1}, count / 2, count}) {
        const LabelTree labels = labels_of_components(found, kept);
        ASSERT_TRUE(is_valid(labels));
        EXPECT_EQ(labels, labels_of_voxels(found, kept));
      }
    }
  }
}

// Single voxels apart: words of as many parts as there can be.
TEST(ComponentLabels, OfGrainsAreThoseOfTheVoxels) {
  testing::DenseMask mask{{66, 34, 33}, {}};
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    mask.voxels.push_back((p.x + p.y + p.z) % 2 == 0 ? 1 : 0);
  });
  const MaskTree tree = testing::tree_of(mask);
  const Components found(tree, Connectivity::faces);
  for (const std::size_t kept : {std::size_t{1000}, found.components().size()}) {
    EXPECT_EQ(labels_of_components(found, kept), labels_of_voxels(found, kept));
  }
}

TEST(ComponentLabels, OfWholeSubTreesDependOnNoThread) {
  const Size3 size{600, 300, 260};
  const MaskTree mask = box_mask(size, {{0, 0, 0}, {600, 256, 256}});
  const Components found(mask, Connectivity::faces);
  const LabelTree expected = labels_of_components(found, 1);
  EXPECT_EQ(expected.label_at({599, 255, 255}), 1);
  EXPECT_EQ(expected.label_at({599, 256, 255}), 0);
  for (const int threads : {1, 3}) {
    tbb::task_arena(threads).execute(
        [&] { EXPECT_EQ(labels_of_components(found, 1), expected); });
  }
}

TEST(ComponentLabels, AMemoryLimitBelowTheNeedIsAnError) {
  const MaskTree mask = box_mask({70, 70, 70}, {{3, 3, 3}, {61, 61, 61}});
  const Components found(mask, Connectivity::faces);
  EXPECT_THROW(labels_of_components(found, 1, 100), Error);
}

TEST(ComponentLabels, StopsWhenAsked) {
  const Size3 size = {130, 70, 66};
  const MaskTree mask = box_mask(size, box_of(size));
  const Components found(mask, Connectivity::faces);
  const testing::StoppingProgress progress;
  try {
    labels_of_components(found, 1, 0, &progress);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::cancelled);
  }
}

TEST(ComponentLabels, ALimitIsAskedBeforeTheMemoryIsTaken) {
  // Of these cubes of 64^3 no memory has all.
  const Size3 size = {1 << 20, 1 << 20, 1 << 20};
  const MaskTree mask = box_mask(size, box_of(size));
  const Components found(mask, Connectivity::faces);
  try {
    labels_of_components(found, 1, std::uint64_t{64} << 20);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
}

}  // namespace
}  // namespace octavo
