#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

#include "octavo/octree/condense.h"
#include "support/recursive_octree.h"

namespace octavo {
namespace {

using octavo::testing::DenseVolume;

OCode any_cube(int n) {
  const int level = *rc::gen::inRange(0, n + 1);
  const std::uint64_t count = cube_volume(n - level);
  // Ends of the range are as likely as its inside.
  const std::uint64_t code =
      *rc::gen::oneOf(rc::gen::inRange<std::uint64_t>(0, count), rc::gen::just<std::uint64_t>(0),
                      rc::gen::just(count - 1));
  return {level, code};
}

int any_universe() { return *rc::gen::inRange(0, kMaxUniverseLevel + 1); }

// Boxes of few values over each other: clusters of every size, at every alignment.
DenseVolume clustered_volume() {
  const auto axis = rc::gen::weightedOneOf<std::int64_t>(
      {{3, rc::gen::inRange<std::int64_t>(1, 20)}, {1, rc::gen::element<std::int64_t>(1, 8, 16)}});
  DenseVolume volume{{*axis, *axis, *axis}, {}};
  volume.voxels.assign(static_cast<std::size_t>(volume.size.voxel_count()), 0);
  const int box_count = *rc::gen::inRange(0, 12);
  for (int i = 0; i < box_count; ++i) {
    Box box;
    for (int a = 0; a < 3; ++a) {
      box.lo[a] = *rc::gen::inRange<std::int64_t>(0, volume.size[a]);
      box.hi[a] = *rc::gen::inRange<std::int64_t>(box.lo[a], volume.size[a]) + 1;
    }
    const std::int64_t value = *rc::gen::inRange<std::int64_t>(-2, 4);
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x)
          volume.voxels[static_cast<std::size_t>((z * volume.size.y + y) * volume.size.x + x)] =
              value;
  }
  return volume;
}

LinearOctree condense_dense(const DenseVolume& volume, const CondenseOptions& options) {
  const std::vector<std::int16_t> voxels(volume.voxels.begin(), volume.voxels.end());
  return condense(std::span<const std::int16_t>(voxels), volume.size, options);
}

CondenseOptions any_options() {
  CondenseOptions options;
  if (*rc::gen::arbitrary<bool>()) options.background = *rc::gen::inRange<std::int64_t>(-2, 4);
  if (*rc::gen::arbitrary<bool>()) options.flat = *rc::gen::inRange<std::int64_t>(0, 6);
  return options;
}

RC_GTEST_PROP(OCodeProperty, PositionGoesThereAndBack, ()) {
  const auto axis = rc::gen::inRange<std::int64_t>(0, std::int64_t{1} << 21);
  const Index3 p{*axis, *axis, *axis};
  RC_ASSERT(deinterleave(interleave(p)) == p);
}

RC_GTEST_PROP(OCodeProperty, CornerGoesThereAndBack, ()) {
  const OCode cube = any_cube(any_universe());
  RC_ASSERT(cube_at(corner_of(cube), cube.level) == cube);
}

RC_GTEST_PROP(OCodeProperty, ChildrenAreTheHalvesOfTheirParent, ()) {
  const OCode cube = parent_of(any_cube(*rc::gen::inRange(1, kMaxUniverseLevel)));
  for (int octant = 0; octant < 8; ++octant) {
    const OCode child = children_of(cube)[static_cast<std::size_t>(octant)];
    RC_ASSERT(parent_of(child) == cube);
    RC_ASSERT(octant_of(child) == octant);
    RC_ASSERT(contains(cube, child));
    RC_ASSERT(!contains(child, cube));
    RC_ASSERT(box_of(cube).contains(box_of(child)));
    RC_ASSERT(2 * box_of(child).size().x == box_of(cube).size().x);
  }
}

RC_GTEST_PROP(OCodeProperty, AncestorIsParentRepeated, ()) {
  const int n = any_universe();
  const OCode cube = any_cube(n);
  OCode up = cube;
  for (int level = cube.level; level <= n; ++level, up = parent_of(up)) {
    RC_ASSERT(ancestor_of(cube, level) == up);
    RC_ASSERT(contains(up, cube));
  }
}

RC_GTEST_PROP(OCodeProperty, NeighborOfANeighborIsTheCube, ()) {
  const int n = any_universe();
  const OCode cube = any_cube(n);
  const auto neighbors = neighbors_of(cube, n);
  for (std::size_t i = 0; i < neighbors.size(); ++i) {
    const Direction d = kDirections[i];
    RC_ASSERT(neighbors[i] == neighbor_of(cube, d, n));
    const Index3 p = deinterleave(cube.code);
    const std::int64_t side = cube_side(n - cube.level);
    const bool is_inside =
        box_of(Size3{side, side, side}).contains(Index3{p.x + d.x, p.y + d.y, p.z + d.z});
    RC_ASSERT(neighbors[i].has_value() == is_inside);
    if (is_inside) RC_ASSERT(neighbor_of(*neighbors[i], d.reversed(), n) == cube);
  }
}

RC_GTEST_PROP(OCodeProperty, TextGoesThereAndBack, ()) {
  const int n = any_universe();
  const OCode cube = any_cube(n);
  RC_ASSERT(to_mixed_octal(cube, n).size() == static_cast<std::size_t>(n));
  RC_ASSERT(parse_mixed_octal(to_mixed_octal(cube, n)) == cube);
  RC_ASSERT(parse_hierarchical(to_hierarchical(cube, n), n) == cube);
}

RC_GTEST_PROP(OCodeProperty, PostOrderIsThatOfTheText, ()) {
  const int n = any_universe();
  const OCode a = any_cube(n);
  const OCode b = any_cube(n);
  RC_ASSERT(is_before_in_post_order(a, b) == (to_mixed_octal(a, n) < to_mixed_octal(b, n)));
}

RC_GTEST_PROP(CondenseProperty, PlanesAndRecursionGiveTheSameOctree, ()) {
  const DenseVolume volume = clustered_volume();
  const CondenseOptions options = any_options();
  RC_ASSERT(condense_dense(volume, options) == octavo::testing::recursive_octree(volume, options));
}

RC_GTEST_PROP(CondenseProperty, OctreeIsSortedLinearAndComplete, ()) {
  const DenseVolume volume = clustered_volume();
  const CondenseOptions options = any_options();
  const LinearOctree octree = condense_dense(volume, options);
  const auto background = options.background ? std::count(volume.voxels.begin(),
                                                          volume.voxels.end(), *options.background)
                                             : 0;
  RC_ASSERT(is_sorted(octree));
  RC_ASSERT(is_linear(octree));
  RC_ASSERT(is_complete(octree, volume.voxels.size() - static_cast<std::size_t>(background)));
}

RC_GTEST_PROP(CondenseProperty, CondenseThenExpandIsIdentity, ()) {
  const DenseVolume volume = clustered_volume();
  CondenseOptions options = any_options();
  options.flat = 0;
  const LinearOctree octree = condense_dense(volume, options);
  RC_ASSERT(expand(octree, volume.size, options.background.value_or(99)) == volume.voxels);
}

RC_GTEST_PROP(CondenseProperty, FlatKeepsEveryVoxelWithinItsBound, ()) {
  const DenseVolume volume = clustered_volume();
  const std::int64_t flat = *rc::gen::inRange<std::int64_t>(0, 6);
  const LinearOctree octree = condense_dense(volume, {.flat = flat});
  const auto back = expand(octree, volume.size, 99);
  for (std::size_t i = 0; i < back.size(); ++i) {
    RC_ASSERT(std::abs(back[i] - volume.voxels[i]) <= flat);
  }
}

RC_GTEST_PROP(CondenseProperty, EveryLeafIsFoundFromItsVoxels, ()) {
  const DenseVolume volume = clustered_volume();
  const LinearOctree octree = condense_dense(volume, {.background = 0});
  Index3 p;
  for (int a = 0; a < 3; ++a) p[a] = *rc::gen::inRange<std::int64_t>(0, volume.size[a]);
  const auto at = static_cast<std::size_t>((p.z * volume.size.y + p.y) * volume.size.x + p.x);
  const auto leaf = find_leaf(octree, p);
  RC_ASSERT(leaf.has_value() == (volume.voxels[at] != 0));
  if (leaf) {
    RC_ASSERT(leaf->value == volume.voxels[at]);
    RC_ASSERT(box_of(leaf->cube).contains(p));
  }
}

}  // namespace
}  // namespace octavo
