#include "octavo/io/source/data_files.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

std::vector<std::string> names_of(const NumberedNames& numbered) {
  const DataFileNames names = DataFileNames::of_pattern(numbered);
  std::vector<std::string> all;
  for (std::uint64_t i = 0; i < names.count(); ++i) all.push_back(names.name(i));
  return all;
}

TEST(DataFiles, PatternsNumberFilesAsPrintf) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(names_of({"a%d.raw", 9, 11, 1}), (Names{"a9.raw", "a10.raw", "a11.raw"}));
  EXPECT_EQ(names_of({"%03i", -1, 1, 1}), (Names{"-01", "000", "001"}));
  EXPECT_EQ(names_of({"%3u.z", 5, 5, 7}), (Names{"  5.z"}));
  EXPECT_EQ(names_of({"%d", 7, 2, -2}), (Names{"7", "5", "3"}));
  EXPECT_EQ(names_of({"%d", 1, 0, 1}), Names{});
  EXPECT_EQ(names_of({"%d", 1, 5, 0}), Names{});
  for (const char* name : {"a.raw", "50%.raw", "a%s.raw", "a%d%d.raw", "a%", "a%05", "%100d", "%n",
                           "%5%d", "%-3d", "%ld"}) {
    EXPECT_FALSE(has_number_pattern(name)) << name;
  }
}

TEST(DataFiles, ClaimsOfManyNamesCostNothing) {
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(DataFileNames::of_pattern({"%d", kMin, kMax, 1}).count(),
            std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(names_of({"%d", kMax, kMin, kMin}),
            (std::vector<std::string>{"9223372036854775807", "-1"}));
  EXPECT_EQ(names_of({"%d", kMin, kMax, kMax}),
            (std::vector<std::string>{"-9223372036854775808", "-1", "9223372036854775806"}));
  const TempFolder folder;
  const std::string header = folder.file("a.nhdr");
  const std::vector<std::int64_t> sizes = {4, 3, 2};
  for (const std::int64_t dimension : {2, 3}) {
    const Error error = error_of([&] {
      find_data_files(header, DataFileNames::of_pattern({"%d", 0, kMax, 1}), sizes, dimension);
    });
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, "9223372036854775808")) << error.what();
  }
}

TEST(DataFiles, HoldOneIndexOfTheOtherAxesOrARunOfTheLast) {
  const TempFolder folder;
  for (const char* name : {"1", "2", "3", "4", "5", "6"}) write_file(folder.file(name), "x");
  const std::string header = folder.file("a.nhdr");
  const std::vector<std::int64_t> sizes = {4, 3, 6};
  const auto count = [&](std::int64_t last, std::int64_t dimension) {
    return find_data_files(header, DataFileNames::of_pattern({"%d", 1, last, 1}), sizes, dimension)
        .size();
  };
  EXPECT_EQ(count(6, 2), 6u);
  for (const std::int64_t files : {1, 2, 3, 6}) {
    EXPECT_EQ(count(files, 3), static_cast<std::size_t>(files));
  }
  for (const auto& [last, dimension] : std::vector<std::pair<std::int64_t, std::int64_t>>{
           {5, 2}, {7, 2}, {0, 2}, {4, 3}, {5, 3}, {0, 3}, {6, 1}, {6, 0}, {6, 4}, {6, -1}}) {
    EXPECT_THROW(count(last, dimension), Error) << last << ' ' << dimension;
  }
}

TEST(DataFiles, OfAListStandOneALine) {
  const DataFileNames names = DataFileNames::of_list(" a b.raw\r\n\n\tc/d.raw \n\nlast");
  ASSERT_EQ(names.count(), 3u);
  EXPECT_EQ(names.name(0), "a b.raw");
  EXPECT_EQ(names.name(1), "c/d.raw");
  EXPECT_EQ(names.name(2), "last");
  EXPECT_EQ(DataFileNames::of_list("").count(), 0u);
}

}  // namespace
}  // namespace octavo::testing
