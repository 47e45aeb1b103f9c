#include "octavo/render/cubes/cube_traversal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <random>

#include "octavo/octree/linear_octree.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

/// A view whose places are indices.
View index_view(const std::array<int, 3>& nearness) {
  View view;
  view.axes = {Place{1, 0, 0}, Place{0, 1, 0}, Place{0, 0, 1}};
  view.nearness = nearness;
  return view;
}

struct DrawnLeaf {
  std::size_t mask = 0;
  Box box;
};

/// Keeps all leaves in the order in which they come.
struct Recorder {
  std::vector<DrawnLeaf> leaves;

  bool misses(const Place&, int) const { return false; }
  void draw(std::size_t mask, const Place& at, int level, unsigned) {
    const std::int64_t side = cube_side(level);
    leaves.push_back({mask, {{at.x, at.y, at.depth}, {at.x + side, at.y + side, at.depth + side}}});
  }
};

std::vector<DrawnLeaf> visited(const std::vector<MaskTree>& masks,
                               const std::array<int, 3>& nearness,
                               TraversalOrder order = TraversalOrder::farthest_first) {
  std::vector<const MaskTree*> pointers;
  for (const MaskTree& mask : masks) pointers.push_back(&mask);
  Recorder recorder;
  CubeTraversal(pointers, index_view(nearness), order, recorder).run();
  return recorder.leaves;
}

/// Whether `front`, moved away from the viewer along `direction`, runs into `back`.
bool hides(const Box& front, const Box& back, const std::array<int, 3>& direction) {
  double first = 0;
  double last = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const int step = direction[static_cast<std::size_t>(axis)];
    const auto low = static_cast<double>(front.lo[axis] - back.hi[axis]);
    const auto high = static_cast<double>(front.hi[axis] - back.lo[axis]);
    if (step == 0) {
      if (low >= 0 || high <= 0) return false;
      continue;
    }
    first = std::max(first, std::min(low / step, high / step));
    last = std::min(last, std::max(low / step, high / step));
  }
  return last > first;
}

/// Splits a random mask among `count` disjoint ones, in boxes and single voxels.
std::vector<MaskTree> random_masks(const Size3& size, int count, std::mt19937& random) {
  const DenseMask all = testing::random_mask(size, random);
  const DenseMask split = testing::random_mask(size, random);
  std::vector<MaskTree> masks;
  for (int i = 0; i < count; ++i) {
    DenseMask one = all;
    testing::for_each_voxel(size, [&](const Index3& p) {
      const int owner = count == 1 ? 0 : split.at(p) != 0 ? static_cast<int>(p.x / 5 % count) : 0;
      if (owner != i) one.at(p) = 0;
    });
    masks.push_back(testing::tree_of(one));
  }
  return masks;
}

const std::vector<std::array<int, 3>>& directions() {
  static const std::vector<std::array<int, 3>> all = {
      {1, 1, 1}, {-1, 2, 3}, {3, -1, -2}, {-1, -1, -1}, {0, 0, 1}, {0, -1, 0}, {1, 0, -2}};
  return all;
}

std::array<int, 3> signs_of(const std::array<int, 3>& direction) {
  std::array<int, 3> signs{};
  for (std::size_t i = 0; i < 3; ++i) signs[i] = (direction[i] > 0) - (direction[i] < 0);
  return signs;
}

TEST(CubeTraversal, OctantsComeInTheGroupsOfTheThesis) {
  EXPECT_EQ(octants_back_to_front({1, 1, 1}), (std::array<int, 8>{0, 1, 2, 4, 3, 5, 6, 7}));
  EXPECT_EQ(octants_back_to_front({-1, -1, -1}), (std::array<int, 8>{7, 6, 5, 3, 4, 2, 1, 0}));
  for (int x : {-1, 1})
    for (int y : {-1, 1})
      for (int z : {-1, 1}) {
        const auto order = octants_back_to_front({x, y, z});
        const int nearest = (z > 0 ? 4 : 0) | (x > 0 ? 2 : 0) | (y > 0 ? 1 : 0);
        EXPECT_EQ(order[7], nearest);
        EXPECT_EQ(order[0], 7 - nearest);
        for (std::size_t i = 1; i < 4; ++i)
          EXPECT_EQ(std::popcount(unsigned(order[i] ^ order[0])), 1);
        for (std::size_t i = 4; i < 7; ++i)
          EXPECT_EQ(std::popcount(unsigned(order[i] ^ order[7])), 1);
      }
}

TEST(CubeTraversal, TakesEveryLeafOnceWithItsMask) {
  std::mt19937 random(5);
  for (const Size3& size : testing::odd_sizes()) {
    for (const int count : {1, 2, 5}) {
      const std::vector<MaskTree> masks = random_masks(size, count, random);
      std::map<std::pair<std::size_t, std::pair<int, std::uint64_t>>, int> found;
      for (const DrawnLeaf& leaf : visited(masks, {1, -1, 1})) {
        const int level = std::countr_zero(static_cast<std::uint64_t>(leaf.box.size().x));
        ++found[{leaf.mask, {level, cube_at(leaf.box.lo, level).code}}];
      }
      std::size_t leaves = 0;
      for (std::size_t mask = 0; mask < masks.size(); ++mask) {
        const LinearOctree octree = to_linear_octree(masks[mask]);
        for (std::size_t level = 0; level < octree.levels.size(); ++level) {
          for (const std::uint64_t code : octree.levels[level].codes) {
            EXPECT_EQ((found[{mask, {static_cast<int>(level), code}}]), 1);
            ++leaves;
          }
        }
      }
      EXPECT_EQ(found.size(), leaves);
    }
  }
}

TEST(CubeTraversal, NoCubeIsDrawnAfterOneThatHidesIt) {
  std::mt19937 random(6);
  for (const Size3& size : {Size3{9, 14, 11}, Size3{33, 7, 18}, Size3{65, 9, 6}}) {
    for (const int count : {1, 3}) {
      const std::vector<MaskTree> masks = random_masks(size, count, random);
      for (const auto& direction : directions()) {
        const std::vector<DrawnLeaf> leaves = visited(masks, signs_of(direction));
        const std::size_t most = std::min<std::size_t>(leaves.size(), 1500);
        for (std::size_t late = 0; late < most; ++late) {
          for (std::size_t early = 0; early < late; ++early) {
            ASSERT_FALSE(hides(leaves[early].box, leaves[late].box, direction));
          }
        }
      }
    }
  }
}

TEST(CubeTraversal, AFullUniverseIsOneLeaf) {
  const std::vector<MaskTree> masks = {box_mask({64, 64, 64}, {{0, 0, 0}, {64, 64, 64}})};
  const auto leaves = visited(masks, {1, 1, 1});
  ASSERT_EQ(leaves.size(), 1u);
  EXPECT_EQ(leaves[0].box, (Box{{0, 0, 0}, {64, 64, 64}}));
  EXPECT_TRUE(visited({MaskTree({70, 3, 3})}, {1, 1, 1}).empty());
  EXPECT_TRUE(visited({}, {1, 1, 1}).empty());
}

}  // namespace
}  // namespace octavo
