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

TEST(OpenSource, VoxelsBesideAHeaderOfAnotherFormatAreHeaderless) {
  const TempFolder folder;
  write_file(folder.file("a.img"), bytes_of(kStoredValues));
  write_file(folder.file("a.hdr"), "ENVI\nsamples = 4\nlines = 3\nbands = 2\ndata type = 12\n");
  EXPECT_EQ(source_error({folder.file("a.img")}).field(), "raw");
  fs::remove(folder.file("a.hdr"));
  fs::create_symlink("a.hdr", folder.file("a.hdr"));
  EXPECT_EQ(source_error({folder.file("a.img")}).field(), "raw");
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

TEST(OpenSource, ASeriesIsChosenWhereThereAreSome) {
  const TempFolder folder;
  write_png(folder.file("a.png"), 2, 2, 8, 0, "abcd");
  TiffSample sample;
  sample.pages = {counted(12, 0)};
  write_tiff(folder.file("t/s1.tif"), sample);
  write_tiff(folder.file("t/s2.tif"), sample);
  SourceOptions options;
  options.series = "0";
  for (const auto& [path, said] : std::vector<std::pair<std::string, std::string>>{
           {folder.file("a.png"), "in DICOM and TIFF alone"},
           {folder.file("t"), "in a single TIFF file"}}) {
    const Error error = source_error({path}, options);
    EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
    EXPECT_EQ(error.field(), "series");
    EXPECT_TRUE(contains(error, said)) << error.what();
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

// --- Files that a source is read from

PlaneFiles files_of(const std::vector<std::string>& paths, const SourceOptions& options = {}) {
  return open_source(paths, options)->files();
}

TEST(OpenSource, AVolumeNamesItsHeaderAndItsData) {
  const TempFolder folder;
  const std::string voxels = bytes_of(kStoredValues);
  const std::string meta =
      "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nElementDataFile = ";
  const std::string nrrd =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: raw\n";
  std::string pair = nifti_header({});
  pair.replace(108, 4, bytes_of(std::vector<float>{0}));
  pair.replace(344, 4, std::string("ni1\0", 4));
  const struct {
    std::string name, header, data;
  } table[] = {{"a.nii", nifti_header({}) + voxels, ""},
               {"b.nii.gz", gzip(nifti_header({}) + voxels), ""},
               {"c.hdr", pair, "c.img"},
               {"d.mha", meta + "LOCAL\n" + voxels, ""},
               {"e.mhd", meta + "data/e.raw\n", "data/e.raw"},
               {"f.nrrd", nrrd + "\n" + voxels, ""},
               {"g.nhdr", nrrd + "data file: g.raw\n", "g.raw"},
               {"h.vtk",
                "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\n"
                "DIMENSIONS 4 3 2\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 24\n"
                "SCALARS v short 1\nLOOKUP_TABLE default\n" + voxels,
                ""}};
  for (const auto& [name, header, data] : table) {
    std::vector<std::string> expected = {folder.file(name)};
    write_file(expected.front(), header);
    if (!data.empty()) {
      expected.push_back(folder.file(data));
      write_file(expected.back(), voxels);
    }
    const PlaneFiles files = files_of({folder.file(name)});
    EXPECT_EQ(files.paths, expected);
    EXPECT_TRUE(files.of_plane.empty()) << name;
  }
}

TEST(OpenSource, VoxelsOfAPairAreToldOfTheirHeader) {
  const TempFolder folder;
  std::string pair = nifti_header({});
  pair.replace(344, 4, std::string("ni1\0", 4));
  std::string analyze = nifti_header({});
  analyze.replace(344, 4, std::string(4, '\0'));
  std::string big_analyze = nifti_header({.big_endian = true});
  big_analyze.replace(344, 4, std::string(4, '\0'));
  const std::string of_analyze = "an Analyze 7.5 header, which does not say where left and right";
  const std::string unknown = "not a DICOM, TIFF";
  const struct {
    std::string name, header, said;
  } table[] = {{"a", pair, "whose header stands beside it; give that, " + folder.file("a.hdr")},
               {"b", analyze, of_analyze},
               {"c", big_analyze, of_analyze},
               {"d", "ENVI\nsamples = 4\n" + std::string(400, ' '), unknown},
               {"e", "ENVI", unknown},
               {"f", "", unknown}};
  for (const auto& [name, header, said] : table) {
    write_file(folder.file(name + ".img"), bytes_of(kStoredValues));
    write_file(folder.file(name + ".img.gz"), gzip(bytes_of(kStoredValues)));
    write_file(folder.file(name + ".hdr"), header);
    write_file(folder.file(name + ".hdr.gz"), gzip(header));
    EXPECT_TRUE(contains(source_error({folder.file(name + ".img")}), said)) << name;
    const std::string compressed = said.substr(0, said.find(", /"));
    EXPECT_TRUE(contains(source_error({folder.file(name + ".img.gz")}), compressed)) << name;
  }
  write_file(folder.file("g.img"), bytes_of(kStoredValues));
  EXPECT_TRUE(contains(source_error({folder.file("g.img")}), unknown));
}

TEST(OpenSource, FilesHaveAbsolutePaths) {
  const TempFolder folder;
  write_file(folder.file("a.nii"), nifti_header({}) + bytes_of(kStoredValues));
  const fs::path relative = fs::relative(folder.file("a.nii"));
  ASSERT_TRUE(relative.is_relative());
  EXPECT_EQ(files_of({relative.string()}).paths,
            std::vector<std::string>{(fs::current_path() / relative).string()});
}

TEST(OpenSource, RawVoxelsNameTheirFiles) {
  const TempFolder folder;
  SourceOptions options;
  options.raw = RawLayout{{4, 3, 2}, VoxelType::uint8, false, 0};
  write_file(folder.file("all.raw"), counted(24, 0));
  EXPECT_EQ(files_of({folder.file("all.raw")}, options).paths,
            std::vector<std::string>{folder.file("all.raw")});
  const std::vector<std::string> planes = {folder.file("p9.raw"), folder.file("p10.raw")};
  for (const std::string& path : planes) write_file(path, counted(12, 0));
  const PlaneFiles files = files_of({planes[1], planes[0]}, options);
  EXPECT_EQ(files.paths, planes);
  EXPECT_EQ(files.of_plane, (std::vector<FileRange>{{0, 1}, {1, 2}}));
}

// In the natural order, not in that of bytes; of a folder and of files given in any order.
TEST(OpenSource, PicturesNameTheFileOfEachPlane) {
  const TempFolder folder;
  for (const char* ending : {"png", "tif"}) {
    const std::vector<std::string> planes = {folder.file(std::string(ending) + "/s9." + ending),
                                             folder.file(std::string(ending) + "/s10." + ending),
                                             folder.file(std::string(ending) + "/s11." + ending)};
    for (const std::string& path : planes) {
      TiffSample sample;
      sample.pages = {std::string(12, 'x')};
      if (path.ends_with("tif")) write_tiff(path, sample);
      else write_png(path, 4, 3, 8, 0, std::string(12, 'x'));
    }
    const std::vector<FileRange> one_each = {{0, 1}, {1, 2}, {2, 3}};
    const std::vector<std::string> mixed = {planes[2], planes[0], planes[1]};
    for (const auto& paths : {std::vector{folder.file(ending)}, mixed}) {
      const PlaneFiles files = files_of(paths);
      EXPECT_EQ(files.paths, planes);
      EXPECT_EQ(files.of_plane, one_each) << ending;
    }
  }
}

TEST(OpenSource, PagesOfOneChannelAreAllOfOneFile) {
  const TempFolder folder;
  TiffSample sample;
  sample.description = "ImageJ=1.53\nimages=4\nchannels=2\nslices=2\nhyperstack=true\n";
  sample.pages = std::vector<std::string>(4, std::string(12, 'x'));
  write_tiff(folder.file("a.tif"), sample);
  SourceOptions options;
  options.channel = "1";
  const PlaneFiles files = files_of({folder.file("a.tif")}, options);
  EXPECT_EQ(files.paths, std::vector<std::string>{folder.file("a.tif")});
  EXPECT_EQ(files.of_plane, (std::vector<FileRange>{{0, 1}, {0, 1}}));
}

class DicomFiles : public ::testing::Test {
 protected:
  /// The slices stand in the order of their places, which is not that of their names.
  void write(const std::string& name, const std::string& position) {
    DicomSample sample;
    sample.position = position;
    write_dicom(folder_.file(name), sample);
    expected_.push_back(folder_.file(name));
  }

  TempFolder folder_;
  std::vector<std::string> expected_;
};

TEST_F(DicomFiles, SlicesStandInTheOrderOfPlanes) {
  write("z", "0\\0\\0");
  write("y", "0\\0\\3");
  write("below/a", "0\\0\\6");
  write_file(folder_.file("notes.txt"), "no slice");
  const PlaneFiles files = files_of({folder_.path()});
  EXPECT_EQ(files.paths, expected_);
  EXPECT_EQ(files.of_plane, (std::vector<FileRange>{{0, 1}, {1, 2}, {2, 3}}));
}

TEST_F(DicomFiles, APlaneInAGapIsMadeOfTheSlicesBesideIt) {
  write("z", "0\\0\\0");
  write("y", "0\\0\\3");
  write("a", "0\\0\\9");
  SourceOptions options;
  options.on_gap = GapPolicy::fill;
  const PlaneFiles files = files_of({folder_.path()}, options);
  EXPECT_EQ(files.paths, expected_);
  EXPECT_EQ(files.of_plane, (std::vector<FileRange>{{0, 1}, {1, 2}, {1, 3}, {2, 3}}));
}

TEST_F(DicomFiles, SlicesThatWereMovedStandInTheirFiles) {
  write("z", "0\\0\\0");
  write("y", "0\\1\\3");
  write("a", "0\\2\\6");
  SourceOptions options;
  options.untilt = true;
  const PlaneFiles files = files_of({folder_.path()}, options);
  EXPECT_EQ(files.paths, expected_);
  EXPECT_EQ(files.of_plane, (std::vector<FileRange>{{0, 1}, {1, 2}, {2, 3}}));
}

}  // namespace
}  // namespace octavo::testing
