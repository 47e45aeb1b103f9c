#include "octavo/ops/mask/mask_build.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <cmath>
#include <limits>

#include "octavo/codec/simd_level.h"
#include "octavo/core/error.h"
#include "octavo/octree/condense.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

TEST(MaskTree, HoldsTheVoxelsItWasMadeOf) {
  std::mt19937 random(1);
  for (const Size3& size : testing::odd_sizes()) {
    for (int turn = 0; turn < 4; ++turn) {
      const DenseMask mask = testing::random_mask(size, random);
      const MaskTree tree = testing::tree_of(mask);
      ASSERT_TRUE(is_valid(tree));
      EXPECT_EQ(testing::dense_of(tree), mask) << size.x << ' ' << size.y << ' ' << size.z;
      EXPECT_EQ(tree.voxel_count(),
                static_cast<std::uint64_t>(std::count(mask.voxels.begin(), mask.voxels.end(), 1)));
    }
  }
}

TEST(MaskTree, HasTheLeavesThatCondensationGives) {
  std::mt19937 random(2);
  for (const Size3& size : testing::odd_sizes()) {
    const DenseMask mask = testing::random_mask(size, random);
    const LinearOctree expected =
        condense(std::span<const std::uint8_t>(mask.voxels), size, {.background = 0});
    const MaskTree tree = testing::tree_of(mask);
    const LinearOctree found = to_linear_octree(tree);
    EXPECT_EQ(found, expected) << size.x << ' ' << size.y << ' ' << size.z;
    const std::vector<std::int64_t> counts = leaf_counts(tree);
    ASSERT_EQ(counts.size(), expected.levels.size());
    for (std::size_t level = 0; level < counts.size(); ++level) {
      EXPECT_EQ(counts[level], leaf_count(expected, static_cast<int>(level)));
    }
  }
}

TEST(MaskTree, HoldsNothingOutsideTheVolume) {
  const MaskTree full = box_mask({5, 6, 7}, box_of(Size3{9, 9, 9}));
  EXPECT_EQ(full.voxel_count(), 210u);
  for (const Index3& p : {Index3{5, 0, 0}, {0, 6, 0}, {0, 0, 7}, {-1, 0, 0}, {1 << 22, 0, 0}}) {
    EXPECT_FALSE(full.contains(p));
  }
}

TEST(MaskTree, FillsAnyBoxWithItsVoxels) {
  std::mt19937 random(6);
  for (const Size3& size : testing::odd_sizes()) {
    const DenseMask mask = testing::random_mask(size, random);
    const MaskTree tree = testing::tree_of(mask);
    for (int turn = 0; turn < 10; ++turn) {
      Box box;
      for (int axis = 0; axis < 3; ++axis) {
        const auto length = static_cast<unsigned>(size[axis]);
        box.lo[axis] = static_cast<std::int64_t>(random() % length);
        box.hi[axis] =
            size[axis] -
            static_cast<std::int64_t>(random() % static_cast<unsigned>(size[axis] - box.lo[axis]));
      }
      std::vector<std::uint8_t> voxels(static_cast<std::size_t>(box.size().voxel_count()), 7);
      fill_voxels(tree, box, voxels.data());
      std::size_t i = 0;
      testing::for_each_voxel(box.size(), [&](const Index3& p) {
        ASSERT_EQ(voxels[i++], mask.at({box.lo.x + p.x, box.lo.y + p.y, box.lo.z + p.z}));
      });
    }
  }
}

TEST(BoxMask, IsTheMaskOfTheBox) {
  std::mt19937 random(3);
  for (const Size3& size : testing::odd_sizes()) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = static_cast<std::int64_t>(random() % static_cast<unsigned>(size[axis]));
      box.hi[axis] = box.lo[axis] + static_cast<std::int64_t>(random() % 100);
    }
    DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
    testing::for_each_voxel(size, [&](const Index3& p) { mask.at(p) = box.contains(p) ? 1 : 0; });
    const MaskTree tree = box_mask(size, box);
    EXPECT_TRUE(is_valid(tree));
    EXPECT_EQ(tree, testing::tree_of(mask));
  }
}

