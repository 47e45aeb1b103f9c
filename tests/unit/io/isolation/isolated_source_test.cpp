// Readers that crash, hang, eat memory or lie, and sound ones, in a process of their own.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>

#include "octavo/io/isolation/isolated_source.h"
#include "octavo/io/isolation/worker_protocol.h"
#include "octavo/io/source/prefetch_source.h"
#include "support/coded_dicom.h"
#include "support/dicom_samples.h"
#include "support/image_samples.h"
#include "support/shared_data.h"
#include "support/sought_planes.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

IsolationOptions worker_options() {
  IsolationOptions options;
  options.command = {OCTAVO_BAD_WORKER};
  options.threads = 2;
  return options;
}

std::unique_ptr<PlaneSource> open_apart(const std::string& path,
                                        const IsolationOptions& options = worker_options()) {
  return open_isolated_source({path}, {}, options);
}

Error error_apart(const std::string& path, const IsolationOptions& options = worker_options()) {
  return error_of([&] { voxels_of(*open_apart(path, options)); });
}

void expect_words(const Error& error, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_TRUE(contains(error, word)) << word << " in: " << with_hints(error);
  }
}

std::string text_of_planes() {
  std::string text;
  for (char z = 0; z < 6; ++z) text += std::string(12, z);
  return text;
}

// --- Sound sources

void expect_same(const std::string& path) {
  const auto apart = open_apart(path);
  const auto here = open_source({path}, {});
  const VolumeDescription& a = apart->description();
  const VolumeDescription& b = here->description();
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.type, b.type);
  EXPECT_EQ(a.size, b.size);
  EXPECT_EQ(a.geometry, b.geometry);
  EXPECT_EQ(a.rescale, b.rescale);
  EXPECT_EQ(a.metadata.text(), b.metadata.text());
  EXPECT_EQ(apart->files(), here->files());
  EXPECT_FALSE(apart->files().paths.empty());
  EXPECT_EQ(apart->warnings(), here->warnings());
  EXPECT_EQ(voxels_of(*apart), voxels_of(*here)) << path;
  EXPECT_EQ(apart->warnings(), here->warnings());
}

DicomSample slice(int z) {
  DicomSample sample;
  sample.position = "1\\2\\" + std::to_string(z * 3);
  std::vector<std::int16_t> voxels;
  for (int i = 0; i < 12; ++i) voxels.push_back(static_cast<std::int16_t>(z * 100 + i));
  sample.voxels = bytes_of(voxels);
  return sample;
}

TEST(IsolatedSource, PlanesAndFactsAreThoseOfTheSource) {
  const TempFolder folder;
  for (int z = 0; z < 30; ++z) {
    write_dicom(folder.file("dicom/" + std::to_string(z) + ".dcm"), slice(z));
  }
  TiffSample tiff;
  tiff.pages = {std::string(12, 'a'), std::string(12, 'b')};
  write_tiff(folder.file("a.tif"), tiff);
  write_png(folder.file("a.png"), 4, 3, 8, 0, std::string(12, 'c'));
  write_file(folder.file("a.nii"),
             nifti_header({}) + bytes_of(std::vector<std::int16_t>(24, 7)));
  for (const char* name : {"dicom", "a.tif", "a.png", "a.nii"}) {
    expect_same(folder.file(name));
  }
}

TEST(IsolatedSource, PlanesAreTheSameFromAnywhere) {
  const TempFolder folder;
  for (int z = 0; z < 7; ++z) {
    write_dicom(folder.file("dicom/" + std::to_string(z) + ".dcm"), slice(z));
  }
  const auto source = open_apart(folder.file("dicom"));
  EXPECT_TRUE(source->can_seek());
  expect_same_from_anywhere(*source);
}

// Plane 2 ends whoever reads it.
TEST(IsolatedSource, WhatItHoldsCountsPlanesOfTheWorker) {
  const TempFolder folder;
  for (int z = 0; z < 3; ++z) {
    write_dicom(folder.file("dicom/" + std::to_string(z) + ".dcm"), slice(z));
  }
  const auto ahead = make_prefetch_source(open_source({folder.file("dicom")}, {}), {});
  EXPECT_EQ(open_apart(folder.file("dicom"))->resident_bytes(),
            ahead->resident_bytes() + 2 * plane_bytes(ahead->description()));
}

