#include "octavo/io/source/text_voxels.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// The bytes of `count` voxels of a text.
std::string read_text(const std::string& text, VoxelType type, std::size_t count,
                      std::uint64_t offset = 0) {
  const TempFolder folder;
  write_file(folder.file("a.txt"), text);
  TextVoxels voxels(folder.file("a.txt"), offset);
  std::string bytes(count * static_cast<std::size_t>(bytes_per_voxel(type)), '\0');
  voxels.read(type, std::as_writable_bytes(std::span(bytes.data(), bytes.size())));
  return bytes;
}

TEST(TextVoxels, NumbersOfEveryTypeAreReadToTheirLimits) {
  EXPECT_EQ(read_text("-128 127\t+7\r\n", VoxelType::int8, 3),
            bytes_of<std::int8_t>({-128, 127, 7}));
  EXPECT_EQ(read_text("0 255\n", VoxelType::uint8, 2), bytes_of<std::uint8_t>({0, 255}));
  EXPECT_EQ(read_text("-32768 32767\n", VoxelType::int16, 2),
            bytes_of<std::int16_t>({-32768, 32767}));
  EXPECT_EQ(read_text("0 65535\n", VoxelType::uint16, 2), bytes_of<std::uint16_t>({0, 65535}));
  EXPECT_EQ(read_text("-2147483648\n\n2147483647\n", VoxelType::int32, 2),
            bytes_of<std::int32_t>({std::numeric_limits<std::int32_t>::min(), 2147483647}));
  EXPECT_EQ(read_text("4294967295 ", VoxelType::uint32, 1), bytes_of<std::uint32_t>({4294967295}));
  EXPECT_EQ(read_text("1.5 -2e3 .25 0.1 7 ", VoxelType::float32, 5),
            bytes_of<float>({1.5F, -2000, 0.25F, 0.1F, 7}));
}

TEST(TextVoxels, ReadingStartsAtTheOffsetAndTellsWhereItEnds) {
  const TempFolder folder;
  write_file(folder.file("a.txt"), "99 1 2 3\n");
  TextVoxels voxels(folder.file("a.txt"), 3);
  std::array<std::byte, 2> two{};
  voxels.read(VoxelType::uint8, two);
  EXPECT_EQ(two[1], std::byte{2});
  EXPECT_EQ(voxels.offset(), 6U);
}

TEST(TextVoxels, WhatIsNoNumberOfTheTypeIsRejectedWithItsByte) {
  struct Row {
    const char* text;
    VoxelType type;
  };
  for (const Row& row : {Row{"1 256 \n", VoxelType::uint8}, Row{"1 -1 \n", VoxelType::uint16},
                         Row{"1 2.0 \n", VoxelType::int16}, Row{"1 0x10 \n", VoxelType::int32},
                         Row{"1 1,2 \n", VoxelType::float32}, Row{"1 + \n", VoxelType::int8},
                         Row{"1 - \n", VoxelType::int8}, Row{"1 1e99 \n", VoxelType::float32},
                         Row{"1 SCALARS \n", VoxelType::float32},
                         Row{"1 4294967296 \n", VoxelType::uint32}}) {
    const Error error = error_of([&] { read_text(row.text, row.type, 2); });
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << row.text;
    EXPECT_TRUE(contains(error, "no number that a voxel")) << error.what();
    EXPECT_TRUE(contains(error, "a.txt")) << error.what();
  }
  const Error error = error_of([] { read_text(std::string(129, '1') + " ", VoxelType::int8, 1); });
  EXPECT_TRUE(contains(error, "more than 128 bytes")) << error.what();
}

TEST(TextVoxels, EveryTruncationIsRejected) {
  const std::string whole = "12 345 \n6";
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    const Error error = error_of([&] { read_text(whole.substr(0, length), VoxelType::int32, 3); });
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << length;
    EXPECT_TRUE(contains(error, "cut")) << error.what();
  }
  EXPECT_EQ(read_text(whole + "\n", VoxelType::int32, 3), bytes_of<std::int32_t>({12, 345, 6}));
}

TEST(TextVoxels, WordsMayLieAcrossTheEndsOfItsBuffer) {
  std::string text;
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < 40'000; ++i) {
    expected.push_back(i * 99'991);
    text += std::to_string(expected.back()) + (i % 9 == 0 ? "\r\n" : " ");
  }
  ASSERT_GT(text.size(), std::size_t{5} << 16);
  EXPECT_EQ(read_text(text, VoxelType::uint32, expected.size()), bytes_of(expected));
  const std::string blanks(std::size_t{3} << 16, ' ');
  EXPECT_EQ(read_text(blanks + "5" + blanks + "6 ", VoxelType::uint8, 2), "\5\6");
}

}  // namespace
}  // namespace octavo::testing
