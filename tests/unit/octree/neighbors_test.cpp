#include "octavo/octree/neighbors.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "octavo/octree/condense.h"

namespace octavo {
namespace {

/// Boxes of four labels in a background of 0.
std::vector<std::int16_t> random_labels(const Size3& size, std::mt19937& random) {
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  const auto below = [&](std::int64_t n) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
  };
  for (int boxes = 0; boxes < 8; ++boxes) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = below(2) == 0 ? 0 : below(size[axis]);
      box.hi[axis] = box.lo[axis] + 1 + below(size[axis] - box.lo[axis]);
    }
    const auto label = static_cast<std::int16_t>(below(5));
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x)
          voxels[static_cast<std::size_t>((z * size.y + y) * size.x + x)] = label;
  }
  return voxels;
}

/// The leaf over every voxel of the universe, as its place in a list; -1 for background.
class LeafMap {
 public:
  explicit LeafMap(const LinearOctree& octree)
      : leaves_(leaves_in_post_order(octree)), side_(cube_side(octree.root_level)) {
    over_.assign(static_cast<std::size_t>(side_ * side_ * side_), -1);
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      for_each_voxel(box_of(leaves_[i].cube), [&](std::size_t voxel) {
        over_[voxel] = static_cast<int>(i);
      });
    }
  }

  const std::vector<Leaf>& leaves() const { return leaves_; }

  Neighbor beside(const OCode& cube, const Direction& d) const {
    const std::int64_t step = cube_side(cube.level);
    Box box = box_of(cube);
    const Index3 by{d.x * step, d.y * step, d.z * step};
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] += by[axis];
      box.hi[axis] += by[axis];
    }
    if (!Box{{0, 0, 0}, {side_, side_, side_}}.contains(box)) return {};
    std::set<int> met;
    for_each_voxel(box, [&](std::size_t voxel) { met.insert(over_[voxel]); });
    const int first = *met.begin();
    if (met.size() > 1) return {NeighborKind::smaller, {}};
    if (first < 0) return {NeighborKind::background, {}};
    return {NeighborKind::leaf, leaves_[static_cast<std::size_t>(first)]};
  }

 private:
  template <class F>
  void for_each_voxel(const Box& box, const F& take) const {
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x)
          take(static_cast<std::size_t>((z * side_ + y) * side_ + x));
  }

  std::vector<Leaf> leaves_;
  std::int64_t side_;
  std::vector<int> over_;
};

TEST(NeighborIn, IsWhatLiesThereForEveryLeafAndAnyCube) {
  std::mt19937 random(1);
  for (const Size3& size : {Size3{1, 1, 1}, Size3{2, 2, 2}, Size3{8, 8, 8}, Size3{9, 5, 13},
                            Size3{16, 11, 3}, Size3{17, 17, 6}}) {
    for (int turn = 0; turn < 6; ++turn) {
      const std::vector<std::int16_t> voxels = random_labels(size, random);
      CondenseOptions options;
      options.background = 0;
      const LinearOctree octree = condense<std::int16_t>(voxels, size, options);
      const LeafMap map(octree);
      const auto expect_all = [&](const OCode& cube) {
        const std::array<Neighbor, 26> found = neighbors_in(octree, cube);
        for (std::size_t i = 0; i < found.size(); ++i) {
          ASSERT_EQ(found[i], map.beside(cube, kDirections[i])) << to_mixed_octal(
              cube, octree.root_level) << " direction " << i;
        }
        ASSERT_EQ(leaf_at(octree, cube), map.beside(cube, {0, 0, 0}))
            << to_mixed_octal(cube, octree.root_level);
      };
      for (const Leaf& leaf : map.leaves()) expect_all(leaf.cube);
      for (int level = 0; level <= octree.root_level; ++level) {
        for (int i = 0; i < 10; ++i) {
          expect_all({level, random() % cube_volume(octree.root_level - level)});
        }
      }
    }
  }
}

TEST(NeighborIn, FindsTheLargerLeafAndTellsSmallerOnesFromNone) {
  // Universe of side 4: a cube of side 2 at the origin; of the cube beyond it along x one voxel.
  LinearOctree octree = empty_octree(2);
  octree.levels[1] = {{00}, {7}};
  octree.levels[0] = {{021}, {5}};
  const Neighbor larger = neighbor_in(octree, {0, 020}, {-1, 0, 0});
  EXPECT_EQ(larger, (Neighbor{NeighborKind::leaf, {{1, 0}, 7}}));
  EXPECT_EQ(neighbor_in(octree, {1, 0}, {1, 0, 0}).kind, NeighborKind::smaller);
  EXPECT_EQ(neighbor_in(octree, {1, 0}, {0, 1, 0}).kind, NeighborKind::background);
  EXPECT_EQ(neighbor_in(octree, {1, 0}, {0, -1, 0}).kind, NeighborKind::outside);
  EXPECT_EQ(neighbor_in(octree, {2, 0}, {1, 1, 1}).kind, NeighborKind::outside);
}

}  // namespace
}  // namespace octavo