TEST(IsolatedSource, PlanesThatAreNotAskedForAreNotRead) {
  for (const auto& [first, end] :
       std::vector<std::pair<std::int64_t, std::int64_t>>{{3, 6}, {0, 2}, {4, 4}}) {
    IsolationOptions options = worker_options();
    options.first_plane = first;
    options.end_plane = end;
    const auto source = open_apart("plane:abort", options);
    EXPECT_EQ(source->description().size.z, 6);
    std::vector<std::byte> plane(12);
    for (std::int64_t z = first; z < end; ++z) {
      source->read_plane(plane);
      EXPECT_EQ(plane.front(), static_cast<std::byte>(z));
    }
    EXPECT_EQ(error_of([&] { source->read_plane(plane); }).kind(), ErrorKind::invalid_argument);
    source->seek(5, 6);
    source->read_plane(plane);
    EXPECT_EQ(plane.front(), std::byte{5});
    source->seek(1, 3);
    const Error error = error_of([&] {
      source->read_plane(plane);
      source->read_plane(plane);
    });
    expect_words(error, {"slice-2: ", "plane 2"});
    source->seek(3, 4);
    source->read_plane(plane);
    EXPECT_EQ(plane.front(), std::byte{3}) << "after a failure";
  }
}

TEST(IsolatedSource, PlanesThatTheVolumeLacksAreRejected) {
  IsolationOptions options = worker_options();
  options.first_plane = 3;
  options.end_plane = 7;
  EXPECT_EQ(error_of([&] { open_apart("plane:nothing", options); }).kind(),
            ErrorKind::invalid_argument);
}

TEST(IsolatedSource, ASourceThatChangesBetweenSeeksIsRejected) {
  const TempFolder folder;
  write_png(folder.file("a.png"), 4, 3, 8, 0, std::string(12, 'c'));
  const auto source = open_apart(folder.file("a.png"));
  voxels_of(*source);
  write_png(folder.file("a.png"), 3, 4, 8, 0, std::string(12, 'c'));
  const Error error = error_of([&] { source->seek(0, 1); });
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  expect_words(error, {"a.png", "changed since it was opened"});
}

TEST(IsolatedSource, LargePlanesCrossThePipeWhole) {
  const TempFolder folder;
  TiffSample tiff;
  tiff.width = 3000;
  tiff.height = 2000;
  for (int page = 0; page < 3; ++page) {
    std::string voxels(6000000, '\0');
    for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<char>(i * 7 >> page);
    tiff.pages.push_back(voxels);
  }
  write_tiff(folder.file("a.tif"), tiff);
  expect_same(folder.file("a.tif"));
}

TEST(IsolatedSource, OptionsReachTheReader) {
  const TempFolder folder;
  write_file(folder.file("v.raw"), std::string(5 + 24, 'x'));
  SourceOptions options;
  options.raw = RawLayout{{4, 3, 1}, VoxelType::uint16, true, 5};
  options.spacing_mm = Point3{0.5, 0.25, 2};
  const auto source = open_isolated_source({folder.file("v.raw")}, options, worker_options());
  EXPECT_EQ(source->description().type, VoxelType::uint16);
  EXPECT_EQ(source->description().geometry.spacing_mm, *options.spacing_mm);
  EXPECT_EQ(voxels_of(*source), std::string(24, 'x'));
}

TEST(IsolatedSource, ErrorsAreThoseOfTheReaderItself) {
  const TempFolder folder;
  write_file(folder.file("empty.dcm"), "");
  write_file(folder.file("cut.tif"), std::string("II*\0", 4));
  write_file(folder.file("no.png"), "\x89PNG\r\n\x1a\nno");
  for (const char* name : {"empty.dcm", "cut.tif", "no.png", "missing", "."}) {
    const std::string path = folder.file(name);
    const Error apart = error_apart(path);
    const Error here = source_error({path});
    EXPECT_EQ(apart.kind(), here.kind());
    EXPECT_EQ(apart.path(), here.path());
    EXPECT_EQ(with_hints(apart), with_hints(here));
    EXPECT_EQ(apart.offset(), here.offset());
  }
}

