#include "octavo/render/rays/occupied_spans.h"

#include <gtest/gtest.h>

#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::gathered;
using testing::ray_volume;
using testing::RayVolume;

/// A ball and a speck far from it, in a volume that is empty besides.
RayVolume<std::int16_t> ball_and_speck() {
  const auto value_of = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto square = [](std::int64_t a) { return a * a; };
    const bool is_speck = x == 84 && y == 57 && z == 70;
    return is_speck || square(x - 30) + square(y - 25) + square(z - 30) < 14 * 14 ? 300 : 0;
  };
  auto volume = ray_volume<std::int16_t>({90, 61, 75}, value_of);
  volume.geometry.spacing_mm = {0.8, 1, 1.3};
  return volume;
}

TransferFunction white_to_brown() {
  return {{{150, {255, 255, 255}, 0}, {400, {200, 150, 100}, 0.3}}, {}, false, {}};
}

/// A scene whose bricks stay in memory from picture to picture.
class KeptScene {
 public:
  KeptScene(const RayVolume<std::int16_t>& volume, RayMode mode, double angle, double zoom,
            bool skips)
      : source_(volume.samples.data(), VoxelType::int16, volume.size, 32),
        bricks_(source_, {5, std::uint64_t{1} << 30, nullptr}),
        table_(white_to_brown(), {}, bricks_.scale(), bricks_.range(), 1) {
    const View view = make_view(volume.geometry, volume.size, box_of(volume.size),
                                viewpoint_at(30, 20), {kWidth, kHeight, zoom, {}});
    frame_.mode = mode;
    frame_.bricks = bricks_.tables();
    frame_.isovalue = 225.5f;
    frame_.table = table_.table();
    set_camera(frame_, {view, box_of(volume.size), angle, 0.8, zoom});
    bricks_.set_bounds([this, skips](float lowest, float highest) {
      if (!skips) return 1.0f;
      const bool is_seen = frame_.mode == RayMode::iso ? highest >= frame_.isovalue
                                                       : table_.is_seen(lowest, highest);
      return is_seen ? 1.0f : 0.0f;
    });
  }

  RayField draw(FollowRays follow = follow_rays_function()) {
    NoProgress silent;
    return cast_rays(bricks_, frame_, kWidth, kHeight, follow, silent);
  }

  OccupiedSpans spans() {
    frame_.bricks = bricks_.tables();
    return {frame_, kWidth, kHeight};
  }

  static constexpr std::int64_t kWidth = 150;
  static constexpr std::int64_t kHeight = 131;

 private:
  DenseSamples source_;
  RayBricks bricks_;
  TransferTable table_;
  RayFrame frame_;
};

TEST(OccupiedSpans, ChangeNoBitOfAPictureWhoseBricksAreInMemory) {
  const auto volume = ball_and_speck();
  for (const RayMode mode : {RayMode::volume, RayMode::iso}) {
    for (const double angle : {0.0, 40.0, 110.0}) {
      for (const double zoom : {0.4, 1.0, 6.0}) {  // 6: the eye is inside
        KeptScene skipping(volume, mode, angle, zoom, true);
        skipping.draw();
        KeptScene taking(volume, mode, angle, zoom, false);
        const std::vector<float> expected = gathered(taking.draw(follow_rays_portable));
        EXPECT_EQ(gathered(skipping.draw()), expected) << angle << " " << zoom;
      }
    }
  }
}

TEST(OccupiedSpans, HoldEveryHitAndLeaveMostTilesOut) {
  const auto volume = ball_and_speck();
  KeptScene scene(volume, RayMode::iso, 0, 1, true);
  scene.draw();
  const RayField field = scene.draw();
  const OccupiedSpans spans = scene.spans();
  std::size_t hits = 0;
  std::size_t occupied_tiles = 0;
  for (std::size_t tile = 0; tile < field.tiles.size(); ++tile) {
    if (spans.is_any_in(tile)) ++occupied_tiles;
    for (std::size_t ray = 0; ray < kTileRays; ++ray) {
      if (!(field.tiles[tile].gathered[ray] > 0)) continue;
      ++hits;
      const OccupiedSpan& span = spans.of_tile(tile)[ray / kSpanRays];
      EXPECT_LE(span.first, field.tiles[tile].blue[ray]);
      EXPECT_GE(span.last, field.tiles[tile].blue[ray]);
      EXPECT_LT(span.last - span.first, 80);  // of 170 through the volume
    }
  }
  EXPECT_GT(hits, 500u);
  EXPECT_LT(occupied_tiles, field.tiles.size() * 2 / 3);
}

TEST(OccupiedSpans, CountBricksThatAreNotInMemoryAsAWhole) {
  const auto volume = ball_and_speck();
  KeptScene scene(volume, RayMode::iso, 0, 1, true);
  const OccupiedSpans before = scene.spans();
  scene.draw();
  const OccupiedSpans after = scene.spans();
  bool is_narrower = false;
  const std::size_t tiles =
      ray_field_bytes(KeptScene::kWidth, KeptScene::kHeight) / sizeof(RayTile);
  for (std::size_t i = 0; i < tiles * kTileSpans; ++i) {
    const OccupiedSpan& wide = before.of_tile(0)[i];
    const OccupiedSpan& narrow = after.of_tile(0)[i];
    EXPECT_LE(wide.first, narrow.first);
    EXPECT_GE(wide.last, narrow.last);
    is_narrower = is_narrower || narrow.last - narrow.first < wide.last - wide.first;
  }
  EXPECT_TRUE(is_narrower);
}

}  // namespace
}  // namespace octavo
