// However the bricks of a group are dealt out to parts, the parts join into the bytes of a build.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "octavo/builder/group_reader.h"
#include "support/goal_cases.h"
#include "support/part_volumes.h"
#include "support/parted_volume.h"

namespace octavo::testing {
namespace {

/// Of thick slices, so that bricks have few planes: 4, and 64 x 64 pixels.
SmallVolume flat(SmallVolume volume) {
  volume.description.geometry.spacing_mm = {1, 1, 16};
  return volume;
}

/// Lossless volumes of many bricks a layer.
std::vector<SmallVolume> wide_volumes() {
  std::vector<SmallVolume> all;
  const Size3 size = {200, 330, 11};
  all.push_back(flat(small_volume("int16", VoxelType::int16, size)));
  all.push_back(with(flat(small_volume("small uint8", VoxelType::uint8, {300, 129, 8})),
                     [](auto& v) { v.options.preset = Preset::small; }));
  all.push_back(with(flat(small_volume("boxes, thumbnail", VoxelType::int8, size)), [](auto& v) {
    v.options.access = Access::boxes;
    v.options.has_thumbnail = true;
  }));
  all.push_back(flat(small_volume("labels", VoxelType::uint16, size, VolumeKind::labels)));
  all.push_back(flat(small_volume("float32", VoxelType::float32, {140, 200, 10})));
  all.push_back(flat(small_volume("uniform groups", VoxelType::int16, {140, 200, 150},
                                  VolumeKind::grey, 3, true)));
  // More than 32 bricks of a layer, so that training chooses
  all.push_back(flat(small_volume("many bricks", VoxelType::int16, {512, 448, 9})));
  all.push_back(with(flat(small_volume("masked", VoxelType::int16, {512, 448, 9})), [](auto& v) {
    const auto plane = static_cast<std::ptrdiff_t>(plane_bytes(v.description));
    for (std::ptrdiff_t z = 0; z < 9; ++z) {
      std::fill_n(v.voxels.begin() + z * plane, plane / (z % 4 == 0 ? 2 : 3), std::byte{0});
    }
  }));
  all.push_back(with(small_volume("isotropic", VoxelType::int16, {130, 130, 40}), [](auto& v) {
    v.description.geometry.spacing_mm = {1, 1, 2.4};
    v.isotropic = PlaneInterpolation::cubic;
  }));
  return all;
}

/// Runs of whole groups, and bands of others.
Places random_places(const BuildPlan& plan, std::mt19937& random) {
  const auto up_to = [&](std::int64_t most) {
    return std::uniform_int_distribution<std::int64_t>(1, most)(random);
  };
  const std::int64_t bricks = layer_bricks_of(plan);
  Places places;
  for (std::int64_t group = 0; group < plan.group_count;) {
    if (random() % 4 == 0) {
      const std::int64_t end = group + up_to(plan.group_count - group);
      places.push_back({plan.id, std::exchange(group, end), end});
      continue;
    }
    const std::int64_t longest = up_to(bricks);
    for (std::int64_t brick = 0; brick < bricks;) {
      const std::int64_t end = std::min(brick + up_to(longest), bricks);
      places.push_back({plan.id, group, group + 1, std::exchange(brick, end), end});
    }
    ++group;
  }
  std::ranges::shuffle(places, random);
  return places;
}

constexpr std::uint64_t kMostBandBytes = std::uint64_t{1} << 21;

TEST(SharedGroups, AnyBandsInAnyOrderMakeTheFileOfABuild) {
  const SmallGroups groups(1);  // one layer each
  std::vector<PartedVolume> volumes;
  for (SmallVolume& volume : wide_volumes()) {
    const std::string name = volume.name;
    volumes.emplace_back(std::move(volume), kMostBandBytes);
    EXPECT_GE(volumes.back().plan().group_count, 2) << name;
    EXPECT_GE(layer_bricks_of(volumes.back().plan()), 9) << name;
  }
  const std::uint64_t count = case_count(9, 2'000);
  GoalCases cases("E4", "random partitions with shared groups", count);
  std::size_t bands = 0;
  for (std::uint64_t i = 0; cases.next(); ++i) {
    std::mt19937 random(static_cast<std::uint32_t>(i));
    PartedVolume& volume = volumes[i % volumes.size()];
    const Places places = random_places(volume.plan(), random);
    volume.expect_same(places, random);
    bands += static_cast<std::size_t>(std::ranges::count_if(places, &PartPlace::is_band));
    if (HasFailure()) FAIL() << "partition " << i;
  }
  EXPECT_GE(bands, 4 * count);
  cases.tell("all of them the bytes of a build");
}

TEST(SharedGroups, BordersInsideAndAtIndexPagesMakeTheFileOfABuild) {
  const SmallGroups groups(1);
  PartedVolume volume(
      flat(small_volume("1056 bricks a layer", VoxelType::uint8, {2112, 2048, 8})),
      kMostBandBytes);
  const std::uint64_t id = volume.plan().id;
  const auto expect_same = [&](const std::vector<std::int64_t>& borders) {
    Places places;
    for (std::int64_t group = 0; group < volume.plan().group_count; ++group) {
      for (std::size_t i = 1; i < borders.size(); ++i) {
        places.push_back({id, group, group + 1, borders[i - 1], borders[i]});
      }
    }
    std::mt19937 random(7);
    volume.expect_same(places, random);
  };
  ASSERT_EQ(layer_bricks_of(volume.plan()), 1056);
  expect_same({0, 1024, 1056});
  expect_same({0, 1, 1023, 1025, 1056});
}

}  // namespace
}  // namespace octavo::testing
