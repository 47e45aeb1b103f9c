#include "octavo/render/rays/ray_bricks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/render/rays/dense_samples.h"

namespace octavo {
namespace {

constexpr Size3 kGrid = {37, 40, 21};  // bricks of 16^3: 3 x 3 x 2

/// Counts what is read of each sample, and fails where it should.
class CountedSamples final : public SampleSource {
 public:
  explicit CountedSamples(const std::vector<std::int16_t>& samples)
      : samples_(samples.data(), VoxelType::int16, kGrid, 16) {}

  Size3 size() const override { return kGrid; }
  VoxelType type() const override { return VoxelType::int16; }
  SampleRange range() const override { return samples_.range(); }
  SampleRange range(const Box& box) const override { return samples_.range(box); }
  void read(const Box& box, void* out) const override {
    if (fails_at.x >= 0 && box.contains(fails_at)) throw Error(ErrorKind::corrupt, "damaged");
    read_count += box.size().voxel_count();
    samples_.read(box, out);
  }

  Index3 fails_at{-1, -1, -1};
  mutable std::atomic<std::int64_t> read_count = 0;

 private:
  DenseSamples samples_;
};

class LoadedBricks : public ::testing::Test {
 protected:
  LoadedBricks() : samples_(numbers()), source_(samples_), bricks_(source_, {4, 1 << 20}) {}

  static std::vector<std::int16_t> numbers() {
    std::vector<std::int16_t> numbers(static_cast<std::size_t>(kGrid.voxel_count()));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      numbers[i] = static_cast<std::int16_t>(i % 30011);
    }
    return numbers;
  }

  std::int16_t sample_at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    x = std::clamp<std::int64_t>(x, 0, kGrid.x - 1);
    y = std::clamp<std::int64_t>(y, 0, kGrid.y - 1);
    z = std::clamp<std::int64_t>(z, 0, kGrid.z - 1);
    return samples_[static_cast<std::size_t>((z * kGrid.y + y) * kGrid.x + x)];
  }

  /// Every sample of a brick and its aprons.
  void expect_whole(std::int32_t brick) const {
    const BrickTables tables = bricks_.tables();
    const Index3 place = bricks_.place_of(brick);
    const std::int64_t row = tables.row;
    const auto* samples = static_cast<const std::int16_t*>(tables.samples) +
                          static_cast<std::int64_t>(tables.slots[brick]) * tables.slot;
    for (std::int64_t z = 0; z < row; ++z) {
      for (std::int64_t y = 0; y < row; ++y) {
        for (std::int64_t x = 0; x < row; ++x) {
          ASSERT_EQ(*samples++, sample_at(place.x * 16 + x - kApronBelow,
                                          place.y * 16 + y - kApronBelow,
                                          place.z * 16 + z - kApronBelow))
              << brick << ": " << x << ' ' << y << ' ' << z;
        }
      }
    }
  }

  std::vector<std::int16_t> samples_;
  CountedSamples source_;
  RayBricks bricks_;
};

std::vector<std::int32_t> all_bricks() {
  std::vector<std::int32_t> all;
  for (std::int32_t brick = 0; brick < 18; ++brick) all.push_back(brick);
  return all;
}

TEST_F(LoadedBricks, ThatAreLoadedTogetherAreReadOnce) {
  bricks_.load(all_bricks());
  EXPECT_EQ(source_.read_count, kGrid.voxel_count());
  for (const std::int32_t brick : all_bricks()) expect_whole(brick);
}

TEST_F(LoadedBricks, HoldWhatTheirNeighborsHoldInAnyOrder) {
  for (const std::vector<std::int32_t>& batch :
       {std::vector<std::int32_t>{4, 17}, {0, 1, 3}, {13, 9, 16}, {8}}) {
    bricks_.load(batch);
    for (const std::int32_t brick : batch) expect_whole(brick);
  }
  expect_whole(4);
}

TEST_F(LoadedBricks, OfWhatNoRayComesToOnlyTheNeighborsPartIsRead) {
  bricks_.set_bounds([](float, float) { return 0.0f; });
  bricks_.load(std::vector<std::int32_t>{0});
  EXPECT_EQ(source_.read_count, 19 * 19 * 19);
  expect_whole(0);
}

TEST_F(LoadedBricks, ThatRaysHaveNotComeToForTheLongestTimeMakeRoom) {
  // Memory for four.
  const std::uint64_t of_one = 21 * 21 * 21 * 2 + 64 * 12 + 8 * 4 + 16 * 16 * 16 / 8;
  RayBricks few(source_, {4, 4 * of_one + 18 * 12 + 100});
  ASSERT_EQ(few.capacity(), 4u);
  few.load(std::vector<std::int32_t>{0, 1, 2, 3});
  const auto use = [&](std::int32_t brick) {
    const BrickTables tables = few.tables();
    mark_used(tables, tables.slots[brick]);
  };
  use(0);
  use(2);
  few.load(std::vector<std::int32_t>{4});
  EXPECT_FALSE(few.is_loaded(1));
  use(0);
  few.load(std::vector<std::int32_t>{5, 6});
  EXPECT_TRUE(few.is_loaded(0));
  for (const std::int32_t gone : {1, 2, 3}) EXPECT_FALSE(few.is_loaded(gone)) << gone;
  few.load(std::vector<std::int32_t>{7, 8, 9, 10});
  EXPECT_FALSE(few.is_loaded(0));
}

TEST_F(LoadedBricks, AreNotInMemoryWhereOneOfThemOrANeighborIsDamaged) {
  bricks_.load(std::vector<std::int32_t>{0});
  source_.fails_at = {36, 0, 0};  // brick 2
  EXPECT_THROW(bricks_.load(std::vector<std::int32_t>{1, 4}), Error);
  EXPECT_FALSE(bricks_.is_loaded(1));
  EXPECT_FALSE(bricks_.is_loaded(4));
  EXPECT_TRUE(bricks_.is_loaded(0));
  source_.fails_at = {-1, -1, -1};
  bricks_.load(std::vector<std::int32_t>{1, 4});
  for (const std::int32_t brick : {0, 1, 4}) expect_whole(brick);
}

}  // namespace
}  // namespace octavo