TEST(IsolatedSource, WhatAReaderSaysIsKeptApartAndNeverStopsIt) {
  IsolationOptions options = worker_options();
  std::string output;
  options.on_output = [&](const std::string& text) { output = text; };
  EXPECT_EQ(voxels_of(*open_apart("plane:noise", options)), text_of_planes());
  EXPECT_TRUE(output.starts_with("a library speaks\n"));
  EXPECT_LE(output.size(), std::size_t{1} << 16);
}

TEST(IsolatedSource, OnlyWhatLibrariesOfOthersReadNeedsIsolation) {
  const TempFolder folder;
  write_dicom(folder.file("slice"), slice(0));
  write_png(folder.file("a.png"), 4, 3, 8, 0, std::string(12, 'c'));
  TiffSample tiff;
  tiff.pages = {std::string(12, 'a')};
  write_tiff(folder.file("a.tif"), tiff);
  for (const char* name : {"a.nii", "a.nrrd", "a.mha", "a.vtk", "a.gipl", "a.raw"}) {
    write_file(folder.file(name), "x");
  }
  write_file(folder.file("a.ozx"), "x");
  write_file(folder.file("a.zarr/zarr.json"), "{}");
  for (const char* name : {"slice", "a.png", "a.tif", "a.ozx", "a.zarr", "."}) {
    EXPECT_TRUE(needs_isolation({folder.file(name)}, {})) << name;
  }
  for (const char* name : {"a.nii", "a.nrrd", "a.mha", "a.vtk", "a.gipl", "a.raw"}) {
    EXPECT_FALSE(needs_isolation({folder.file(name)}, {})) << name;
  }
  EXPECT_TRUE(needs_isolation({folder.file("a.nii"), folder.file("a.raw")}, {}));
  SourceOptions raw;
  raw.raw = RawLayout{{4, 3, 1}, VoxelType::uint16, false, 0};
  EXPECT_FALSE(needs_isolation({folder.path()}, raw));
}

// --- Readers that fail

struct Failure {
  const char* path;
  std::vector<std::string> words;
};

TEST(IsolatedSource, AReaderThatStopsIsAnErrorThatNamesTheFile) {
  const std::vector<Failure> rows = {
      {"plane:segv", {"slice-2: ", "stopped by signal 11", "plane 2"}},
      {"plane:abort", {"slice-2: ", "stopped by signal 6", "plane 2"}},
      {"plane:overflow", {"stopped by signal 11"}},
      {"plane:exit", {"ended with code 3"}},
      {"plane:kill", {"stopped by signal 9"}},
      {"plane:write", {"slice-2: ", "stopped by signal 25", "plane 2"}},
      {"open:segv", {"header-of-segv: ", "stopped by signal 11", "while opening"}},
      {"open:abort", {"header-of-abort: ", "stopped by signal 6", "while opening"}},
      {"open:exit", {"ended with code 3", "while opening"}},
  };
  for (const Failure& row : rows) {
    const Error error = error_apart(row.path);
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
    expect_words(error, row.words);
  }
  EXPECT_FALSE(std::filesystem::exists("written-by-a-reader") &&
               std::filesystem::file_size("written-by-a-reader") > 0);
  std::filesystem::remove("written-by-a-reader");
}

TEST(IsolatedSource, AReaderThatHangsIsAnErrorInTime) {
  IsolationOptions options = worker_options();
  options.plane_limit = milliseconds(400);
  for (const Failure& row : std::vector<Failure>{
           {"plane:hang", {"slice-2: ", "nothing for 0.4 s", "plane 2"}},
           {"plane:spin", {"slice-2: ", "nothing for 0.4 s", "plane 2"}},
           {"open:hang", {"header-of-hang: ", "nothing for 0.4 s", "while opening"}},
           {"open:spin", {"header-of-spin: ", "nothing for 0.4 s", "while opening"}}}) {
    const auto start = std::chrono::steady_clock::now();
    const Error error = error_apart(row.path, options);
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
    expect_words(error, row.words);
    EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(10)) << row.path;
  }
}

TEST(IsolatedSource, AReaderThatEatsMemoryIsAnError) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers reserve terabytes of addresses: no limit can be set";
#endif
  IsolationOptions options = worker_options();
  options.memory_bytes = std::uint64_t{600} << 20;
  const Error at_plane = error_apart("plane:grow", options);
  EXPECT_EQ(at_plane.kind(), ErrorKind::source_rejected);
  expect_words(at_plane, {"slice-2: ", "600 MiB"});
  const Error at_open = error_apart("open:grow", options);
  EXPECT_EQ(at_open.kind(), ErrorKind::source_rejected);
  expect_words(at_open, {"header-of-grow: ", "600 MiB"});
  // Without a number it is bounded once the size of a plane is known.
  expect_words(error_apart("plane:grow"), {"slice-2: ", "MiB"});
}

