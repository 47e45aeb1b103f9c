// What is settled for every format: spacings that are missing, places, gaps between numbered files.
#include "octavo/io/source/described_source.h"

#include <gtest/gtest.h>

#include "support/dicom_samples.h"
#include "support/image_folder.h"
#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

// A volume at the origin along the axes of LPS looks like one of which nothing is known.
TEST(DescribedSource, AxesThatAreStatedPlaceTheVolumeWhateverTheyAre) {
  const auto metadata = [](const std::string& path) {
    return open_source({path}, {})->description().metadata.text();
  };
  const TempFolder folder;
  NiftiSample nifti;
  nifti.srow = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 2, 0};
  write_file(folder.file("a.nii"), nifti_header(nifti) + std::string(48, 'v'));
  EXPECT_TRUE(contains(metadata(folder.file("a.nii")), "\"place_known\":true"));
  nifti.sform = 0;
  write_file(folder.file("a.nii"), nifti_header(nifti) + std::string(48, 'v'));
  EXPECT_TRUE(contains(metadata(folder.file("a.nii")), "\"place_known\":false"));
  const std::string matrix = "TransformMatrix = 1 0 0 0 1 0 0 0 1\n";
  for (const auto& [lines, expected] : std::vector<std::pair<std::string, std::string>>{
           {matrix + "AnatomicalOrientation = RAI\n", "\"place_known\":true"},
           {matrix + "AnatomicalOrientation = ???\n", "\"place_known\":false"},
           {matrix + "AnatomicalOrientation = ??\n", "\"place_known\":false"},
           {matrix, ""},
           {"AnatomicalOrientation = RAI\n", ""}}) {
    write_file(folder.file("a.mha"), "ObjectType = Image\nNDims = 3\n" + lines +
                                         "ElementSpacing = 1 1 1\nDimSize = 2 2 2\n"
                                         "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                                         std::string(8, 'v'));
    EXPECT_EQ(contains(metadata(folder.file("a.mha")), "place_known"), !expected.empty()) << lines;
    EXPECT_TRUE(contains(metadata(folder.file("a.mha")), expected)) << lines;
  }
}

/// What stands in the metadata under "spacing_source".
std::string spacing_source(PlaneSource& source) {
  const std::string& metadata = source.description().metadata.text();
  for (const char* kind : {"file", "user", "assumed"}) {
    if (contains(metadata, std::string("\"spacing_source\":\"") + kind + "\"")) return kind;
  }
  return "nothing";
}

