#include "octavo/io/images/tiff_directory.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <utility>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// The bytes of a number in a file.
std::string in_bytes(std::uint64_t value, std::size_t width, bool big_endian) {
  std::string bytes(width, '\0');
  for (std::size_t i = 0; i < width; ++i) {
    bytes[big_endian ? width - 1 - i : i] = static_cast<char>(value >> 8 * i & 0xff);
  }
  return bytes;
}

struct DirectoryEntry {
  std::uint16_t tag = 270;
  std::uint16_t type = 2;
  std::uint64_t count = 0;
  std::uint64_t value = 0;
};

/// A file of a directory at byte 16 and what follows it.
std::string directory_file(const std::vector<DirectoryEntry>& entries, bool big, bool big_endian,
                           const std::string& rest) {
  std::string bytes = (big_endian ? "MM" : "II") + in_bytes(big ? 43 : 42, 2, big_endian);
  bytes.resize(16, '\0');
  bytes += in_bytes(entries.size(), big ? 8 : 2, big_endian);
  const std::size_t width = big ? 8 : 4;
  for (const DirectoryEntry& entry : entries) {
    bytes += in_bytes(entry.tag, 2, big_endian) + in_bytes(entry.type, 2, big_endian) +
             in_bytes(entry.count, width, big_endian) + in_bytes(entry.value, width, big_endian);
  }
  return bytes + std::string(width, '\0') + rest;
}

TEST(TiffDirectory, GivesTheTextsOfATagInOrder) {
  const TempFolder folder;
  for (const bool big : {false, true}) {
    for (const bool big_endian : {false, true}) {
      const std::string text = "a text of tifffile";
      std::vector<DirectoryEntry> entries(5);
      const std::size_t end = directory_file(entries, big, big_endian, "").size();
      entries[0] = {270, 2, text.size() + 1, end};
      entries[1] = {256, 3, 1, 4};
      entries[2] = {270, 3, 1, 4};
      entries[3] = {270, 2, text.size() - 1, end + 2};
      // "abc" within the entry
      entries[4] = {270, 2, 4, big_endian ? std::uint64_t{0x61626300} : std::uint64_t{0x636261}};
      if (big && big_endian) entries[4].value <<= 32;
      write_file(folder.file("a"), directory_file(entries, big, big_endian, text + '\0'));
      const SourceFile file(folder.file("a"));
      const TiffDirectory directory(file, 16, big_endian);
      EXPECT_EQ(directory.texts(270, 0),
                (std::vector<std::string>{text, text.substr(2), "abc"}));
      EXPECT_EQ(directory.texts(270, 1), (std::vector<std::string>{text.substr(2), "abc"}));
      EXPECT_TRUE(directory.texts(271, 0).empty());
    }
  }
}

/// What is wrong with the number of a tag in a directory of some entries; empty where nothing is.
std::string number_error(const std::vector<DirectoryEntry>& entries, std::uint16_t tag) {
  const TempFolder folder;
  write_file(folder.file("a"), directory_file(entries, false, false, ""));
  const SourceFile file(folder.file("a"));
  try {
    TiffDirectory(file, 16, false).number(tag);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    return with_hints(error);
  }
  return {};
}

TEST(TiffDirectory, GivesTheOneNumberOfATagOfAnyTypeOfIntegers) {
  const TempFolder folder;
  for (const bool big : {false, true}) {
    for (const bool big_endian : {false, true}) {
      // Values stand at the start of their place.
      const auto first = [&](std::uint64_t value, int bytes) {
        return big_endian ? value << 8 * ((big ? 8 : 4) - bytes) : value;
      };
      // Types and their bytes
      std::vector<std::pair<std::uint16_t, int>> types = {{1, 1}, {3, 2}, {4, 4}, {6, 1},
                                                          {8, 2}, {9, 4}, {13, 4}};
      if (big) types.insert(types.end(), {{16, 8}, {17, 8}, {18, 8}});
      std::vector<DirectoryEntry> entries;
      for (const auto& [type, bytes] : types) {
        entries.push_back({static_cast<std::uint16_t>(300 + type), type, 1, first(77, bytes)});
      }
      entries.push_back({273, 4, 1, first(70000, 4)});
      write_file(folder.file("a"), directory_file(entries, big, big_endian, ""));
      const SourceFile file(folder.file("a"));
      const TiffDirectory directory(file, 16, big_endian);
      for (const auto& [type, bytes] : types) {
        EXPECT_EQ(directory.number(static_cast<std::uint16_t>(300 + type)), 77U) << type;
      }
      EXPECT_EQ(directory.number(273), 70000U);
      EXPECT_FALSE(directory.number(999));
    }
  }
}