TEST(IsolatedSource, AReaderThatLiesIsAnError) {
  const std::vector<Failure> rows = {
      {"lie:bit", {"checksum", "expected", "plane 0"}},
      {"lie:head", {"fails its checksum"}},
      {"lie:index", {"something else"}},
      {"lie:length", {"something else"}},
      {"lie:kind", {"something else"}},
      {"lie:size", {"makes no sense"}},
      {"lie:type", {"makes no sense", "voxel type"}},
      {"lie:metadata", {"makes no sense", "JSON"}},
      {"lie:spacing", {"makes no sense", "geometry"}},
  };
  for (const Failure& row : rows) {
    const Error error = error_apart(row.path);
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
    expect_words(error, row.words);
    EXPECT_EQ(error.path(), row.path);
  }
}

TEST(IsolatedSource, WaitingCanBeCancelled) {
  IsolationOptions options = worker_options();
  int questions = 0;
  options.is_cancelled = [&] { return ++questions > 2; };
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(error_apart("plane:hang", options).kind(), ErrorKind::cancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(10));
}

TEST(IsolatedSource, AProgramThatIsNotThereIsAnIoError) {
  IsolationOptions options = worker_options();
  options.command = {"/nowhere/octavo"};
  expect_words(error_apart("a.dcm", options), {"/nowhere/octavo", "[isolation]"});
  EXPECT_EQ(error_apart("a.dcm", options).kind(), ErrorKind::io);
}

TEST(IsolatedSource, ASourceLeftEarlyLeavesNoProcess) {
  for (int planes = 0; planes < 3; ++planes) {
    const auto source = open_apart("plane:nothing");
    std::vector<std::byte> plane(12);
    for (int z = 0; z < planes; ++z) source->read_plane(plane);
  }
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child was not waited for";
}

// --- Damaged DICOM files

std::string jpeg_ls_slice(const TempFolder& folder) {
  return coded_slice(folder, slice(1), gdcm::TransferSyntax::JPEGLSLossless);
}

TEST(IsolatedSource, EveryCutDicomFileIsRejectedByName) {
  const TempFolder folder;
  const std::string whole = jpeg_ls_slice(folder);
  for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 60) {
    write_file(folder.file("cut.dcm"), whole.substr(0, length));
    const Error error = error_apart(folder.file("cut.dcm"));
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << length << ": " << error.what();
    EXPECT_EQ(error.path(), folder.file("cut.dcm")) << length;
  }
}

TEST(IsolatedSource, DamagedDicomPicturesAreVoxelsOrErrors) {
  const TempFolder folder;
  const std::string whole = jpeg_ls_slice(folder);
  const std::size_t bytes_of_voxels = 32 * 32 * 2;
  for (std::size_t at = whole.size() / 2; at < whole.size(); at += 1 + whole.size() / 80) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    write_file(folder.file("damaged.dcm"), damaged);
    try {
      EXPECT_EQ(voxels_of(*open_apart(folder.file("damaged.dcm"))).size(), bytes_of_voxels);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
      EXPECT_EQ(error.path(), folder.file("damaged.dcm"));
    }
  }
}

TEST(IsolatedSource, AwkwardSourcesEndAsTheyDoWithoutIsolation) {
  const auto root = shared_data();
  if (!root) GTEST_SKIP() << missing_shared_file("awkward");
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(*root / "awkward")) {
    const std::string path = entry.path().string();
    std::string here;
    std::string apart;
    try {
      here = voxels_of(*open_source({path}, {}));
    } catch (const Error& error) {
      here = std::string(error_kind_name(error.kind())) + " " + error.what();
    }
    try {
      apart = voxels_of(*open_apart(path));
    } catch (const Error& error) {
      apart = std::string(error_kind_name(error.kind())) + " " + error.what();
    }
    EXPECT_TRUE(here == apart) << path << ": " << apart.substr(0, 300);
    ++count;
  }
  EXPECT_GT(count, 30);
}

}  // namespace
}  // namespace octavo::testing
