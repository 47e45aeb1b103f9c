#include "octavo/octree/condense.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "octavo/core/error.h"
#include "support/recursive_octree.h"
#include "support/shared_data.h"

namespace octavo {
namespace {

using Voxels = std::vector<std::int16_t>;

LinearOctree condense_voxels(const Voxels& voxels, const Size3& size,
                             const CondenseOptions& options) {
  return condense(std::span<const std::int16_t>(voxels), size, options);
}

TEST(Condense, AUniformUniverseIsTheRootAlone) {
  const LinearOctree octree = condense_voxels(Voxels(512, 9), {8, 8, 8}, {});
  EXPECT_EQ(leaf_count(octree), 1);
  EXPECT_EQ(octree.levels[3].values, std::vector<std::int64_t>{9});
}

TEST(Condense, OneVoxelIsItsOwnUniverse) {
  const LinearOctree octree = condense_voxels(Voxels{-3}, {1, 1, 1}, {});
  EXPECT_EQ(octree.root_level, 0);
  EXPECT_EQ(octree.levels[0].values, std::vector<std::int64_t>{-3});
  EXPECT_EQ(leaf_count(condense_voxels(Voxels{-3}, {1, 1, 1}, {.background = -3})), 0);
}

TEST(Condense, BackgroundHasNoLeaves) {
  EXPECT_EQ(leaf_count(condense_voxels(Voxels(64, 0), {4, 4, 4}, {.background = 0})), 0);
}

TEST(Condense, AnOctantThatReachesOutsideIsNotCondensed) {
  const LinearOctree octree = condense_voxels(Voxels(27, 1), {3, 3, 3}, {});
  EXPECT_EQ(leaf_count(octree, 1), 1);
  EXPECT_EQ(leaf_count(octree, 0), 19);
  EXPECT_TRUE(is_complete(octree, 27));
}

TEST(Condense, FlatOctantsCarryTheRoundedMean) {
  const Voxels voxels = {0, 1, 2, 3, 4, 4, 4, 4};
  EXPECT_EQ(condense_voxels(voxels, {2, 2, 2}, {.flat = 4}).levels[1].values,
            std::vector<std::int64_t>{3});
  EXPECT_EQ(leaf_count(condense_voxels(voxels, {2, 2, 2}, {.flat = 3})), 8);
  const Voxels negative = {-1, -1, -1, -1, -2, -2, -2, -2};
  EXPECT_EQ(condense_voxels(negative, {2, 2, 2}, {.flat = 1}).levels[1].values,
            std::vector<std::int64_t>{-1});
}

TEST(Condense, EveryIntegerTypeIsCondensedAlike) {
  const Size3 size{5, 6, 7};
  Voxels voxels(static_cast<std::size_t>(size.voxel_count()));
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::int16_t>(i < 150 ? 9 : i % 5);
  }
  const LinearOctree expected = condense_voxels(voxels, size, {.background = 9});
  for (const VoxelType type : {VoxelType::int8, VoxelType::uint8, VoxelType::int16,
                               VoxelType::uint16, VoxelType::int32, VoxelType::uint32}) {
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      if constexpr (std::is_integral_v<T>) {
        const std::vector<T> same(voxels.begin(), voxels.end());
        EXPECT_EQ(condense(std::span<const T>(same), size, {.background = 9}), expected);
        EXPECT_THROW(condense(std::span(same).first(same.size() - 1), size, {}), Error);
      }
    });
  }
}

TEST(Condense, BadUseIsRejected) {
  EXPECT_THROW(PlaneCondenser({0, 1, 1}, {}), Error);
  EXPECT_THROW(PlaneCondenser({2, 2, 2}, {.flat = -1}), Error);
  EXPECT_THROW(PlaneCondenser({2, 2, 2}, {.flat = std::int64_t{1} << 60}), Error);
  PlaneCondenser condenser({2, 2, 2}, {});
  const std::vector<std::byte> plane(4);
  EXPECT_THROW(condenser.add_plane(VoxelType::int16, plane), Error);
  EXPECT_THROW(condenser.add_plane(VoxelType::float32, std::vector<std::byte>(16)), Error);
  condenser.add_plane(VoxelType::uint8, plane);
  EXPECT_THROW(condenser.finish(), Error);
  condenser.add_plane(VoxelType::uint8, plane);
  EXPECT_THROW(condenser.add_plane(VoxelType::uint8, plane), Error);
  EXPECT_EQ(leaf_count(condenser.finish()), 1);
}