TEST(TiffDirectory, RejectsATagThatHasNotOneWholeNumber) {
  EXPECT_EQ(number_error({{317, 3, 1, 2}}, 317), "");
  for (const std::uint64_t count : {std::uint64_t{0}, std::uint64_t{2}, std::uint64_t{1} << 31}) {
    const std::string error = number_error({{317, 3, count, 2}}, 317);
    EXPECT_TRUE(contains(error, "317 (Predictor)")) << error;
    EXPECT_TRUE(contains(error, "has " + std::to_string(count) + " values, one expected")) << error;
  }
  for (const std::uint16_t type : std::array<std::uint16_t, 7>{0, 2, 5, 7, 11, 12, 99}) {
    EXPECT_TRUE(contains(number_error({{317, type, 1, 2}}, 317), "type " + std::to_string(type)));
  }
  EXPECT_TRUE(contains(number_error({{317, 8, 1, 0xffff}}, 317), "below 0"));
  EXPECT_EQ(number_error({{317, 3, 1, 2}, {317, 3, 1, 2}}, 317), "");
  EXPECT_TRUE(contains(number_error({{317, 3, 1, 2}, {317, 3, 1, 1}}, 317), "two entries"));
}

TEST(TiffDirectory, GivesAllNumbersOfATagThatTheFileHolds) {
  const TempFolder folder;
  const std::vector<std::uint16_t> values = {5, 6, 7, 8, 9};
  const std::string rest = bytes_of(values);
  std::vector<DirectoryEntry> entries(4);
  const std::size_t end = directory_file(entries, false, false, "").size();
  entries = {{273, 3, 5, end}, {279, 3, 2, 5 + (6U << 16)}, {324, 3, 6, end}, {325, 3, 0, 0}};
  write_file(folder.file("a"), directory_file(entries, false, false, rest));
  const SourceFile file(folder.file("a"));
  const TiffDirectory directory(file, 16, false);
  EXPECT_EQ(directory.numbers(273, 9), (std::vector<std::uint64_t>{5, 6, 7, 8, 9}));
  EXPECT_EQ(directory.numbers(273, 3), (std::vector<std::uint64_t>{5, 6, 7}));
  EXPECT_EQ(directory.numbers(279, 9), (std::vector<std::uint64_t>{5, 6}));
  EXPECT_EQ(directory.numbers(279, 1), (std::vector<std::uint64_t>{5}));
  EXPECT_TRUE(directory.numbers(325, 9).empty());
  EXPECT_TRUE(directory.numbers(999, 9).empty());
  EXPECT_THROW(directory.numbers(324, 9), Error);
}

TEST(TiffDirectory, GivesTheLengthOfTheLongestTextThatFits) {
  const TempFolder folder;
  const std::vector<DirectoryEntry> entries = {
      {270, 2, 30, 100}, {305, 2, 90, 100}, {306, 2, 5000, 100}, {273, 4, 200, 100}};
  write_file(folder.file("a"), directory_file(entries, false, false, std::string(300, 'x')));
  const SourceFile file(folder.file("a"));
  EXPECT_EQ(TiffDirectory(file, 16, false).longest_text(), 90U);
}

TEST(TiffDirectory, LeavesOutTextsThatAreCutOrHuge) {
  const TempFolder folder;
  const std::string rest(2000000, 'x');
  const std::vector<DirectoryEntry> entries = {
      {270, 2, 100, 2000000 + 100}, {270, 2, 100, std::numeric_limits<std::uint64_t>::max()},
      {270, 2, std::numeric_limits<std::uint64_t>::max(), 100}, {270, 2, (1 << 20) + 1, 1000},
      {270, 2, 0, 0}};
  write_file(folder.file("a"), directory_file(entries, true, false, rest));
  const SourceFile file(folder.file("a"));
  EXPECT_TRUE(TiffDirectory(file, 16, false).texts(270, 0).empty());
  const std::vector<DirectoryEntry> many(100, {270, 2, 100, 1300});
  write_file(folder.file("b"), directory_file(many, false, false, rest));
  const SourceFile other(folder.file("b"));
  EXPECT_EQ(TiffDirectory(other, 16, false).texts(270, 0).size(), 8U);
}

TEST(TiffDirectory, ThatIsCutIsRejectedWithBothNumbers) {
  const TempFolder folder;
  const std::string whole = directory_file(std::vector<DirectoryEntry>(2), false, false, "");
  write_file(folder.file("a"), whole.substr(0, whole.size() - 1));
  const SourceFile file(folder.file("a"));
  try {
    TiffDirectory(file, 16, false);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, std::to_string(whole.size()))) << error.what();
  }
}

}  // namespace
}  // namespace octavo::testing
