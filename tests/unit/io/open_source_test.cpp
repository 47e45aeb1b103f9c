#include "octavo/io/open_source.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "support/dicom_samples.h"
#include "support/image_folder.h"
#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

namespace fs = std::filesystem;

TEST(OpenSource, MissingAndUnreadablePathsAreIoErrors) {
  const TempFolder folder;
  EXPECT_EQ(source_error({folder.file("nothing.tif")}).kind(), ErrorKind::io);
  EXPECT_EQ(source_error({"/dev/null"}).kind(), ErrorKind::io);
  EXPECT_EQ(source_error({folder.path()}).kind(), ErrorKind::source_rejected);
  EXPECT_EQ(source_error({}).kind(), ErrorKind::invalid_argument);
}

TEST(OpenSource, AFolderWithOneVolumeIsThatVolume) {
  const TempFolder folder;
  write_file(folder.file("a.nii"), nifti_header({}) + bytes_of(kStoredValues));
  EXPECT_EQ(voxels_of(*open_source({folder.path()}, {})), bytes_of(kStoredValues));
  write_file(folder.file("b.nii"), nifti_header({}) + bytes_of(kStoredValues));
  EXPECT_TRUE(contains(source_error({folder.path()}), "2 volumes"));
}

TEST(OpenSource, ASiblingIsNeverReadInsteadOfTheFileNamed) {
  const TempFolder folder;
  write_file(folder.file("a.nii"), nifti_header({}) + bytes_of(kStoredValues));
  EXPECT_EQ(source_error({folder.file("a.nii.gz")}).kind(), ErrorKind::io);
  EXPECT_EQ(source_error({folder.file("a")}).kind(), ErrorKind::io);
}

using OpenFolder = ImageFolder;

TEST_F(OpenFolder, FilesOfSeveralKindsAreRejected) {
  add_png("preview.png", 1);
  write_file(folder_.file("scan.nii.gz"), "anything");
  expect_rejected({"1 PNG file (preview.png) and 1 volume (scan.nii.gz)", "name the file"});
  TiffSample sample;
  sample.pages = {std::string(12, 'x')};
  write_tiff(folder_.file("s1.tif"), sample);
  write_tiff(folder_.file("s2.tif"), sample);
  expect_rejected({"2 TIFF files (s1.tif ...), 1 PNG file (preview.png) and 1 volume"});
}

TEST_F(OpenFolder, DicomBelowOtherFilesIsRejectedAndBesideThemTaken) {
  add_png("s1.png", 1);
  DicomSample sample;
  sample.position = "0\\0\\0";
  write_dicom(folder_.file("below/slice"), sample);
  expect_rejected({"1 PNG file (s1.png) and DICOM files in folders of it", "below/slice"});
  write_dicom(folder_.file("slice.dcm"), sample);
  fs::remove_all(folder_.file("below"));
  EXPECT_EQ(open_source({folder_.path()}, options_)->description().size.z, 1);
}

TEST(OpenSource, MincIsRejectedWithWhatToDo) {
  const TempFolder folder;
  const std::string hdf5 = std::string("\x89HDF\r\n\x1a\n", 8) + std::string(500, '\0');
  write_file(folder.file("a.mnc"), hdf5);
  write_file(folder.file("b.mnc"), "CDF\1" + std::string(500, '\0'));
  write_file(folder.file("c.mnc.gz"), gzip(hdf5));
  write_file(folder.file("d.h5"), hdf5);
  for (const char* name : {"a.mnc", "b.mnc", "c.mnc.gz", "d.h5"}) {
    expect_rejected(folder.file(name), {"MINC", "mnc2nii"});
  }
}

TEST(OpenSource, OptionsOfDicomAreRejectedForOtherFormats) {
  const TempFolder folder;
  write_png(folder.file("a.png"), 2, 2, 8, 0, "abcd");
  SourceOptions fill;
  fill.on_gap = GapPolicy::fill;
  SourceOptions drop;
  drop.drop_duplicates = true;
  SourceOptions upright;
  upright.untilt = true;
  for (const SourceOptions& options : {fill, drop, upright}) {
    const Error error = source_error({folder.file("a.png")}, options);
    EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
    EXPECT_EQ(error.field(), options.dicom_option());
    EXPECT_TRUE(contains(error, "DICOM series alone")) << error.what();
  }
}

}  // namespace
}  // namespace octavo::testing
