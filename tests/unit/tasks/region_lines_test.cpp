#include "octavo/tasks/region_lines.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/tasks/files/part_result.h"

namespace octavo {
namespace {

/// A region of three floats.
JsonObject line_of_region() {
  PartOfRegions regions;
  RegionSums& sums = regions[7].sums;
  sums.moments.add_box({{1, 2, 3}, {4, 3, 4}});
  for (const float value : {-0.5f, 3.25f, 1e30f}) sums.floats.add(value);
  return lines_of_regions(regions).front();
}

bool is_taken(const JsonObject& line) {
  try {
    regions_of_lines(std::vector<JsonObject>{line});
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
    return false;
  }
}

/// The line with one of the numbers of a list replaced.
JsonObject changed(const std::string& name, std::size_t size, std::size_t at, std::int64_t to) {
  JsonObject line = line_of_region();
  std::vector<std::int64_t> numbers = integers_in(line, name, size);
  numbers[at] = to;
  line.set(name, numbers);
  return line;
}

TEST(RegionLines, SumsAreThoseThatWereWritten) {
  const JsonObject line = line_of_region();
  const PartOfRegions again = regions_of_lines(std::vector<JsonObject>{line});
  EXPECT_EQ(again.at(7).sums.moments.count, 3u);
  EXPECT_EQ(lines_of_regions(again).front().text(), line.text());
}

TEST(RegionLines, DigitsThatWouldOverflowAreRejected) {
  constexpr std::int64_t kBase = std::int64_t{1} << 32;
  constexpr std::int64_t kLowest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kHighest = std::numeric_limits<std::int64_t>::max();
  const std::pair<std::string, std::size_t> lists[] = {
      {"float_sum", ExactSum::kSumDigits}, {"float_squares", ExactSum::kSquareDigits}};
  for (const auto& [name, size] : lists) {
    for (const std::size_t at : {std::size_t{0}, size - 2}) {
      EXPECT_TRUE(is_taken(changed(name, size, at, 0)));
      EXPECT_TRUE(is_taken(changed(name, size, at, kBase - 1)));
      EXPECT_FALSE(is_taken(changed(name, size, at, -1)));
      EXPECT_FALSE(is_taken(changed(name, size, at, kBase)));
    }
    EXPECT_TRUE(is_taken(changed(name, size, size - 1, -1)));
    for (const std::int64_t far : {kLowest, kHighest}) {
      EXPECT_FALSE(is_taken(changed(name, size, 0, far)));
      EXPECT_FALSE(is_taken(changed(name, size, size - 1, far)));
    }
  }
}

TEST(RegionLines, CountsAndSumsNoPartHasAreRejected) {
  for (std::size_t at = 0; at < 9; ++at) EXPECT_FALSE(is_taken(changed("counts", 9, at, -1)));
  EXPECT_FALSE(is_taken(changed("counts", 9, 0, std::int64_t{1} << 62)));
  EXPECT_TRUE(is_taken(changed("counts", 9, 2, 3)));
  EXPECT_FALSE(is_taken(changed("counts", 9, 1, 4)));
  EXPECT_FALSE(is_taken(changed("counts", 9, 2, 4)));
  for (int number = 0; number < 11; ++number) {
    for (const char* const first : {"7", "8"}) {
      JsonObject line = line_of_region();
      line.set("sum" + std::to_string(number), first + std::string(31, '0'));
      EXPECT_FALSE(is_taken(line)) << number;
    }
  }
}

}  // namespace
}  // namespace octavo