TEST(MakeMask, TakesTheWindowInEveryType) {
  const Size3 size{70, 9, 5};
  for (const VoxelType type : {VoxelType::int8, VoxelType::uint8, VoxelType::int16,
                               VoxelType::uint16, VoxelType::int32, VoxelType::uint32}) {
    const ValueRange range = value_range(type);
    const double infinity = std::numeric_limits<double>::infinity();
    const auto min = static_cast<double>(range.min);
    const auto max = static_cast<double>(range.max);
    const std::vector<ValueWindow> windows = {
        {min, min},         {max - 1, max},   {min / 2, max / 3}, {0, 0},
        {-0.5, 0.5},        {0.25, 0.75},     {min - 5, max + 5}, {-infinity, infinity},
        {max + 1, max + 9}, {3, 2},           {1, infinity},     {-infinity, -1},
        {std::nan(""), 1},  {0, std::nan("")}};
    with_voxel_type(type, [&](auto id) {
      using T = typename decltype(id)::type;
      std::mt19937_64 random(4);
      std::vector<T> voxels(static_cast<std::size_t>(size.voxel_count()));
      for (T& v : voxels) {
        const auto draw = random();
        v = draw % 4 == 0   ? static_cast<T>(range.max)
            : draw % 4 == 1 ? static_cast<T>(range.min)
                            : static_cast<T>(draw >> 8);
      }
      for (const ValueWindow& window : windows) {
        const MaskTree tree =
            make_mask({voxels.data(), type, size, size.x, size.x * size.y}, window);
        std::size_t i = 0;
        testing::for_each_voxel(size, [&](const Index3& p) {
          EXPECT_EQ(tree.contains(p), window.contains(static_cast<double>(voxels[i++])));
        });
      }
    });
  }
}

/// Voxels of any type, half of them near the ends of `window`.
template <class T>
std::vector<T> voxels_around(const ValueWindow& window, const Size3& size) {
  std::mt19937 random(8);
  std::vector<T> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (T& v : voxels) {
    const auto draw = static_cast<int>(random() % 8);
    v = static_cast<T>(draw < 4 ? window.lowest + draw - 2 : window.highest + draw - 6);
  }
  // Runs wholly in or out of the window, beside the others.
  const std::size_t run = voxels.size() / 3;
  std::fill_n(voxels.begin(), run, static_cast<T>(window.lowest));
  std::fill_n(voxels.begin() + static_cast<std::ptrdiff_t>(run), run / 2,
              static_cast<T>(window.highest + 1));
  return voxels;
}

TEST(MakeMask, EveryInstructionSetFindsTheSameVoxels) {
  const ValueWindow window{20, 90};
  const std::int64_t targets = hwy::SupportedTargets();
  int count = 0;
  for (std::int64_t left = targets; left != 0; left &= left - 1) {
    const SimdTargetsInUse in_use(left & -left);
    ++count;
    for (const Size3& size : {Size3{1500, 5, 6}, Size3{64, 4, 4}, Size3{63, 3, 70}}) {
      for (const VoxelType type :
           {VoxelType::int8, VoxelType::uint16, VoxelType::int32, VoxelType::float32}) {
        with_voxel_type(type, [&](auto id) {
          using T = typename decltype(id)::type;
          const std::vector<T> voxels = voxels_around<T>(window, size);
          const MaskTree tree =
              make_mask({voxels.data(), type, size, size.x, size.x * size.y}, window);
          ASSERT_TRUE(is_valid(tree));
          std::size_t i = 0;
          testing::for_each_voxel(size, [&](const Index3& p) {
            ASSERT_EQ(tree.contains(p), window.contains(static_cast<double>(voxels[i++])))
                << "target " << (left & -left);
          });
        });
      }
    }
  }
  EXPECT_GE(count, 1);
}

