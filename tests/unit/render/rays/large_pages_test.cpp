#include "octavo/render/rays/large_pages.h"

#include <gtest/gtest.h>

#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

TEST(LargePages, HoldAsManyBytesAsWereAskedFor) {
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{4097}, std::size_t{5} << 20}) {
    const LargePages pages = make_large_pages(bytes);
    for (std::size_t i = 0; i < bytes; i += 4096) pages[i] = static_cast<std::uint8_t>(i >> 12);
    pages[bytes - 1] = 7;
    EXPECT_EQ(pages[bytes - 1], 7);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(pages.get()) % 4096, 0u);
  }
}

TEST(LargePages, AreKeptForTheNextOneWhoAsksForAsMany) {
  KeptPages kept;
  LargePages first = kept.take(10000);
  const std::uint8_t* const place = first.get();
  kept.give_back(std::move(first), 10000);
  const LargePages other = kept.take(20000);
  EXPECT_NE(other.get(), place);
  const LargePages again = kept.take(10000);
  EXPECT_EQ(again.get(), place);
  EXPECT_NE(kept.take(10000).get(), place);
}

TEST(LargePages, APictureStandsWhereTheOneBeforeStood) {
  const auto volume = testing::noisy_ball(20);
  const DenseSamples source(volume.samples.data(), VoxelType::int16, volume.size, 32);
  RayBricks bricks(source, {});
  RayFrame frame;
  frame.mode = RayMode::extreme;
  frame.bricks = bricks.tables();
  const View view = make_view(volume.geometry, volume.size, box_of(volume.size),
                              viewpoint_at(30, 20), {100, 70, 1, {}});
  set_camera(frame, {view, box_of(volume.size), 0, 1});
  bricks.set_bounds([](float, float highest) { return highest; });
  NoProgress silent;
  const auto draw = [&] {
    return cast_rays(bricks, frame, 100, 70, follow_rays_function(), silent);
  };
  auto field = std::make_unique<RayField>(draw());
  const std::vector<float> expected = testing::gathered(*field);
  const RayTile* const place = field->tiles.data();
  const RayField beside = draw();
  EXPECT_NE(beside.tiles.data(), place);
  field.reset();
  const RayField after = draw();
  EXPECT_EQ(after.tiles.data(), place);
  EXPECT_EQ(testing::gathered(after), expected);
  EXPECT_EQ(testing::gathered(beside), expected);
}

}  // namespace
}  // namespace octavo