TEST(Condense, MemoryIsThatOfTheLeavesAndOfThePlanesThatWait) {
  const Size3 size{64, 64, 4};
  PlaneCondenser even(size, {.background = 0});
  PlaneCondenser mixed(size, {.background = 0});
  std::uint64_t leaves = 0;
  for (int z = 0; z < 4; ++z) {
    std::vector<std::byte> plane(64 * 64);
    even.add_plane(VoxelType::uint8, plane);
    for (std::size_t i = 0; i < plane.size(); i += 3) plane[i] = std::byte{1};
    leaves += (plane.size() + 2) / 3;
    mixed.add_plane(VoxelType::uint8, plane);
  }
  EXPECT_GE(mixed.memory_bytes(), even.memory_bytes() + 16 * leaves);
  EXPECT_LE(mixed.memory_bytes(), even.memory_bytes() + 2 * 16 * leaves);
}

TEST(Expand, ALeafOutsideTheVolumeIsRejected) {
  const LinearOctree octree = condense_voxels(Voxels(512, 9), {8, 8, 8}, {});
  EXPECT_THROW(expand(octree, {8, 8, 7}, 0), Error);
}

Voxels inflate(const std::filesystem::path& path, std::size_t count) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> packed{std::istreambuf_iterator<char>(in), {}};
  Voxels voxels(count);
  uLongf bytes = count * sizeof(std::int16_t);
  const int rc = uncompress(reinterpret_cast<Bytef*>(voxels.data()), &bytes,
                            reinterpret_cast<const Bytef*>(packed.data()), packed.size());
  EXPECT_EQ(rc, Z_OK);
  EXPECT_EQ(bytes, count * sizeof(std::int16_t));
  return voxels;
}

// The counts were taken on the scan with planes of zeros below it, up to a multiple of 64.
TEST(Condense, SkullHasTheLeafCountsOfAnyCorrectBuild) {
  const char* const name = "cranium/cranium.zraw";
  const auto path = octavo::testing::shared_file(name);
  if (!path) GTEST_SKIP() << octavo::testing::missing_shared_file(name);
  const Size3 size{256, 256, 108};
  const Size3 padded{256, 256, 128};
  const Voxels scan = inflate(*path, static_cast<std::size_t>(size.voxel_count()));
  std::vector<std::uint8_t> mask;
  for (const std::int16_t hu : scan) mask.push_back(hu >= 226);
  const auto volume = static_cast<std::uint64_t>(std::count(mask.begin(), mask.end(), 1));

  std::vector<std::uint8_t> padded_mask = mask;
  padded_mask.resize(static_cast<std::size_t>(padded.voxel_count()), 0);
  const LinearOctree both = condense(std::span<const std::uint8_t>(padded_mask), padded, {});
  const std::int64_t expected[] = {332040, 67735, 10977, 2241, 519, 76, 4, 0, 0};
  ASSERT_EQ(both.root_level, 8);
  for (int k = 0; k <= 8; ++k) EXPECT_EQ(leaf_count(both, k), expected[k]) << "level " << k;
  EXPECT_EQ(leaf_count(both), 413592);
  EXPECT_TRUE(is_complete(both, padded_mask.size()));

  // Without the background, and without the padding: the leaves of value 1 are the same.
  const LinearOctree bone = condense(std::span<const std::uint8_t>(mask), size, {.background = 0});
  for (int k = 0; k <= 8; ++k) {
    const auto& values = both.levels[static_cast<std::size_t>(k)].values;
    EXPECT_EQ(leaf_count(bone, k), std::count(values.begin(), values.end(), 1)) << "level " << k;
  }
  EXPECT_TRUE(is_complete(bone, volume));
  const std::vector<std::int64_t> back = expand(bone, size, 0);
  EXPECT_TRUE(std::equal(mask.begin(), mask.end(), back.begin(), back.end()));

  // 4352 fewer than with the padding: the 64 x 64 + 16 x 16 cubes that the zeros condense to.
  EXPECT_EQ(leaf_count(condense_voxels(scan, size, {})), 6993067 - 4352);
  EXPECT_EQ(leaf_count(condense_voxels(scan, size, {.flat = 32})), 2284295);
}

}  // namespace
}  // namespace octavo