TEST(MakeMask, TakesTheWindowOfFloats) {
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> voxels = {
      -infinity,     -1.5f,  -0.0f, 0.0f,    0.1f, std::nextafter(0.1f, 1.0f),
      std::nanf(""), 1e-40f, 3e38f, infinity};
  const Size3 size{static_cast<std::int64_t>(voxels.size()), 1, 1};
  const double inf = std::numeric_limits<double>::infinity();
  for (const ValueWindow& window : std::vector<ValueWindow>{
           {0, 0.1}, {0.1, 1}, {-inf, inf}, {0, 0}, {1e-40, 1e300}, {-1.5, -1e-300}, {1e39, inf}}) {
    const MaskTree tree =
        make_mask({voxels.data(), VoxelType::float32, size, size.x, size.x}, window);
    for (std::int64_t x = 0; x < size.x; ++x) {
      const auto value = static_cast<double>(voxels[static_cast<std::size_t>(x)]);
      EXPECT_EQ(tree.contains({x, 0, 0}), window.contains(value))
          << value << " in " << window.lowest << " .. " << window.highest;
    }
  }
}

TEST(MaskBuilder, AddsUpSeveralWindows) {
  const std::vector<std::uint8_t> voxels = {1, 2, 3, 4, 5, 6, 7, 8};
  const Size3 size{8, 1, 1};
  const BrickView block{voxels.data(), VoxelType::uint8, size, 8, 8};
  MaskBuilder builder(size);
  builder.add_block({0, 0, 0}, block, {2, 3});
  builder.add_block({0, 0, 0}, block, {3, 3});
  builder.add_block({0, 0, 0}, block, {7, 9});
  builder.finish_layer();
  const MaskTree tree = builder.finish();
  for (std::int64_t x = 0; x < 8; ++x) {
    EXPECT_EQ(tree.contains({x, 0, 0}), x == 1 || x == 2 || x == 6 || x == 7);
  }
}

TEST(MaskBuilder, TakesBlocksOfBricksInAnyOrder) {
  std::mt19937 random(5);
  const Size3 size{150, 70, 100};
  const DenseMask mask = testing::random_mask(size, random);
  MaskBuilder builder(size);
  for (std::int64_t layer = 0; layer < size.z; layer += 64) {
    std::vector<Index3> corners;
    for (std::int64_t z = layer; z < std::min(size.z, layer + 64); z += 16)
      for (std::int64_t y = 0; y < size.y; y += 32)
        for (std::int64_t x = 0; x < size.x; x += 48) corners.push_back({x, y, z});
    std::shuffle(corners.begin(), corners.end(), random);
    for (const Index3& corner : corners) {
      const Box box =
          intersection(box_of(size), {corner, {corner.x + 48, corner.y + 32, corner.z + 16}});
      BrickView block = testing::view_of(mask);
      block.voxels = mask.voxels.data() + (corner.z * size.y + corner.y) * size.x + corner.x;
      block.size = box.size();
      builder.add_block(corner, block, {1, 1});
    }
    builder.finish_layer();
  }
  EXPECT_EQ(builder.finish(), testing::tree_of(mask));
}

TEST(MaskBuilder, RejectsWhatDoesNotFit) {
  const Size3 size{20, 20, 100};
  MaskBuilder builder(size);
  const std::vector<std::uint8_t> voxels(20 * 20 * 64, 1);
  const BrickView layer{voxels.data(), VoxelType::uint8, {20, 20, 64}, 20, 400};
  const auto block_of = [&](const Size3& block) {
    return BrickView{voxels.data(), VoxelType::uint8, block, 20, 400};
  };
  EXPECT_THROW(builder.add_block({0, 0, 4}, layer, {1, 1}), Error);
  EXPECT_THROW(builder.add_block({0, 0, 64}, block_of({20, 20, 4}), {1, 1}), Error);
  EXPECT_THROW(builder.add_block({2, 0, 0}, block_of({4, 4, 4}), {1, 1}), Error);
  EXPECT_THROW(builder.add_block({0, 0, 0}, block_of({4, 4, 3}), {1, 1}), Error);
  EXPECT_THROW(builder.add_block({0, 0, 0}, block_of({0, 4, 4}), {1, 1}), Error);
  EXPECT_THROW(builder.finish(), Error);
  builder.finish_layer();
  builder.add_block({0, 0, 64}, block_of({20, 20, 36}), {1, 1});
  builder.finish_layer();
  EXPECT_THROW(builder.finish_layer(), Error);
  EXPECT_EQ(builder.finish(), box_mask(size, {{0, 0, 64}, {20, 20, 100}}));
}

}  // namespace
}  // namespace octavo
