// What the files of a folder say together: the order of a stack by its names, and which of several
// kinds of files is meant.
#include <gtest/gtest.h>

#include <filesystem>

#include "octavo/io/source/stack_names.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

namespace fs = std::filesystem;

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

TEST(StackNames, GapsInTheNumbersAreTold) {
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

TEST(StackNames, NamesThatDoNotCountOnAreTold) {
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

class SourceFolder : public ::testing::Test {
 protected:
  void add_png(const std::string& name, char value) {
    write_png(folder_.file(name), 2, 2, 8, 0, std::string(4, value));
  }
  void expect_rejected(const std::vector<std::string>& words) {
    const Error error = source_error({folder_.path()}, options_);
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    for (const std::string& word : words) {
      EXPECT_TRUE(contains(error.what(), word)) << error.what();
    }
  }

  TempFolder folder_;
  SourceOptions options_;
};

TEST_F(SourceFolder, AStackOfTwoChannelsIsRefusedOrTakenAsTold) {
  for (const char* name : {"z0_c0.png", "z0_c1.png", "z1_c0.png", "z1_c1.png"}) add_png(name, 5);
  expect_rejected({"2 x 2 files", "z0_c0.png", "z1_c1.png", "name the files of one", "--on-gap"});
  options_.on_gap = GapPolicy::ignore;
  const auto source = open_source({folder_.path()}, options_);
  EXPECT_EQ(source->description().size, (Size3{2, 2, 4}));
  EXPECT_TRUE(contains(source->description().metadata_json, "\"ignored_number_gaps\":1"));
  EXPECT_TRUE(contains(source->warnings()[0], "taken as neighbors"));
}

TEST_F(SourceFolder, NumbersInTheNamesOfFoldersCount) {
  std::vector<std::string> files;
  for (const char* name : {"s9/plane.png", "s10/plane.png", "s11/plane.png", "s13/plane.png"}) {
    add_png(name, 5);
    files.push_back(folder_.file(name));
  }
  const Error error = source_error(files, options_);
  EXPECT_TRUE(contains(error.what(), "s11/plane.png is followed by s13/plane.png")) << error.what();
  files.pop_back();
  EXPECT_EQ(open_source(files, options_)->description().size.z, 3);
}

TEST_F(SourceFolder, AStrayNameInAStackIsRefused) {
  for (const char* name : {"s1.png", "s2.png", "s2_mask.png", "s3.png"}) add_png(name, 5);
  expect_rejected({"s2.png is followed by s2_mask.png", "no number", "1 more such place"});
}

TEST_F(SourceFolder, RawPlanesWhoseNumbersSkipAreRefusedOrTakenAsTold) {
  for (const char* name : {"z1", "z2", "z4"}) write_file(folder_.file(name), "abcd");
  options_.raw = parse_raw_layout("2,2,3,uint8");
  expect_rejected({"z2 is followed by z4", "1 file is missing", "--on-gap ignore"});
  options_.on_gap = GapPolicy::ignore;
  EXPECT_EQ(voxels_of(*open_source({folder_.path()}, options_)), "abcdabcdabcd");
  options_.raw = parse_raw_layout("2,2,1,uint8");
  EXPECT_EQ(source_error({folder_.file("z1")}, options_).kind(), ErrorKind::invalid_argument);
}

TEST_F(SourceFolder, FilesOfSeveralKindsAreRefused) {
  add_png("preview.png", 1);
  write_file(folder_.file("scan.nii.gz"), "anything");
  expect_rejected({"1 PNG file (preview.png) and 1 volume (scan.nii.gz)", "name the file"});
  TiffSample sample;
  sample.pages = {std::string(12, 'x')};
  write_tiff(folder_.file("s1.tif"), sample);
  write_tiff(folder_.file("s2.tif"), sample);
  expect_rejected({"2 TIFF files (s1.tif ...), 1 PNG file (preview.png) and 1 volume"});
}

TEST_F(SourceFolder, DicomBelowOtherFilesIsRefusedAndBesideThemTaken) {
  add_png("s1.png", 1);
  DicomSample sample;
  sample.position = "0\\0\\0";
  write_dicom(folder_.file("below/slice"), sample);
  expect_rejected({"1 PNG file (s1.png) and DICOM files in folders of it", "below/slice"});
  write_dicom(folder_.file("slice.dcm"), sample);
  fs::remove_all(folder_.file("below"));
  EXPECT_EQ(open_source({folder_.path()}, options_)->description().size.z, 1);
}

TEST_F(SourceFolder, ALinkToNothingIsNotPassedOver) {
  add_png("s1.png", 1);
  fs::create_symlink("gone.png", folder_.file("s2.png"));
  const Error error = source_error({folder_.path()}, options_);
  EXPECT_EQ(error.kind(), ErrorKind::io);
  EXPECT_TRUE(contains(error.what(), "s2.png") && contains(error.what(), "link")) << error.what();
  // Links to files are followed.
  add_png(".gone.png", 2);
  fs::remove(folder_.file("s2.png"));
  fs::create_symlink(".gone.png", folder_.file("s2.png"));
  EXPECT_EQ(open_source({folder_.path()}, options_)->description().size.z, 2);
}

}  // namespace
}  // namespace octavo::testing
