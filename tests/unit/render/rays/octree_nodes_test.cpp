#include "octavo/render/rays/octree_nodes.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::cast_scene;
using testing::noisy_ball;
using testing::RaySetup;

std::vector<bool> random_bricks(const Size3& grid, std::mt19937& random) {
  std::vector<bool> is_seen;
  for (std::int64_t i = 0; i < grid.voxel_count(); ++i) is_seen.push_back(random() % 3 == 0);
  return is_seen;
}

TEST(OctreeNodes, HoldEveryBrickOnceAndRanksHaveAsMuch) {
  std::mt19937 random(3);
  for (const Size3 grid : {Size3{1, 1, 1}, Size3{8, 8, 8}, Size3{5, 9, 3}}) {
    for (const int ranks : {1, 2, 3, 7, 600}) {
      const std::vector<bool> is_seen = random_bricks(grid, random);
      const std::vector<OctreeNode> nodes = share_octree(grid, is_seen, ranks);
      std::vector<int> seen_of(static_cast<std::size_t>(ranks));
      std::set<std::size_t> held;
      for (const OctreeNode& node : nodes) {
        for (const int axis : {0, 1, 2}) EXPECT_EQ(node.lo[axis] % node.side, 0);
        const Box box = intersection(
            box_of(grid), {node.lo, {node.lo.x + node.side, node.lo.y + node.side,
                                     node.lo.z + node.side}});
        visit_cells(box, {1, 1, 1}, [&](const Index3& brick) {
          const auto i = static_cast<std::size_t>((brick.z * grid.y + brick.y) * grid.x + brick.x);
          EXPECT_TRUE(held.insert(i).second);
          if (is_seen[i]) ++seen_of[static_cast<std::size_t>(node.rank)];
          return true;
        });
      }
      EXPECT_EQ(held.size(), static_cast<std::size_t>(grid.voxel_count()));
      if (grid.x == 8 && ranks < 8) {
        const auto [lowest, highest] = std::minmax_element(seen_of.begin(), seen_of.end());
        EXPECT_LE(*highest - *lowest, 12);
      }
      if (ranks == 1) {
        EXPECT_EQ(nodes.size(), 1u);
      }
    }
  }
}

TEST(OctreeNodes, CrossedInOrderGiveTheWholeBitForBit) {
  const auto ball = noisy_ball(70);
  std::mt19937 random(5);
  const Size3 grid{5, 5, 5};  // bricks of 16^3
  for (const double azimuth : {20.0, 200.0}) {
    for (const double angle : {0.0, 60.0}) {
      RaySetup setup;
      setup.brick_shift = 4;
      setup.viewpoint = viewpoint_at(azimuth, -35);
      setup.angle_degrees = angle;
      const auto whole = cast_scene(ball, setup);
      std::vector<OctreeNode> nodes = share_octree(grid, random_bricks(grid, random), 5);
      std::shuffle(nodes.begin(), nodes.end(), random);
      for (const OctreeNode& node : nodes_in_order(nodes, whole.frame, 16)) {
        const RayRegion all = region_of(box_of(ball.size));
        for (const RayRegion& region : regions_in(node, {&all, 1}, 16)) {
          setup.regions.push_back(region);
        }
      }
      setup.keeps_order = true;
      EXPECT_TRUE(testing::gathered(cast_scene(ball, setup).field) ==
                  testing::gathered(whole.field))
          << azimuth << ' ' << angle;
    }
  }
}

}  // namespace
}  // namespace octavo
