// Label trees against dense arrays.
#include "octavo/octree/label_tree.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <functional>
#include <limits>
#include <map>
#include <random>

#include "octavo/core/error.h"
#include "octavo/octree/condense.h"
#include "octavo/ops/label/label_build.h"
#include "octavo/ops/label/label_masks.h"
#include "octavo/ops/measure/label_moments.h"
#include "octavo/ops/measure/mask_moments.h"
#include "support/built_file.h"
#include "support/dense_labels.h"

namespace octavo {
namespace {

using testing::DenseLabels;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const std::vector<ValueWindow> kAll = {{-kInfinity, kInfinity}};

/// Boxes and grains of as many labels as are drawn.
DenseLabels random_labels(const Size3& size, std::size_t label_count, std::mt19937& random) {
  std::vector<std::int32_t> names;
  for (std::size_t i = 0; i < label_count; ++i) {
    constexpr std::array<std::int32_t, 5> kEdges = {std::numeric_limits<std::int32_t>::min(), -1, 1,
                                                    65536,
                                                    std::numeric_limits<std::int32_t>::max()};
    names.push_back(i < kEdges.size() ? kEdges[i] : static_cast<std::int32_t>(random() % 100000));
  }
  return testing::random_labels(size, names, random);
}

/// Volumes that try the format: many sizes and numbers of labels, and every kind of word.
std::vector<DenseLabels> cases() {
  std::mt19937 random(71);
  std::vector<DenseLabels> all;
  for (const Size3& size : testing::odd_sizes()) {
    for (const std::size_t count : {1u, 2u, 7u, 300u}) {
      all.push_back(random_labels(size, count, random));
    }
  }
  all.push_back(DenseLabels({1, 1, 90}, -7));
  all.push_back(DenseLabels({64, 64, 64}, 5));
  all.push_back(DenseLabels({80, 64, 64}, 5));
  all.push_back(DenseLabels({64, 64, 256}, 0));
  all.push_back(DenseLabels({128, 256, 64}, 9));
  for (const std::int32_t period : {2, 3, 5, 9, 17, 33, 64}) {
    DenseLabels labels({21, 18, 70});
    std::int32_t next = 0;
    for (std::int32_t& label : labels.voxels) label = next++ % period - 1;
    all.push_back(std::move(labels));
  }
  // 64 labels in every word.
  DenseLabels words({20, 16, 12});
  testing::for_each_voxel(words.size, [&](const Index3& p) {
    words.at(p) = static_cast<std::int32_t>(p.z % 4 * 16 + p.y % 4 * 4 + p.x % 4 + p.x / 4 * 3);
  });
  all.push_back(std::move(words));
  // A label of its own for every voxel.
  DenseLabels noise({33, 20, 18});
  for (std::size_t i = 0; i < noise.voxels.size(); ++i) {
    noise.voxels[i] = static_cast<std::int32_t>(i);
  }
  all.push_back(std::move(noise));
  return all;
}

TEST(LabelTree, HasTheLabelOfEveryVoxel) {
  for (const DenseLabels& dense : cases()) {
    const LabelTree tree = testing::tree_of(dense);
    ASSERT_TRUE(is_valid(tree));
    ASSERT_EQ(testing::dense_of(tree), dense);
    for (const Index3& p : {Index3{-1, 0, 0}, Index3{dense.size.x, 0, 0}, Index3{0, 0, 1 << 22}}) {
      EXPECT_EQ(tree.label_at(p), 0);
    }
  }
}

template <class T>
class LabelTreeOf : public ::testing::Test {};
using LabelTypes = ::testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t,
                                    std::int32_t, std::uint32_t>;
TYPED_TEST_SUITE(LabelTreeOf, LabelTypes);

TYPED_TEST(LabelTreeOf, AnyTypeHoldsItsLimitsInsideLargerRows) {
  using T = TypeParam;
  // A block of 13 x 9 x 70 inside rows of 15 and planes of 11 rows.
  const Size3 size{13, 9, 70};
  std::vector<T> voxels(15 * 11 * 70, T{77});
  std::mt19937 random(78);
  const std::array<T, 4> labels = {std::numeric_limits<T>::min(), T{0}, T{1},
                                   std::numeric_limits<T>::max()};
  testing::for_each_voxel(size, [&](const Index3& p) {
    voxels[static_cast<std::size_t>((p.z * 11 + p.y) * 15 + p.x)] =
        labels[p.z < 20 ? random() % 4 : 3];
  });
  const LabelTree tree = make_labels({voxels.data(), voxel_type_of<T>(), size, 15, 15 * 11});
  ASSERT_TRUE(is_valid(tree));
  EXPECT_EQ(tree.labels().back(), static_cast<std::int64_t>(std::numeric_limits<T>::max()));
  std::vector<T> filled(static_cast<std::size_t>(size.voxel_count()));
  fill_voxels(tree, box_of(size), filled.data());
  std::size_t next = 0;
  testing::for_each_voxel(size, [&](const Index3& p) {
    const T expected = voxels[static_cast<std::size_t>((p.z * 11 + p.y) * 15 + p.x)];
    ASSERT_EQ(filled[next++], expected);
    ASSERT_EQ(tree.label_at(p), static_cast<std::int64_t>(expected));
  });
}

TEST(LabelTree, IsCondensedAsThePlanesAre) {
  for (const DenseLabels& dense : cases()) {
    CondenseOptions options;
    options.background = 0;
    const LinearOctree expected =
        condense(std::span<const std::int32_t>(dense.voxels), dense.size, options);
    const LabelTree tree = testing::tree_of(dense);
    ASSERT_EQ(to_linear_octree(tree), expected);
    const std::vector<std::int64_t> counts = leaf_counts(tree);
    ASSERT_EQ(counts.size(), expected.levels.size());
    for (std::size_t level = 0; level < counts.size(); ++level) {
      EXPECT_EQ(counts[level], leaf_count(expected, static_cast<int>(level)));
    }
  }
}

TEST(LabelTree, GivesItsLeavesInTheOrderOfTheirCodes) {
  std::mt19937 random(72);
  const LabelTree tree = testing::tree_of(random_labels({70, 70, 130}, 9, random));
  std::uint64_t end = 0;
  for_each_leaf(tree, [&](const OCode& leaf, std::uint32_t label) {
    EXPECT_GE(leaf.code << 3 * leaf.level, end);
    end = (leaf.code + 1) << 3 * leaf.level;
    EXPECT_EQ(tree.labels()[label], tree.label_at(corner_of(leaf)));
  });
  EXPECT_GT(end, 0u);
}

TEST(LabelTree, FillsAnyBox) {
  std::mt19937 random(73);
  // Words of two labels, and of many.
  const std::array<DenseLabels, 2> maps = {random_labels({130, 67, 71}, 2, random),
                                           random_labels({130, 67, 71}, 20, random)};
  const std::array<LabelTree, 2> trees = {testing::tree_of(maps[0]), testing::tree_of(maps[1])};
  for (int round = 0; round < 60; ++round) {
    const DenseLabels& dense = maps[static_cast<std::size_t>(round % 2)];
    const LabelTree& tree = trees[static_cast<std::size_t>(round % 2)];
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = static_cast<std::int64_t>(random() % 60);
      box.hi[axis] =
          std::min(dense.size[axis], box.lo[axis] + 1 + static_cast<std::int64_t>(random() % 70));
    }
    std::vector<std::int32_t> voxels(static_cast<std::size_t>(box.size().voxel_count()), 77);
    fill_voxels(tree, box, voxels.data());
    const Size3 size = box.size();
    testing::for_each_voxel(size, [&](const Index3& p) {
      const Index3 at{p.x + box.lo.x, p.y + box.lo.y, p.z + box.lo.z};
      ASSERT_EQ(voxels[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)],
                dense.at(at));
    });
  }
}

