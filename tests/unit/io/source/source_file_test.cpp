// Names of files that stand in headers: nothing outside the header's own folder is ever opened.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>

#include "octavo/io/source/source_file.h"
#include "support/dicom_samples.h"
#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBytes = 24;

/// A folder `scan` with every kind of thing a name can lead to, and a secret beside it that would
/// make a sound volume.
class Trap {
 public:
  Trap() {
    secret_ = folder_.file("secret.raw");
    write_file(secret_, std::string(kBytes, 'S'));
    write_file(folder_.file("secret/voxels.raw"), std::string(kBytes, 'S'));
    write_file(file("sub/own.raw"), std::string(kBytes, 'o'));
    fs::create_symlink("../secret.raw", file("link.raw"));
    fs::create_symlink(secret_, file("absolute_link.raw"));
    fs::create_directory_symlink("../secret", file("folder_link"));
    fs::create_symlink("link.raw", file("link_to_link.raw"));
    fs::create_symlink("loop.raw", file("loop.raw"));
    fs::create_symlink("nowhere.raw", file("dangling.raw"));
    fs::create_symlink("/dev/zero", file("zero.raw"));
    fs::create_symlink("/proc/self/environ", file("environ.raw"));
    EXPECT_EQ(::mkfifo(file("pipe.raw").c_str(), 0600), 0);
  }

  std::string file(const std::string& name) const { return folder_.file("scan/" + name); }
  const std::string& secret() const { return secret_; }

 private:
  TempFolder folder_;
  std::string secret_;
};

std::vector<std::string> hostile_names(const Trap& trap) {
  return {"../secret.raw",
          "./../secret.raw",
          "sub/../../secret.raw",
          "sub/./../../secret.raw",
          "sub/../sub/own.raw",
          "..",
          ".",
          "sub",
          "folder_link/voxels.raw",
          "folder_link",
          "link.raw",
          "./link.raw",
          "absolute_link.raw",
          "link_to_link.raw",
          "loop.raw",
          "dangling.raw",
          "zero.raw",
          "environ.raw",
          "pipe.raw",
          "/proc/self/environ",
          "/dev/zero",
          "/dev/stdin",
          "/etc/passwd",
          trap.secret(),
          "/" + trap.secret(),
          "file://" + trap.secret(),
          "..\\secret.raw",
          "%2e%2e/secret.raw",
          "~/secret.raw"};
}

void expect_rejected(const std::string& header) {
  const Error error = source_error({header});
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
  EXPECT_EQ(error.path(), header) << error.what();
}

TEST(SourcePaths, InMetaImagesStayBeneathTheirFolder) {
  const Trap trap;
  const std::string header = "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n";
  for (const std::string& name : hostile_names(trap)) {
    SCOPED_TRACE(name);
    write_file(trap.file("a.mhd"), header + "ElementDataFile = " + name + "\n");
    expect_rejected(trap.file("a.mhd"));
  }
  for (const std::string& list : std::vector<std::string>{
           "LIST\n../secret.raw\n../secret.raw\n", "LIST 2\nlink.raw\nlink.raw\n",
           "../secret%01d.raw 1 2 1\n"}) {
    SCOPED_TRACE(list);
    write_file(trap.file("a.mhd"), header + "ElementDataFile = " + list);
    expect_rejected(trap.file("a.mhd"));
  }
}

TEST(SourcePaths, InNrrdHeadersStayBeneathTheirFolder) {
  const Trap trap;
  const std::string header =
      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n";
  for (const std::string& name : hostile_names(trap)) {
    SCOPED_TRACE(name);
    write_file(trap.file("a.nhdr"), header + "data file: " + name + "\n");
    expect_rejected(trap.file("a.nhdr"));
  }
  for (const std::string& list : std::vector<std::string>{
           "LIST\n../secret.raw\n../secret.raw\n", "LIST 3\nlink.raw\n",
           "../secret%01d.raw 1 2 1\n"}) {
    SCOPED_TRACE(list);
    write_file(trap.file("a.nhdr"), header + "data file: " + list);
    expect_rejected(trap.file("a.nhdr"));
  }
}

