#include "octavo/render/rays/layer_bricks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "octavo/render/rays/octree_nodes.h"
#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::CastScene;
using testing::cast_scene;
using testing::RaySetup;

constexpr std::int64_t kSide = 16;  // of a brick
constexpr Size3 kBricks = {5, 4, 5};
constexpr Size3 kSamples = {70, 60, 66};

/// Sheets in all directions, most of them close to faces of bricks, some far outside.
TriangleMesh sheets(std::mt19937& random) {
  TriangleMesh mesh;
  std::uniform_real_distribution<float> anywhere(-50, 120);
  std::uniform_real_distribution<float> near_a_face(-1.2f, 1.2f);
  for (std::uint32_t i = 0; i < 60; ++i) {
    const std::size_t across = i % 4;  // 3: none
    const float face = static_cast<float>(kSide) * static_cast<float>(random() % 6);
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      MeshPoint point = {anywhere(random), anywhere(random), anywhere(random)};
      if (across < 3) point[across] = face + near_a_face(random);
      mesh.points.push_back(point);
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// What each ray gathers of nodes one by one, each with the layers that are its own, composited in
/// their order.
class NodesOneByOne {
 public:
  NodesOneByOne(const testing::RayVolume<std::int16_t>& volume, const RaySetup& setup,
                const CastScene& whole, std::span<const RayRegion> regions)
      : volume_(volume), setup_(setup), whole_(whole), regions_(regions) {}

  void composite(const std::vector<OctreeNode>& nodes) {
    red_.assign(whole_.field.tiles.size() * kTileRays, 0);
    opacity_ = red_;
    for (const OctreeNode& node : nodes) {
      const std::vector<TileLayers> own = layers_of(node);
      RaySetup of_node = setup_;
      of_node.layers = own.data();
      of_node.regions = regions_in(node, regions_, kSide);
      of_node.keeps_order = true;
      add(cast_scene(volume_, of_node).field);
    }
  }

  double farthest_from_whole() const {
    double farthest = 0;
    for (std::size_t i = 0; i < red_.size(); ++i) {
      const RayTile& tile = whole_.field.tiles[i / kTileRays];
      farthest = std::max(farthest, std::abs(red_[i] - tile.red[i % kTileRays]));
      farthest = std::max(farthest, std::abs(opacity_[i] - tile.gathered[i % kTileRays]));
    }
    return farthest;
  }

  std::size_t layer_count() const { return layer_count_; }

 private:
  std::vector<TileLayers> layers_of(const OctreeNode& node) {
    // The tables of bricks are gone with the scene; what is asked of them is their shape.
    RayFrame frame = whole_.frame;
    frame.bricks.shift = 4;
    frame.bricks.grid = {static_cast<std::int32_t>(kBricks.x),
                         static_cast<std::int32_t>(kBricks.y),
                         static_cast<std::int32_t>(kBricks.z)};
    const LayerBricks bricks(frame, regions_);
    const std::vector<TileLayers>& all = whole_.field.layers;
    std::vector<TileLayers> own(all.size());
    for (std::size_t t = 0; t < all.size(); ++t) {
      const std::vector<std::int32_t> numbers =
          bricks.of_tile(all[t], first_pixel_of(t, whole_.field.width, whole_.field.height));
      for (std::size_t ray = 0; ray < kTileRays && !all[t].is_empty(); ++ray) {
        own[t].begins.push_back(static_cast<std::uint32_t>(own[t].layers.size()));
        for (std::uint32_t i = all[t].begins[ray]; i < all[t].begins[ray + 1]; ++i) {
          if (is_in(numbers[i], node)) own[t].layers.push_back(all[t].layers[i]);
        }
      }
      own[t].begins.push_back(static_cast<std::uint32_t>(own[t].layers.size()));
      layer_count_ += own[t].layers.size();
    }
    return own;
  }

  static bool is_in(std::int32_t brick, const OctreeNode& node) {
    const std::array<std::int64_t, 3> at = {brick % kBricks.x, brick / kBricks.x % kBricks.y,
                                            brick / (kBricks.x * kBricks.y)};
    for (const int axis : {0, 1, 2}) {
      const std::int64_t place = at[static_cast<std::size_t>(axis)];
      if (place < node.lo[axis] || place >= node.lo[axis] + node.side) return false;
    }
    return true;
  }

  void add(const RayField& behind) {
    for (std::size_t i = 0; i < red_.size(); ++i) {
      const RayTile& tile = behind.tiles[i / kTileRays];
      red_[i] += (1 - opacity_[i]) * static_cast<double>(tile.red[i % kTileRays]);
      opacity_[i] += (1 - opacity_[i]) * static_cast<double>(tile.gathered[i % kTileRays]);
    }
  }

  const testing::RayVolume<std::int16_t>& volume_;
  const RaySetup& setup_;
  const CastScene& whole_;
  std::span<const RayRegion> regions_;
  std::vector<double> red_;
  std::vector<double> opacity_;
  std::size_t layer_count_ = 0;
};

TEST(LayerBricks, NodesWithTheirOwnLayersAreTheWholeInOrder) {
  std::mt19937 random(11);
  // Opaque in few steps, so that a layer on the wrong side of one is seen; without gradients, so
  // that light does not depend on what lies in front.
  const auto fog =
      testing::ray_volume<std::int16_t>(kSamples, [](auto, auto, auto) { return 250; });
  const TriangleMesh mesh = sheets(random);
  const std::vector<MeshPoint> normals(mesh.points.size(), MeshPoint{0, -1, 0});
  std::vector<bool> is_seen(static_cast<std::size_t>(kBricks.voxel_count()), true);
  for (const double azimuth : {0.0, 37.0, 225.0}) {
    for (const double angle : {0.0, 70.0}) {
      for (const bool has_hole : {false, true}) {
        RaySetup setup;
        setup.brick_shift = 4;
        setup.transfer = {{{150, {30, 30, 30}, 0}, {400, {60, 50, 40}, 0.5}}, {}, false};
        setup.enough = 2;
        setup.viewpoint = viewpoint_at(azimuth, azimuth == 0 ? 0 : 25);
        setup.angle_degrees = angle;
        setup.meshes = {{&mesh, normals, {255, 0, 0}, 0.5}};
        setup.shown = Box{{3, 0, 5}, {64, 60, 66}};
        if (has_hole) setup.removed = {{{30, 10, 20}, {50, 40, 66}}};
        const CastScene whole = cast_scene(fog, setup);
        std::vector<RayRegion> regions;
        for (const Box& box : without_boxes(*setup.shown, setup.removed)) {
          regions.push_back(region_of(box));
        }
        regions = front_to_back(regions, whole.frame);
        NodesOneByOne nodes(fog, setup, whole, regions);
        nodes.composite(nodes_in_order(share_octree(kBricks, is_seen, 9), whole.frame, kSide));
        std::size_t all = 0;
        for (const TileLayers& tile : whole.field.layers) all += tile.layers.size();
        EXPECT_EQ(nodes.layer_count(), all);
        EXPECT_LT(nodes.farthest_from_whole(), 2e-5) << azimuth << ' ' << angle << has_hole;
      }
    }
  }
}

}  // namespace
}  // namespace octavo