TEST(LabelTree, CountsTheVoxelsOfEveryLabel) {
  for (const DenseLabels& dense : cases()) {
    const LabelTree tree = testing::tree_of(dense);
    std::map<std::int64_t, std::uint64_t> expected;
    for (const std::int32_t label : dense.voxels) ++expected[label];
    const std::vector<std::uint64_t> counts = voxel_counts(tree);
    ASSERT_EQ(counts.size(), tree.labels().size());
    for (std::size_t i = 0; i < counts.size(); ++i) {
      // 0 may stand outside the volume alone.
      const auto found = expected.find(tree.labels()[i]);
      EXPECT_EQ(counts[i], found == expected.end() ? 0 : found->second);
      if (found != expected.end()) expected.erase(found);
    }
    EXPECT_TRUE(expected.empty());
  }
}

TEST(LabelTree, OfAMapAndOfItsMasksAreOne) {
  for (const DenseLabels& dense : cases()) {
    const LabelTree tree = testing::tree_of(dense);
    std::vector<LabelMask> masks = masks_of(tree);
    for (const LabelMask& mask : masks) {
      ASSERT_TRUE(is_valid(mask.tree));
      if (masks.size() > 20) continue;
      const LabelTree alone = labels_of_masks(dense.size, std::span(&mask, 1));
      ASSERT_TRUE(is_valid(alone));
      const std::vector<std::int64_t> label = {mask.label};
      EXPECT_EQ(mask_of(alone, label), mask.tree);
    }
    std::shuffle(masks.begin(), masks.end(), std::mt19937(1));
    EXPECT_EQ(labels_of_masks(dense.size, masks), tree);
  }
}

