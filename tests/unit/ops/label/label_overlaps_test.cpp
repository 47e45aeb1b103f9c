// Overlaps of label maps against counts over dense arrays.
#include "octavo/ops/label/label_overlaps.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <map>
#include <random>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/ops/label/label_masks.h"
#include "support/dense_labels.h"

namespace octavo {
namespace {

using testing::DenseLabels;

/// A map made of random masks over each other.
DenseLabels random_labels(const Size3& size, std::mt19937& random) {
  DenseLabels labels(size);
  for (const std::int32_t label : {3, -2, 700, 0, 1, 2, 70000}) {
    const testing::DenseMask mask = testing::random_mask(size, random);
    for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
      if (mask.voxels[i] != 0 && random() % 16 != 0) labels.voxels[i] = label;
    }
  }
  return labels;
}

std::vector<LabelOverlap> dense_overlaps(const DenseLabels& a, const DenseLabels& b) {
  std::map<std::pair<std::int64_t, std::int64_t>, std::uint64_t> counts;
  for (std::size_t i = 0; i < a.voxels.size(); ++i) ++counts[{a.voxels[i], b.voxels[i]}];
  std::vector<LabelOverlap> overlaps;
  for (const auto& [pair, voxels] : counts) {
    overlaps.push_back({pair.first, pair.second, voxels});
  }
  return overlaps;
}

TEST(LabelOverlaps, AreTheCountsOverAllVoxels) {
  std::mt19937 random(81);
  for (const Size3& size : testing::odd_sizes()) {
    for (int round = 0; round < 3; ++round) {
      const DenseLabels a = random_labels(size, random);
      const DenseLabels b = random_labels(size, random);
      const DenseLabels uniform(size, 9);
      const LabelTree tree = testing::tree_of(a);
      EXPECT_EQ(label_overlaps(tree, testing::tree_of(b)), dense_overlaps(a, b));
      EXPECT_EQ(label_overlaps(tree, testing::tree_of(uniform)), dense_overlaps(a, uniform));
      EXPECT_EQ(label_overlaps(testing::tree_of(uniform), tree), dense_overlaps(uniform, a));
    }
  }
}

TEST(LabelOverlaps, OfLargeCubesAreThoseOfTheirBoxes) {
  const Size3 size{700, 300, 520};
  const Box box{{0, 0, 0}, {512, 256, 512}};
  const LabelMask whole{1, box_mask(size, box_of(size))};
  const LabelMask part{2, box_mask(size, box)};
  const LabelTree a = labels_of_masks(size, std::span(&whole, 1));
  const LabelTree b = labels_of_masks(size, std::span(&part, 1));
  const std::uint64_t all = 700 * 300 * 520;
  const std::uint64_t inside = 512 * 256 * 512;
  EXPECT_EQ(label_overlaps(a, b),
            (std::vector<LabelOverlap>{{1, 0, all - inside}, {1, 2, inside}}));
  EXPECT_EQ(label_overlaps(b, LabelTree(size)),
            (std::vector<LabelOverlap>{{0, 0, all - inside}, {2, 0, inside}}));
}

TEST(LabelOverlaps, DoNotDependOnThreads) {
  std::mt19937 random(82);
  const LabelTree a = testing::tree_of(random_labels({150, 130, 70}, random));
  const LabelTree b = testing::tree_of(random_labels({150, 130, 70}, random));
  const auto expected = label_overlaps(a, b);
  for (const int threads : {1, 2}) {
    tbb::task_arena(threads).execute([&] { EXPECT_EQ(label_overlaps(a, b), expected); });
  }
}

TEST(LabelOverlaps, OfOtherSizesAreRejected) {
  EXPECT_THROW(label_overlaps(LabelTree({4, 4, 4}), LabelTree({4, 4, 5})), Error);
}

TEST(LabelAgreements, CountEachLabelInBothMaps) {
  DenseLabels a({10, 1, 1});
  DenseLabels b({10, 1, 1});
  a.voxels = {1, 1, 1, 2, 2, 0, 0, 5, 0, 0};
  b.voxels = {1, 1, 2, 2, 2, 2, 0, 0, 7, 7};
  const auto agreements =
      label_agreements(label_overlaps(testing::tree_of(a), testing::tree_of(b)));
  EXPECT_EQ(agreements,
            (std::vector<LabelAgreement>{{1, 3, 2, 2}, {2, 2, 4, 2}, {5, 1, 0, 0}, {7, 0, 2, 0}}));
  EXPECT_DOUBLE_EQ(agreements[0].dice(), 0.8);
  EXPECT_DOUBLE_EQ(agreements[3].dice(), 0);
}

}  // namespace
}  // namespace octavo
