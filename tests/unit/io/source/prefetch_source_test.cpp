// Every format gives any of its planes, read ahead or not, and says whether it has to read those
// before.
#include "octavo/io/source/prefetch_source.h"

#include <gtest/gtest.h>

#include "support/dicom_samples.h"
#include "support/image_samples.h"
#include "support/sought_planes.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// Ten planes of 4 x 3 voxels, each of its own.
constexpr int kPlanes = 10;

std::string plane_of(int z) { return counted(12, z * 5); }

std::string all_planes() {
  std::string all;
  for (int z = 0; z < kPlanes; ++z) all += plane_of(z);
  return all;
}

void expect_sought(const std::vector<std::string>& paths, bool can_seek,
                   const SourceOptions& options = {}) {
  const auto source = open_source(paths, options);
  EXPECT_EQ(source->description().size.z, kPlanes) << paths.front();
  EXPECT_EQ(source->can_seek(), can_seek) << paths.front();
  expect_same_from_anywhere(*source);
  for (const int threads : {1, 3}) {
    const auto ahead = make_prefetch_source(open_source(paths, options), {.threads = threads});
    EXPECT_EQ(ahead->can_seek(), can_seek) << paths.front();
    expect_same_from_anywhere(*ahead);
  }
}

TEST(SoughtPlanes, OfStacksAreReadFromTheirOwnFiles) {
  const TempFolder folder;
  TiffSample pages;
  for (int z = 0; z < kPlanes; ++z) {
    const std::string number = std::to_string(z);
    TiffSample one;
    one.pages = {plane_of(z)};
    pages.pages.push_back(plane_of(z));
    write_tiff(folder.file("tiff/s" + number + ".tif"), one);
    write_png(folder.file("png/s" + number + ".png"), 4, 3, 8, 0, plane_of(z));
    write_file(folder.file("raw/s" + number + ".raw"), plane_of(z));
    DicomSample slice;
    slice.position = "0\\0\\" + std::to_string(z * 2);
    std::vector<std::int16_t> voxels;
    for (int i = 0; i < 12; ++i) voxels.push_back(static_cast<std::int16_t>(z * 100 + i));
    slice.voxels = bytes_of(voxels);
    write_dicom(folder.file("dicom/s" + number), slice);
  }
  write_tiff(folder.file("pages.tif"), pages);
  for (const char* name : {"tiff", "pages.tif", "png", "dicom"}) {
    expect_sought({folder.file(name)}, true);
  }
  SourceOptions raw;
  raw.raw = RawLayout{{4, 3, kPlanes}, VoxelType::uint8, false, 0};
  expect_sought({folder.file("raw")}, true, raw);
}

TEST(SoughtPlanes, OfPlainVolumesAreNotReadThroughTheOnesBefore) {
  const TempFolder folder;
  NiftiSample nifti;
  nifti.size = {4, 3, kPlanes};
  nifti.datatype = 2;
  nifti.bits = 8;
  write_file(folder.file("a.nii"), nifti_header(nifti) + all_planes());
  write_file(folder.file("a.raw"), "head" + all_planes());
  write_file(folder.file("a.vtk"),
             "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\n"
             "DIMENSIONS 4 3 10\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 120\n"
             "SCALARS s unsigned_char 1\nLOOKUP_TABLE default\n" + all_planes());
  expect_sought({folder.file("a.nii")}, true);
  expect_sought({folder.file("a.vtk")}, true);
  SourceOptions raw;
  raw.raw = RawLayout{{4, 3, kPlanes}, VoxelType::uint8, false, 4};
  expect_sought({folder.file("a.raw")}, true, raw);
}

TEST(SoughtPlanes, OfDeflatedAndWrittenVolumesAreReadThroughTheOnesBefore) {
  const TempFolder folder;
  NiftiSample nifti;
  nifti.size = {4, 3, kPlanes};
  nifti.datatype = 2;
  nifti.bits = 8;
  write_file(folder.file("a.nii.gz"), gzip(nifti_header(nifti) + all_planes()));
  std::string numbers;
  for (const char voxel : all_planes()) {
    numbers += std::to_string(static_cast<unsigned char>(voxel)) + " ";
  }
  write_file(folder.file("a.vtk"),
             "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n"
             "DIMENSIONS 4 3 10\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 120\n"
             "SCALARS s unsigned_char 1\nLOOKUP_TABLE default\n" + numbers + "\n");
  expect_sought({folder.file("a.nii.gz")}, false);
  expect_sought({folder.file("a.vtk")}, false);
}

TEST(SoughtPlanes, OfWideNumbersAndOfOneChannelAreTheirOwn) {
  const TempFolder folder;
  std::vector<std::int64_t> wide;
  std::string colors;
  for (int i = 0; i < 12 * kPlanes; ++i) {
    wide.push_back(i * 1000);
    for (int c = 0; c < 3; ++c) colors += static_cast<char>(i * 3 + c);
  }
  NiftiSample nifti;
  nifti.size = {4, 3, kPlanes};
  nifti.datatype = 1024;
  nifti.bits = 64;
  write_file(folder.file("wide.nii"), nifti_header(nifti) + bytes_of(wide));
  write_file(folder.file("wide.nii.gz"), gzip(nifti_header(nifti) + bytes_of(wide)));
  expect_sought({folder.file("wide.nii")}, true);
  expect_sought({folder.file("wide.nii.gz")}, false);
  nifti.datatype = 128;
  nifti.bits = 24;
  write_file(folder.file("colors.nii"), nifti_header(nifti) + colors);
  SourceOptions green;
  green.channel = "green";
  expect_sought({folder.file("colors.nii")}, true, green);
}

// A file that is not there is noticed by whoever opens it.
TEST(SoughtPlanes, ReadingAheadStopsBeforeTheEnd) {
  const TempFolder folder;
  for (int z = 0; z < kPlanes; ++z) {
    write_file(folder.file("s" + std::to_string(z)), plane_of(z));
  }
  SourceOptions raw;
  raw.raw = RawLayout{{4, 3, kPlanes}, VoxelType::uint8, false, 0};
  const auto source = make_prefetch_source(open_source({folder.path()}, raw), {.threads = 3});
  for (const int z : {0, 1, 2, 3, 6, 7, 8, 9}) {
    std::remove(folder.file("s" + std::to_string(z)).c_str());
  }
  const auto planes = planes_between(*source, 4, 6);
  for (std::size_t z = 0; z < 2; ++z) {
    const std::string expected = plane_of(static_cast<int>(z) + 4);
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(planes[z].data()), 12), expected);
  }
  source->seek(3, 6);
  std::vector<std::byte> plane(12);
  EXPECT_THROW(source->read_plane(plane), Error);
  EXPECT_EQ(planes_between(*source, 4, 6), planes) << "after a failure";
}

TEST(SoughtPlanes, TheEndOfAStreamIsProvenWhereItsLastPlaneIsRead) {
  const TempFolder folder;
  const std::string bytes = nifti_header({}) + bytes_of(kStoredValues) + "more";
  write_file(folder.file("a.nii.gz"), gzip(bytes));
  const auto source = open_source({folder.file("a.nii.gz")}, {});
  planes_between(*source, 0, 1);
  EXPECT_TRUE(source->warnings().empty());
  planes_between(*source, 1, 2);
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(source->warnings()[0], "4 bytes behind"));
}

}  // namespace
}  // namespace octavo::testing