TEST(LabelTree, GivesTheMaskOfAnySetOfLabels) {
  std::mt19937 random(74);
  for (const DenseLabels& dense : cases()) {
    const LabelTree tree = testing::tree_of(dense);
    for (int round = 0; round < 3; ++round) {
      std::vector<std::int64_t> wanted = {0, 12345678};
      for (const std::int64_t label : tree.labels()) {
        if (round == 2 || random() % 3 == 0) wanted.push_back(label);
      }
      testing::DenseMask mask{dense.size, {}};
      for (const std::int32_t label : dense.voxels) {
        mask.voxels.push_back(label != 0 && std::ranges::count(wanted, label) != 0);
      }
      EXPECT_EQ(mask_of(tree, wanted), testing::tree_of(mask));
    }
  }
}

TEST(LabelTree, HasTheMomentsOfItsMasks) {
  for (const DenseLabels& dense : cases()) {
    const LabelTree tree = testing::tree_of(dense);
    const std::vector<MomentSums> moments = label_moments(tree);
    ASSERT_EQ(moments.size(), tree.labels().size());
    const std::vector<LabelMask> masks = masks_of(tree);
    auto mask = masks.begin();
    for (std::size_t i = 0; i < moments.size(); ++i) {
      const bool is_background = tree.labels()[i] == 0;
      const MomentSums expected = is_background ? MomentSums() : mask_moments((mask++)->tree);
      EXPECT_EQ(moments[i].count, expected.count);
      EXPECT_EQ(moments[i].box, expected.box);
      EXPECT_TRUE(moments[i].first == expected.first);
      EXPECT_TRUE(moments[i].second == expected.second);
    }
  }
}

TEST(LabelTree, OfAFileIsThatOfItsVoxelsAtEveryLevel) {
  std::mt19937 random(75);
  const testing::ScratchFolder folder;
  int number = 0;
  for (const Size3& size : {Size3{5, 3, 7}, Size3{130, 67, 21}, Size3{200, 70, 70}}) {
    const std::string path = folder.file(std::to_string(number++) + ".8vo");
    DenseLabels dense = random_labels(size, 12, random);
    dense.fill({{64, 0, 0}, {size.x, size.y, size.z}}, 3);  // bricks of one label
    testing::build_volume(testing::volume_of(dense, number == 2 ? 4 : 1), path, 2);
    const auto reader = testing::open_file(path);
    for (int level = 0; level < reader->levels().count(); ++level) {
      DenseLabels samples(reader->levels().size(level));
      reader->read(box_of(samples.size), level, samples.voxels.data());
      NoProgress progress;
      const LabelTree tree = labels_of_file(*reader, level, kAll, progress);
      ASSERT_TRUE(is_valid(tree));
      EXPECT_EQ(tree, testing::tree_of(samples));
      const std::vector<ValueWindow> windows = {{-1, 1}, {3, 3}};
      for (std::int32_t& label : samples.voxels) {
        if (label != -1 && label != 1 && label != 3) label = 0;
      }
      EXPECT_EQ(labels_of_file(*reader, level, windows, progress), testing::tree_of(samples));
    }
  }
}

TEST(LabelTree, DoesNotDependOnThreads) {
  std::mt19937 random(76);
  const DenseLabels dense = random_labels({150, 140, 135}, 40, random);
  const LabelTree tree = testing::tree_of(dense);
  const std::vector<LabelMask> masks = masks_of(tree);
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena(threads).execute([&] {
      EXPECT_EQ(testing::tree_of(dense), tree);
      EXPECT_EQ(labels_of_masks(dense.size, masks), tree);
      const std::vector<LabelMask> again = masks_of(tree);
      ASSERT_EQ(again.size(), masks.size());
      for (std::size_t i = 0; i < masks.size(); ++i) EXPECT_EQ(again[i].tree, masks[i].tree);
    });
  }
}