TEST(SourcePaths, BesideANiftiHeaderLeadNowhereElse) {
  const Trap trap;
  NiftiSample sample;
  sample.datatype = 2;
  sample.bits = 8;
  std::string header = nifti_header(sample);
  header.replace(344, 4, std::string("ni1\0", 4));
  header.replace(108, 4, bytes_of<float>({0}));
  write_file(trap.file("a.hdr"), header);
  for (const char* target : {"../secret.raw", "/dev/zero", "/proc/self/environ", "loop.raw",
                             "pipe.raw", "sub", "folder_link/voxels.raw"}) {
    SCOPED_TRACE(target);
    fs::create_symlink(target, trap.file("a.img"));
    expect_rejected(trap.file("a.hdr"));
    fs::remove(trap.file("a.img"));
  }
}

TEST(SourcePaths, ThatStayInTheFolderAreFollowed) {
  const Trap trap;
  const std::string header = "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n";
  fs::create_symlink("sub/own.raw", trap.file("inner_link.raw"));
  for (const char* name : {"sub/own.raw", "./sub/own.raw", "inner_link.raw"}) {
    SCOPED_TRACE(name);
    write_file(trap.file("a.mhd"), header + "ElementDataFile = " + std::string(name) + "\n");
    EXPECT_EQ(voxels_of(*open_source({trap.file("a.mhd")}, {})), std::string(kBytes, 'o'));
  }
}

/// A DICOMDIR only says that the folder is one; the names in it are not followed.
TEST(SourcePaths, InADicomDirectoryAreNotFollowed) {
  const TempFolder folder;
  DicomSample sample;
  sample.position = "0\\0\\0";
  write_dicom(folder.file("outside.dcm"), sample);
  const std::string directory = folder.file("disc/DICOMDIR");
  for (const char* name : {"..\\outside.dcm", "/outside.dcm", "..\\..\\outside.dcm"}) {
    std::string text = name;
    if (text.size() % 2 == 1) text += ' ';
    // Referenced File ID (0004,1500), behind a meta information group without its length.
    write_file(directory, std::string(128, '\0') + "DICM" +
                              std::string("\2\0\x10\0UI\x14\0", 8) +
                              std::string("1.2.840.10008.1.2.1\0", 20) +
                              std::string("\4\0\0\x15" "CS", 6) + static_cast<char>(text.size()) +
                              std::string(1, '\0') + text);
    const Error error = source_error({directory});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
    EXPECT_NE(std::string(error.what()).find("no DICOM file with a picture"), std::string::npos)
        << error.what();
  }
  sample.position = "0\\0\\5";
  write_dicom(folder.file("disc/inside"), sample);
  const auto source = open_source({directory}, {});
  EXPECT_EQ(source->description().geometry.origin_mm[2], 5);
}

TEST(SourceFiles, APipeAmongThoseOfAFolderIsPassedOver) {
  const TempFolder folder;
  write_file(folder.file("a.tif"), "x");
  ASSERT_EQ(::mkfifo(folder.file("b.tif").c_str(), 0600), 0);
  EXPECT_EQ(files_in_folder(folder.path(), true), std::vector{folder.file("a.tif")});
  const Error error = source_error({folder.file("b.tif")});
  EXPECT_TRUE(contains(error, "is not a regular file")) << error.what();
}

TEST(SourceFiles, NothingStandsBehindTheirEnd) {
  const TempFolder folder;
  write_file(folder.file("a"), "abc");
  const SourceFile file(folder.file("a"));
  std::array<std::byte, 2> bytes{};
  for (const std::uint64_t offset :
       {std::uint64_t{3}, std::uint64_t{4}, std::uint64_t{1} << 63, ~std::uint64_t{0}}) {
    EXPECT_EQ(file.read_some(offset, bytes), 0U) << offset;
    EXPECT_THROW(file.read_exactly(offset, bytes), Error) << offset;
  }
  EXPECT_EQ(file.read_some(2, bytes), 1U);
}

TEST(SourceFiles, ALinkToNothingIsNotPassedOver) {
  const TempFolder folder;
  const auto add_png = [&](const std::string& name, char value) {
    write_png(folder.file(name), 2, 2, 8, 0, std::string(4, value));
  };
  add_png("s1.png", 1);
  fs::create_symlink("gone.png", folder.file("s2.png"));
  const Error error = source_error({folder.path()}, {});
  EXPECT_EQ(error.kind(), ErrorKind::io);
  EXPECT_TRUE(contains(error, "s2.png") && contains(error, "link")) << error.what();
  // Links to files are followed.
  add_png(".gone.png", 2);
  fs::remove(folder.file("s2.png"));
  fs::create_symlink(".gone.png", folder.file("s2.png"));
  EXPECT_EQ(open_source({folder.path()}, {})->description().size.z, 2);
}

}  // namespace
}  // namespace octavo::testing
