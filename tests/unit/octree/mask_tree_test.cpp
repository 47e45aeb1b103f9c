#include "octavo/octree/mask_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <utility>
#include <vector>

namespace octavo {
namespace {

MaskArrays arrays_of(const MaskTree& tree) {
  MaskArrays arrays;
  arrays.words.assign(tree.words().begin(), tree.words().end());
  for (int rank = 0; rank < tree.rank_count(); ++rank) {
    arrays.cubes.emplace_back(tree.cubes(rank).begin(), tree.cubes(rank).end());
  }
  return arrays;
}

// Words, cubes of 16^3 and a root of 64^3, all of them mixed.
constexpr Size3 kSize{40, 40, 40};
MaskTree sample() { return box_mask(kSize, {{1, 2, 3}, {38, 39, 40}}); }

TEST(MaskTree, EveryBrokenInvariantIsFound) {
  ASSERT_TRUE(is_valid(sample()));
  ASSERT_TRUE(is_valid(MaskTree(kSize, arrays_of(sample()))));
  const struct {
    const char* what;
    std::function<void(MaskArrays&)> damage;
  } cases[] = {
      {"a rank too many", [](MaskArrays& a) { a.cubes.push_back({a.cubes.back().front()}); }},
      {"two roots", [](MaskArrays& a) { a.cubes.back().emplace_back(); }},
      {"no root", [](MaskArrays& a) { a.cubes.back().clear(); }},
      {"full and mixed", [](MaskArrays& a) { a.cubes[1][0].full |= a.cubes[1][0].mixed; }},
      {"children that begin elsewhere", [](MaskArrays& a) { ++a.cubes[0][1].first; }},
      {"children beyond the words", [](MaskArrays& a) { a.words.pop_back(); }},
      {"children beyond the cubes", [](MaskArrays& a) { a.cubes[0].pop_back(); }},
      {"words of nobody", [](MaskArrays& a) { a.words.push_back(1); }},
      {"cubes of nobody", [](MaskArrays& a) { a.cubes[0].push_back({1, 0, a.words.size()}); }},
      {"a stored empty word", [](MaskArrays& a) { a.words[3] = 0; }},
      {"a stored full word", [](MaskArrays& a) { a.words[3] = kFullWord; }},
      {"a stored empty cube", [](MaskArrays& a) { a.cubes[0][0] = {0, 0, 0}; }},
      {"a stored full cube", [](MaskArrays& a) { a.cubes[0][0] = {kFullWord, 0, 0}; }},
      {"voxels behind the volume", [](MaskArrays& a) { a.cubes[1][0].full |= 1ull << 63; }},
      {"voxels beside the volume",
       [](MaskArrays& a) { a.cubes[1][0].full |= 1ull << interleave({3, 0, 0}); }},
  };
  for (const auto& c : cases) {
    MaskArrays arrays = arrays_of(sample());
    c.damage(arrays);
    EXPECT_FALSE(is_valid(MaskTree(kSize, std::move(arrays)))) << c.what;
  }
}

TEST(MaskTree, AFullUniverseIsOneLeaf) {
  for (int n = 0; n <= 8; ++n) {
    const std::int64_t side = cube_side(n);
    const MaskTree full = box_mask({side, side, side}, {{0, 0, 0}, {side, side, side}});
    ASSERT_TRUE(is_valid(full)) << n;
    EXPECT_EQ(full.voxel_count(), cube_volume(n));
    LinearOctree root = empty_octree(n);
    root.levels.back() = {{0}, {5}};
    EXPECT_EQ(to_linear_octree(full, 5), root) << n;
    EXPECT_EQ(leaf_counts(full).back(), 1) << n;
    std::vector<std::uint8_t> voxels(8, 7);
    if (n == 0) continue;
    fill_voxels(full, {{side - 2, side - 2, side - 2}, {side, side, side}}, voxels.data());
    EXPECT_EQ(voxels, std::vector<std::uint8_t>(8, 1)) << n;
  }
}

TEST(MaskTree, ContainsTheVoxelsItIsMadeOf) {
  const Box box{{1, 2, 3}, {38, 39, 40}};
  const MaskTree tree = box_mask(kSize, box);
  for (std::int64_t z = -1; z <= 41; ++z) {
    for (std::int64_t y = -1; y <= 41; ++y) {
      for (std::int64_t x = -1; x <= 41; ++x) {
        ASSERT_EQ(tree.contains({x, y, z}), box.contains(Index3{x, y, z}));
      }
    }
  }
  EXPECT_FALSE(tree.contains({64, 2, 3}));
  // Two rows, half of each beyond the box.
  std::vector<std::uint8_t> voxels(4, 7);
  fill_voxels(tree, {{37, 38, 38}, {39, 39, 40}}, voxels.data());
  EXPECT_EQ(voxels, (std::vector<std::uint8_t>{1, 0, 1, 0}));
  EXPECT_EQ(tree.voxel_count(), 37u * 37 * 37);
  EXPECT_GE(tree.memory_bytes(),
            tree.words().size_bytes() + tree.cubes(0).size_bytes() + tree.cubes(1).size_bytes());
}

TEST(MaskTree, FillsAnyBox) {
  const Size3 size{64, 64, 64};
  std::mt19937_64 random(29);
  MaskArrays arrays = arrays_of(box_mask(size, {{1, 2, 3}, {61, 39, 62}}));
  for (std::uint64_t& word : arrays.words) word = random() | 1;  // not one is empty or full
  const MaskTree tree(size, std::move(arrays));
  ASSERT_TRUE(is_valid(tree));
  for (int round = 0; round < 200; ++round) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = static_cast<std::int64_t>(random() % 60);
      box.hi[axis] = std::min<std::int64_t>(
          size[axis], box.lo[axis] + 1 + static_cast<std::int64_t>(random() % 24));
    }
    const Size3 shape = box.size();
    std::vector<std::int16_t> voxels(static_cast<std::size_t>(shape.voxel_count()), 77);
    fill_voxels(tree, box, voxels.data());
    std::size_t at = 0;
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
          ASSERT_EQ(voxels[at++] != 0, tree.contains({x, y, z}));
        }
      }
    }
  }
}

TEST(MaskTree, OfNothingIsEmptyAndTakesNoWords) {
  for (const Box& box : {Box{}, Box{{40, 0, 0}, {50, 9, 9}}, Box{{3, 3, 3}, {9, 3, 9}}}) {
    const MaskTree tree = box_mask(kSize, box);
    EXPECT_TRUE(tree.is_empty());
    EXPECT_EQ(tree, MaskTree(kSize));
    EXPECT_EQ(tree.voxel_count(), 0u);
    EXPECT_TRUE(tree.words().empty());
  }
}

TEST(BoxOfChildren, IsTheSmallestAroundThem) {
  const Index3 corner{64, 128, 16};
  EXPECT_TRUE(box_of_children(0, corner, 4).is_empty());
  for (int a = 0; a < 64; ++a) {
    for (int b = 0; b < 64; ++b) {
      const std::uint64_t bits = std::uint64_t{1} << a | std::uint64_t{1} << b;
      EXPECT_EQ(box_of_children(bits, corner, 4),
                united(child_box(corner, a, 4), child_box(corner, b, 4)));
    }
  }
}

}  // namespace
}  // namespace octavo
