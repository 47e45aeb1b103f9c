#include "octavo/codec/grey/value_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <tuple>
#include <vector>

namespace octavo::grey {
namespace {

constexpr Size3 kMapSize{32, 32, 16};

TrainingBrick brick_of(const std::vector<std::uint16_t>& voxels) {
  return {{}, {voxels.data(), VoxelType::uint16, kMapSize, kMapSize.x, kMapSize.x * kMapSize.y}};
}

/// Random numbers below `count`, times a step, from `origin` on.
std::vector<std::uint16_t> voxels_on(unsigned step, unsigned origin, unsigned count) {
  std::mt19937 random(step + count);
  std::vector<std::uint16_t> voxels(static_cast<std::size_t>(kMapSize.voxel_count()));
  for (auto& voxel : voxels) voxel = static_cast<std::uint16_t>(origin + step * (random() % count));
  return voxels;
}

ValueMap map_of(const std::vector<std::uint16_t>& voxels, bool finds_gaps = true) {
  const TrainingBrick brick = brick_of(voxels);
  return learn_value_map(std::span(&brick, 1), finds_gaps);
}

TEST(ValueMap, FindsTheStepThatValuesLieApart) {
  const ValueMap map = map_of(voxels_on(16, 35, 1000));
  EXPECT_EQ(map.lattice.step, 16);
  EXPECT_EQ(map.lattice.offset, 3);
  EXPECT_TRUE(map.used.empty());
}

TEST(ValueMap, OneVoxelBesideTheLatticeIsEnoughToDoWithout) {
  auto voxels = voxels_on(16, 32, 1000);
  voxels[4711] = static_cast<std::uint16_t>(voxels[4711] + 1);
  EXPECT_TRUE(map_of(voxels).is_empty());
}

TEST(ValueMap, FewStepsKeepTheMeansOfTheVoxels) {
  const ValueMap map = map_of(voxels_on(255, 0, 2));
  EXPECT_EQ(map.lattice.step, 1);
  EXPECT_EQ(map.used.size(), 256u);
  EXPECT_TRUE(map_of(voxels_on(255, 0, 2), false).is_empty());
}

TEST(ValueMap, FewLongStepsAreDividedIntoAsManyPartsAsAByteHasValues) {
  for (const auto& [step, count, expected] :
       {std::tuple{65535u, 2u, 257}, {21845u, 4u, 257}, {1000u, 11u, 40}, {30000u, 3u, 240}}) {
    const ValueMap map = map_of(voxels_on(step, 0, count));
    EXPECT_EQ(map.lattice.step, expected) << step;
    EXPECT_FALSE(map.used.empty()) << step;
  }
  // Of a prime there are no parts.
  EXPECT_TRUE(map_of(voxels_on(65521, 0, 2)).is_empty());
}

TEST(ValueMap, ValuesWithoutGapsHaveNone) {
  EXPECT_TRUE(map_of(voxels_on(1, 7, 200)).is_empty());
}

TEST(ValueMap, ComesBackFromItsBytes) {
  for (const ValueMap& map : {map_of(voxels_on(16, 35, 1000)), map_of(voxels_on(3, 1, 60)),
                              map_of(voxels_on(255, 0, 2))}) {
    ASSERT_FALSE(map.is_empty());
    Bytes bytes;
    put_value_map(bytes, map);
    ByteSpan left = bytes;
    const ValueMap back = take_value_map(left);
    EXPECT_TRUE(left.empty());
    EXPECT_EQ(back.lattice.step, map.lattice.step);
    EXPECT_EQ(back.lattice.offset, map.lattice.offset);
    EXPECT_EQ(back.first, map.first);
    EXPECT_EQ(back.used, map.used);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      ByteSpan cut = ByteSpan(bytes).first(length);
      EXPECT_THROW(take_value_map(cut), Error) << length;
    }
  }
}

TEST(ValueMap, NegativeValuesHaveAnOffsetToo) {
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(kMapSize.voxel_count()));
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::int16_t>(-1000 + 7 * static_cast<int>(i % 200));
  }
  const TrainingBrick brick{
      {}, {voxels.data(), VoxelType::int16, kMapSize, kMapSize.x, kMapSize.x * kMapSize.y}};
  const ValueMap map = learn_value_map(std::span(&brick, 1), true);
  EXPECT_EQ(map.lattice.step, 7);
  EXPECT_EQ(map.lattice.offset, 1);  // -1000 = 7 * -143 + 1
  for (const std::int64_t voxel : {-1000, -993, 393}) {
    EXPECT_EQ(map.lattice.voxel_of(map.lattice.code_of(voxel)), voxel);
  }
}

/// A map as bytes: step, offset, number of codes, first code, flags.
Bytes map_bytes(std::uint64_t step, std::uint64_t offset, std::uint64_t count, std::int64_t first,
                std::uint8_t flags) {
  Bytes bytes;
  for (const std::uint64_t value : {step, offset, count, zigzag(first)}) put_varint(bytes, value);
  bytes.push_back(flags);
  return bytes;
}

