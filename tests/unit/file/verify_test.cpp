#include <gtest/gtest.h>

#include "octavo/file/parallel_read.h"
#include "octavo/file/verify.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

VerifyReport verify_bytes(std::vector<std::uint8_t> bytes, int threads = 1) {
  NoProgress progress;
  VerifyOptions options;
  options.for_each = for_each_parallel(threads);
  return verify_file(byte_source_of(std::move(bytes), "sample.8vo"), options, progress);
}

TEST(Verify, ASoundFileHasNoDamage) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::noisy_half);
  const VerifyReport report = verify_bytes(sample_file_bytes(volume), 3);
  EXPECT_TRUE(report.is_sound());
  EXPECT_EQ(report.brick_count, 3 * 2 * 3 + 1);
  EXPECT_GT(report.segment_count, 0);
}

TEST(Verify, NamesTheBrickTheLevelAndTheByte) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::gradient);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const BrickEntry entry = open_bytes(bytes)->brick(0, {1, 1, 1});
  const BrickEntry::Segment& segment = entry.segments[2];
  const std::uint64_t at = segment.offset + segment.length / 2;
  bytes[at] ^= 16;
  const VerifyReport report = verify_bytes(bytes);
  ASSERT_EQ(report.damage_count, 1);
  EXPECT_EQ(report.damaged_brick_count, 1);
  const Damage& damage = report.damages.front();
  EXPECT_EQ(damage.what, "brick");
  EXPECT_EQ(damage.code, entry.code);
  EXPECT_EQ(damage.level, 2);
  EXPECT_EQ(damage.offset, segment.offset);
  EXPECT_EQ(damage.flipped_byte, at);
  EXPECT_EQ(damage.flipped_bit, 4);
}

TEST(Verify, OneDamagedBrickLeavesTheOthersReadable) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::gradient);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  bytes[open_bytes(bytes)->brick(0, {1, 1, 1}).segments[0].offset] ^= 1;
  const auto reader = open_bytes(bytes);
  const Box first{{0, 0, 0}, {64, 64, 64}};
  EXPECT_EQ(read_samples(*reader, first, 0), expected_samples(volume, first, 0));
  EXPECT_THROW(read_samples(*reader, {{64, 64, 64}, {65, 65, 65}}, 0), Error);
  const Box coarse = box_of(volume.levels.size(1));
  EXPECT_EQ(read_samples(*reader, coarse, 1), expected_samples(volume, coarse, 1));
}

TEST(Verify, ReportsTheSameForAnyNumberOfThreads) {
  SampleVolume volume = make_sample({200, 140, 70}, VoxelType::int16, Pattern::gradient);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto reader = open_bytes(bytes);
  for (std::int64_t x = 0; x < 3; ++x) bytes[reader->brick(0, {x, 1, 0}).segments[0].offset] ^= 2;
  const VerifyReport one = verify_bytes(bytes, 1);
  const VerifyReport four = verify_bytes(bytes, 4);
  ASSERT_EQ(one.damages.size(), 3u);
  ASSERT_EQ(four.damages.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(one.damages[i].offset, four.damages[i].offset);
    EXPECT_EQ(one.damages[i].detail, four.damages[i].detail);
  }
}

}  // namespace
}  // namespace octavo