TEST(DescribedSource, AMissingSpacingIsReportedAskedForAndRecordedInEveryFormat) {
  const TempFolder folder;
  const std::string voxels(24, '\1');
  NiftiSample sample;
  sample.sform = 0;
  std::string nifti = nifti_header(sample) + bytes_of(kStoredValues);
  nifti.replace(76, 16, std::string(16, '\0'));
  write_file(folder.file("a.nii"), nifti);
  write_file(folder.file("a.nrrd"),
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n\n" + voxels);
  write_file(folder.file("nan.nrrd"),
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n"
             "spacings: nan nan nan\n\n" + voxels);
  write_file(folder.file("a.mha"), "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n"
                                   "ElementDataFile = LOCAL\n" + voxels);
  TiffSample tiff;
  tiff.pages = {std::string(12, '\1'), std::string(12, '\1')};
  write_tiff(folder.file("a.tif"), tiff);
  write_png(folder.file("png/1.png"), 4, 3, 8, 0, std::string(12, '\1'));
  write_png(folder.file("png/2.png"), 4, 3, 8, 0, std::string(12, '\1'));
  write_file(folder.file("a.raw"), voxels);
  for (const char* name : {"a.nii", "a.nrrd", "nan.nrrd", "a.mha", "a.tif", "png", "a.raw"}) {
    SCOPED_TRACE(name);
    SourceOptions options;
    if (std::string(name) == "a.raw") options.raw = parse_raw_layout("4,3,2,uint8");
    const auto assumed = open_source({folder.file(name)}, options);
    EXPECT_EQ(spacing_source(*assumed), "assumed");
    EXPECT_TRUE(contains(with_hints(assumed->warnings()),
                         "spacing is not in the files: 1 mm assumed [spacing_mm]"));
    EXPECT_EQ(assumed->description().geometry.spacing_mm, (Point3{1, 1, 1}));
    options.spacing_mm = Point3{0.5, 0.6, 0.7};
    const auto given = open_source({folder.file(name)}, options);
    EXPECT_EQ(spacing_source(*given), "user");
    EXPECT_FALSE(contains(with_hints(given->warnings()), "assumed; give"));
    EXPECT_EQ(given->description().geometry.spacing_mm, (Point3{0.5, 0.6, 0.7}));
  }
  DicomSample slice;
  write_dicom(folder.file("a.dcm"), slice);
  EXPECT_TRUE(contains(source_error({folder.file("a.dcm")}), "[spacing_mm]"));
  slice.position = "0\\0\\0";
  write_dicom(folder.file("a.dcm"), slice);
  EXPECT_EQ(spacing_source(*open_source({folder.file("a.dcm")}, {})), "file");
}

TEST(DescribedSource, NumbersThatSkipAreRejectedWithBothNamesOrIgnored) {
  for (const bool is_tiff : {true, false}) {
    const TempFolder folder;
    std::string expected;
    for (const int number : {8, 9, 11, 12}) {
      const std::string name = "half MB_ " + std::to_string(number);
      TiffSample sample;
      sample.pages = {counted(12, number)};
      expected += sample.pages[0];
      if (is_tiff) write_tiff(folder.file(name + ".tif"), sample);
      if (!is_tiff) write_png(folder.file(name + ".png"), 4, 3, 8, 0, sample.pages[0]);
    }
    const Error error = source_error({folder.path()});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    for (const char* word : {"half MB_ 9.", "half MB_ 11.", "1 file is missing", "[on_gap="}) {
      EXPECT_TRUE(contains(error, word)) << error.what();
    }
    SourceOptions options;
    options.on_gap = GapPolicy::ignore;
    const auto source = open_source({folder.path()}, options);
    EXPECT_EQ(voxels_of(*source), expected);
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"ignored_number_gaps\":1"));
    EXPECT_TRUE(contains(source->warnings()[0], "half MB_ 11."));
    options.on_gap = GapPolicy::fill;
    EXPECT_EQ(source_error({folder.path()}, options).kind(), ErrorKind::invalid_argument);
  }
}

using NumberedFiles = ImageFolder;

TEST_F(NumberedFiles, AStackOfTwoChannelsIsRejectedOrTakenAsAsked) {
  for (const char* name : {"z0_c0.png", "z0_c1.png", "z1_c0.png", "z1_c1.png"}) add_png(name, 5);
  expect_rejected({"2 x 2 files", "z0_c0.png", "z1_c1.png", "name the files of one", "[on_gap="});
  options_.on_gap = GapPolicy::ignore;
  const auto source = open_source({folder_.path()}, options_);
  EXPECT_EQ(source->description().size, (Size3{2, 2, 4}));
  EXPECT_TRUE(contains(source->description().metadata.text(), "\"ignored_number_gaps\":1"));
  EXPECT_TRUE(contains(source->warnings()[0], "taken as neighbors"));
}

TEST_F(NumberedFiles, NumbersInTheNamesOfFoldersCount) {
  std::vector<std::string> files;
  for (const char* name : {"s9/plane.png", "s10/plane.png", "s11/plane.png", "s13/plane.png"}) {
    add_png(name, 5);
    files.push_back(folder_.file(name));
  }
  const Error error = source_error(files, options_);
  EXPECT_TRUE(contains(error, "s11/plane.png is followed by s13/plane.png")) << error.what();
  files.pop_back();
  EXPECT_EQ(open_source(files, options_)->description().size.z, 3);
}

TEST_F(NumberedFiles, AStrayNameInAStackIsRejected) {
  for (const char* name : {"s1.png", "s2.png", "s2_mask.png", "s3.png"}) add_png(name, 5);
  expect_rejected({"s2.png is followed by s2_mask.png", "no number", "1 more such place"});
}

TEST_F(NumberedFiles, RawPlanesWhoseNumbersSkipAreRejectedOrTakenAsAsked) {
  for (const char* name : {"z1", "z2", "z4"}) write_file(folder_.file(name), "abcd");
  options_.raw = parse_raw_layout("2,2,3,uint8");
  expect_rejected({"z2 is followed by z4", "1 file is missing", "[on_gap=ignore]"});
  options_.on_gap = GapPolicy::ignore;
  EXPECT_EQ(voxels_of(*open_source({folder_.path()}, options_)), "abcdabcdabcd");
  options_.raw = parse_raw_layout("2,2,1,uint8");
  EXPECT_EQ(source_error({folder_.file("z1")}, options_).kind(), ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo::testing