TEST(ValueMap, ImpossibleOnesAreDamage) {
  const auto take = [](const Bytes& bytes) {
    ByteSpan left = bytes;
    return take_value_map(left);
  };
  EXPECT_EQ(take(map_bytes(5, 4, 3, -9, 5)).used, (std::vector<std::uint8_t>{1, 0, 1}));
  constexpr std::int64_t kFar = std::int64_t{1} << 62;
  for (const Bytes& bytes :
       {map_bytes(0, 0, 3, 0, 5), map_bytes(5, 5, 3, 0, 5),
        map_bytes(std::uint64_t{1} << 32, 0, 3, 0, 5), map_bytes(5, 4, 257, 0, 5),
        map_bytes(5, 4, 3, kFar, 5), map_bytes(5, 4, 3, -kFar, 5), map_bytes(5, 4, 3, 0, 4),
        map_bytes(5, 4, 3, 0, 1), map_bytes(5, 4, 3, 0, 0)}) {
    EXPECT_THROW(take(bytes), Error);
  }
}

TEST(BrickMap, AGappedBrickOfTooManyValuesIsDamage) {
  const ValueMap map = map_of(voxels_on(255, 0, 2));
  Bytes bytes;
  put_brick_map(bytes, {.is_on_lattice = false, .has_gaps = true, .extras = {}});
  ByteSpan left = bytes;
  EXPECT_NO_THROW(take_brick_map(map, {0, 255}, left));
  left = bytes;
  EXPECT_THROW(take_brick_map(map, {0, 256}, left), Error);
}

TEST(BrickMap, BricksOffTheLatticeAreCodedAsTheyAre) {
  const ValueMap map = map_of(voxels_on(16, 32, 1000));
  const auto on = voxels_on(16, 64, 20);
  const auto off = voxels_on(16, 65, 20);
  EXPECT_TRUE(map_brick(map, brick_of(on).view, {64, 368}, true).is_on_lattice);
  EXPECT_FALSE(map_brick(map, brick_of(off).view, {65, 369}, true).is_on_lattice);
}

TEST(BrickMap, ValuesThatTheModelDoesNotKnowAreListed) {
  const ValueMap map = map_of(voxels_on(255, 0, 2));
  auto voxels = voxels_on(255, 0, 2);
  voxels[5] = 77;
  const BrickMap brick = map_brick(map, brick_of(voxels).view, {0, 255}, true);
  EXPECT_TRUE(brick.has_gaps);
  EXPECT_EQ(brick.extras, Bytes{77});
  EXPECT_FALSE(map_brick(map, brick_of(voxels).view, {0, 255}, false).has_gaps);
  EXPECT_FALSE(map_brick(map, brick_of(voxels_on(1, 0, 256)).view, {0, 255}, true).has_gaps);
  Bytes bytes;
  put_brick_map(bytes, brick);
  ByteSpan left = bytes;
  EXPECT_EQ(take_brick_map(map, {0, 255}, left).extras, brick.extras);
  EXPECT_TRUE(left.empty());
  const ValueMap none;
  left = bytes;
  EXPECT_THROW(take_brick_map(none, {0, 255}, left), Error);
}

TEST(ValueGaps, NumberEveryPossibleDetailAndNoOther) {
  std::mt19937 random(5);
  for (int round = 0; round < 40; ++round) {
    const std::int64_t lowest = static_cast<std::int64_t>(random() % 1000) - 32768;
    std::vector<std::uint8_t> used(2 + random() % 255);
    for (auto& flag : used) flag = random() % (1 + static_cast<unsigned>(round)) == 0;
    const int rounding = round & 1;
    const ValueGaps gaps(lowest, used, rounding);
    const auto count = static_cast<std::int64_t>(used.size());
    std::vector<std::vector<std::int64_t>> details(used.size());
    for (std::int64_t a = 0; a < count; ++a) {
      for (std::int64_t b = 0; b < count; ++b) {
        if (!used[static_cast<std::size_t>(a)] || !used[static_cast<std::size_t>(b)]) continue;
        details[static_cast<std::size_t>((a + b + rounding) >> 1)].push_back(a - b);
      }
    }
    for (std::int64_t mean = 0; mean < count; ++mean) {
      auto& possible = details[static_cast<std::size_t>(mean)];
      std::sort(possible.begin(), possible.end());
      if (possible.empty()) {
        EXPECT_EQ(gaps.of(lowest + mean).detail(3), 0);
        continue;
      }
      for (std::size_t i = 0; i < possible.size(); ++i) {
        ASSERT_EQ(gaps.of(lowest + mean).detail(static_cast<std::int64_t>(i)), possible[i]);
      }
      ASSERT_EQ(gaps.of(lowest + mean).detail(-1), possible.front());
      ASSERT_EQ(gaps.of(lowest + mean).detail(1000), possible.back());
      for (std::int64_t detail = -255; detail <= 255; ++detail) {
        const auto nearest = std::min_element(
            possible.begin(), possible.end(), [&](std::int64_t left, std::int64_t right) {
              return std::abs(left - detail) < std::abs(right - detail);
            });
        ASSERT_EQ(gaps.of(lowest + mean).nearest(detail), nearest - possible.begin());
      }
    }
  }
}

}  // namespace
}  // namespace octavo::grey