TEST(LabelTree, OfOneLabelIsLittleLargerThanItsMask) {
  testing::DenseMask ball{{200, 200, 200}, std::vector<std::uint8_t>(200 * 200 * 200)};
  DenseLabels labels(ball.size);
  testing::for_each_voxel(ball.size, [&](const Index3& p) {
    const std::int64_t r2 =
        (p.x - 100) * (p.x - 100) + (p.y - 100) * (p.y - 100) + (p.z - 100) * (p.z - 100);
    ball.at(p) = r2 < 90 * 90;
    labels.at(p) = r2 < 90 * 90 ? 123456 : 0;
  });
  const std::uint64_t mask_bytes = testing::tree_of(ball).memory_bytes();
  const std::uint64_t label_bytes = testing::tree_of(labels).memory_bytes();
  EXPECT_LT(static_cast<double>(label_bytes), 1.25 * static_cast<double>(mask_bytes));
  EXPECT_LT(label_bytes, 400'000u);  // of 32 MB
}

TEST(LabelTree, OfALargeVolumeCostsWhatIsInIt) {
  const Size3 size{1 << 21, 1 << 21, 1 << 20};
  std::vector<LabelMask> masks;
  masks.push_back({7, box_mask(size, {{5, 6, 7}, {9, 9, 9}})});
  masks.push_back({-3, box_mask(size, {{size.x - 5, 0, size.z - 1}, {size.x, 66, size.z}})});
  const LabelTree tree = labels_of_masks(size, masks);
  EXPECT_TRUE(is_valid(tree));
  EXPECT_LT(tree.memory_bytes(), 20'000u);
  EXPECT_EQ(tree.label_at({5, 6, 7}), 7);
  EXPECT_EQ(tree.label_at({size.x - 1, 65, size.z - 1}), -3);
  const std::vector<std::uint64_t> counts = voxel_counts(tree);
  EXPECT_EQ(counts,
            (std::vector<std::uint64_t>{5 * 66, (std::uint64_t{1} << 62) - 5 * 66 - 24, 24}));
}

TEST(LabelTree, IsProvenInEveryArray) {
  std::mt19937 random(77);
  const DenseLabels dense = random_labels({90, 70, 20}, 30, random);
  const LabelTree tree = testing::tree_of(dense);
  ASSERT_GT(tree.arrays().planes[1].size(), 0u);
  const std::vector<std::function<void(LabelArrays&)>> faults = {
      [](LabelArrays& a) { a.labels.push_back(a.labels.back() + 1); },
      [](LabelArrays& a) { std::swap(a.labels[0], a.labels[1]); },
      [](LabelArrays& a) { a.cubes[0].pop_back(); },
      [](LabelArrays& a) { a.cubes[0].front().mixed ^= 1; },
      [](LabelArrays& a) { a.cubes[0].front().starts = 0; },
      [](LabelArrays& a) { a.cubes[0].front().first += 1; },
      [](LabelArrays& a) { a.cubes[1].front().first_value += 1; },
      [](LabelArrays& a) { a.values[1] = PackedNumbers(a.values[1].size(), 0); },
      [](LabelArrays& a) { a.planes[0].front() = 0; },
      [](LabelArrays& a) { a.planes[0].push_back(5); },
      [](LabelArrays& a) { a.planes[1].pop_back(); },
      [](LabelArrays& a) { a.deeper[0] = {}; },
      [](LabelArrays& a) { a.palettes = PackedNumbers(a.palettes.size(), 0); },
      [](LabelArrays& a) { a.palette_starts[1] += 1; },
      [](LabelArrays& a) { a.palette_labels = PackedNumbers(a.palette_labels.size(), 0); },
  };
  for (std::size_t i = 0; i < faults.size(); ++i) {
    LabelArrays arrays = tree.arrays();
    faults[i](arrays);
    EXPECT_FALSE(is_valid(LabelTree(dense.size, std::move(arrays)))) << "fault " << i;
  }
  // Voxels outside the volume.
  const LabelTree ones = testing::tree_of(DenseLabels({90, 70, 20}, 1));
  EXPECT_FALSE(is_valid(LabelTree({89, 70, 20}, ones.arrays())));
  EXPECT_TRUE(is_valid(LabelTree({3, 500, 1})));
}

TEST(LabelTree, WhatCannotBeIsRejected) {
  EXPECT_THROW(LabelTree({0, 4, 4}), Error);
  EXPECT_THROW(LabelTree({4, 4, (std::int64_t{1} << 21) + 1}), Error);
  const float voxel = 1;
  EXPECT_THROW(make_labels({&voxel, VoxelType::float32, {1, 1, 1}, 1, 1}), Error);
  const std::int8_t byte = 1;
  EXPECT_THROW(make_labels({&byte, VoxelType::int8, {1, 0, 1}, 1, 1}), Error);
  const Size3 size{20, 20, 20};
  std::vector<LabelMask> masks;
  masks.push_back({1, box_mask(size, {{0, 0, 0}, {9, 9, 9}})});
  masks.push_back({2, box_mask(size, {{8, 8, 8}, {10, 10, 10}})});
  EXPECT_THROW(labels_of_masks(size, masks), Error);  // share a voxel
  masks.pop_back();
  EXPECT_THROW(labels_of_masks({20, 20, 21}, masks), Error);
  masks.front().label = 0;
  EXPECT_THROW(labels_of_masks(size, masks), Error);
}

}  // namespace
}  // namespace octavo
