// What the files of a folder say together: the order of a stack by its names, and which of several
// kinds of files is meant.
#include <gtest/gtest.h>


#include "octavo/io/source/stack_names.h"
#include "support/source_files.h"

namespace octavo::testing {namespace {

TEST(StackNames, NamesInWhichANumberCountsHaveNoGap) {
  for (const std::vector<std::string>& names : std::vector<std::vector<std::string>>{
           {"alone"},
           {"s1", "s2", "s3"},
           {"s10", "s20", "s30"},
           {"s1.tif", "s2.tiff", "s3.TIF"},
           {"scan.1", "scan.2", "scan.3"},
           {"20261230_235959_001", "20261231_000003_002", "20261231_000013_003"},
           {"1.3.6.1.4.1.14519.5.2.1.179049373636438705059720603192_008",
            "1.3.6.1.4.1.14519.5.2.1.179049373636438705059720603192_009"},
           {"s0/plane.tif", "s1/plane.tif", "s2/plane.tif"},
           {"a0_1", "a1_0", "a2_1", "a3_0"}}) {
    EXPECT_TRUE(number_gaps(names).empty()) << names.front();
    EXPECT_FALSE(number_grid(names)) << names.front();
  }
}

TEST(StackNames, GapsInTheNumbersAreReported) {
  const std::vector<NumberGap> gaps = number_gaps({"s1", "s2", "s4", "s5", "s9"});
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_EQ(gaps[0].before, 1U);
  EXPECT_EQ(gaps[0].missing, 1U);
  EXPECT_EQ(gaps[1].before, 3U);
  EXPECT_EQ(gaps[1].missing, 3U);
  // Beside a time that rises as well.
  const std::vector<NumberGap> timed = number_gaps({"t10_1", "t13_2", "t20_4", "t21_5"});
  ASSERT_EQ(timed.size(), 1U);
  EXPECT_EQ(timed[0].before, 1U);
  EXPECT_EQ(timed[0].missing, 1U);
}

TEST(StackNames, NamesThatDoNotCountOnAreReported) {
  struct Case {
    std::vector<std::string> names;
    std::vector<std::size_t> breaks;
  };
  const std::string huge(19, '9');
  for (const Case& c : std::vector<Case>{{{"left", "right"}, {0}},
                                         {{"s1", "s01", "s001"}, {0, 1}},
                                         {{"s1", "s2", "s2 (1)", "s3"}, {1, 2}},
                                         {{"s1", "s2", "s3_mask"}, {1}},
                                         {{"z-5", "z-10", "z0", "z5"}, {1}},
                                         {{"z0.5", "z0.25", "z1.0"}, {1}},
                                         {{"s1", "s2", "s3", "s7", "t8"}, {3}},
                                         {{"a1", "a" + huge}, {0}},
                                         {{"z0_c0", "z0_c1", "z1_c1"}, {1}}}) {
    const std::vector<NumberGap> gaps = number_gaps(c.names);
    std::vector<std::size_t> breaks;
    for (const NumberGap& gap : gaps) {
      EXPECT_FALSE(gap.is_counted) << c.names.back();
      breaks.push_back(gap.before);
    }
    EXPECT_EQ(breaks, c.breaks) << c.names.back();
    EXPECT_FALSE(number_grid(c.names)) << c.names.back();
  }
}

TEST(StackNames, EveryPairOfTwoNumbersIsAGrid) {
  const std::vector<std::string> names = {"z0_c0", "z0_c1", "z1_c0", "z1_c1", "z2_c0", "z2_c1"};
  EXPECT_EQ(number_gaps(names).size(), 2U);
  const auto grid = number_grid(names);
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->outer, 3U);
  EXPECT_EQ(grid->inner, 2U);
}

}  // namespace
}  // namespace octavo::testing
