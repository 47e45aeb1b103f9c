// Which files planes are read from, straight and through sources that wrap others.
#include "octavo/planes/plane_files.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "octavo/builder/float_planes.h"
#include "octavo/planes/between/isotropic_source.h"
#include "octavo/planes/memory_source.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(PlaneFiles, AVolumeNamesEachFileOnceAndNoUrl) {
  const PlaneFiles files = files_of_volume({"/a.hdr", "/a.img", "/a.hdr", "https://host/a.8vo"});
  EXPECT_EQ(files.paths, (std::vector<std::string>{"/a.hdr", "/a.img"}));
  EXPECT_TRUE(files.of_plane.empty());
  EXPECT_EQ(files_of_planes(files, 3, 4), (FileRange{0, 2}));
  EXPECT_TRUE(files_of_planes(files, 3, 3).is_empty());
}

TEST(PlaneFiles, PathsAreAbsoluteAndOtherwiseAsTheyWereGiven) {
  const std::string folder = std::filesystem::current_path().string();
  EXPECT_EQ(files_of_volume({"../b"}).paths, std::vector<std::string>{folder + "/../b"});
  EXPECT_EQ(files_of_slices({"./c", "/d"}).paths,
            (std::vector<std::string>{folder + "/./c", "/d"}));
}

TEST(PlaneFiles, SlicesNameTheFileOfEach) {
  const PlaneFiles files = files_of_slices({"/c", "/a", "/a", "/c", "/b"});
  EXPECT_EQ(files.paths, (std::vector<std::string>{"/c", "/a", "/b"}));
  EXPECT_EQ(files.of_plane,
            (std::vector<FileRange>{{0, 1}, {1, 2}, {1, 2}, {0, 1}, {2, 3}}));
  EXPECT_EQ(files_of_planes(files, 1, 3), (FileRange{1, 2}));
  EXPECT_EQ(files_of_planes(files, 2, 4), (FileRange{0, 2}));
  EXPECT_EQ(files_of_planes(files, 0, 5), (FileRange{0, 3}));
}

TEST(PlaneFiles, ARangeWithoutFilesAddsNone) {
  EXPECT_EQ(joined({}, {3, 4}), (FileRange{3, 4}));
  EXPECT_EQ(joined({3, 4}, {7, 7}), (FileRange{3, 4}));
  EXPECT_EQ(joined({5, 6}, {2, 3}), (FileRange{2, 6}));
}

class WrappedFiles : public ::testing::Test {
 protected:
  WrappedFiles() {
    for (const char* name : {"0.raw", "1.raw", "2.raw"}) {
      paths_.push_back(folder_.file(name));
      write_file(paths_.back(), bytes_of(std::vector<float>(12, 1.5f)));
    }
    options_.raw = RawLayout{{4, 3, 3}, VoxelType::float32, false, 0};
    options_.spacing_mm = Point3{1, 1, 2};
  }

  TempFolder folder_;
  std::vector<std::string> paths_;
  SourceOptions options_;
};

TEST_F(WrappedFiles, AnIsotropicPlaneIsMadeOfTheFilesOfItsSlices) {
  auto slices = open_source(paths_, options_);
  const IsotropicPlan plan = plan_isotropic(slices->description(), PlaneInterpolation::linear);
  const auto source = make_isotropic_source(std::move(slices), plan);
  EXPECT_EQ(source->files().paths, paths_);
  EXPECT_EQ(source->files().of_plane,
            (std::vector<FileRange>{{0, 1}, {0, 2}, {1, 2}, {1, 3}, {2, 3}}));
}

TEST_F(WrappedFiles, FloatsAreOfTheFilesOfTheirSource) {
  const auto source = open_source(paths_, options_);
  NoProgress progress;
  const FloatPlanes floats(*source, {0.1, {}, 2}, progress);
  EXPECT_EQ(floats.files(), source->files());
  const auto repaired = make_repaired_source(*source, {.nan = 0.0f, .infinity = {}});
  EXPECT_EQ(repaired->files(), source->files());
  EXPECT_EQ(repaired->files().paths, paths_);
}

TEST(PlaneFiles, VoxelsInMemoryAreOfNoFile) {
  VolumeDescription description;
  description.size = {1, 1, 1};
  const std::vector<std::byte> voxels(1);
  EXPECT_EQ(make_memory_source(description, voxels)->files(), PlaneFiles{});
}

}  // namespace
}  // namespace octavo::testing
