#include "octavo/io/dicom/dicom_inflated.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "octavo/io/source/described_source.h"
#include "octavo/io/source/prefetch_source.h"
#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr const char* kDeflated = "1.2.840.10008.1.2.1.99";

/// The file of `elements` with its data set deflated.
std::string deflated_file(const TempFolder& folder, const DicomElements& elements) {
  elements.write(folder.file("plain"), kDeflated);
  const std::string set = elements.bytes();
  const std::string whole = read_file(folder.file("plain"));
  return whole.substr(0, whole.size() - set.size()) + bare_deflate_stream(set);
}

/// 9 frames of 64 x 40 voxels, larger than what is read at once.
DicomElements many_frames(std::string& voxels) {
  DicomElements elements = ct_elements(64, 40, 16);
  std::vector<std::uint16_t> values(9 * 64 * 40);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<std::uint16_t>(i * i % 50021);
  }
  voxels = bytes_of(values);
  elements.set(0x00280008, "IS", "9");
  elements.set(0x7fe00010, "OW", voxels);
  return elements;
}

TEST(SourceDicomDeflated, FramesAreReadInAnyOrder) {
  const TempFolder folder;
  std::string voxels;
  write_file(folder.file("a.dcm"), deflated_file(folder, many_frames(voxels)));
  for (const int threads : {1, 5}) {
    const auto source =
        make_prefetch_source(open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1)), {threads});
    EXPECT_EQ(source->description().size, (Size3{64, 40, 9}));
    EXPECT_TRUE(voxels_of(*source) == voxels) << threads;
  }
  const auto source = open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1));
  const auto& planes = dynamic_cast<const IndexedPlaneSource&>(*source);
  std::string plane(64 * 40 * 2, '\0');
  for (const int z : {8, 0, 5, 4, 7, 0}) {
    planes.read_plane_at(z, std::as_writable_bytes(std::span(plane.data(), plane.size())));
    EXPECT_TRUE(plane == voxels.substr(static_cast<std::size_t>(z) * plane.size(), plane.size()))
        << z;
  }
}

TEST(SourceDicomDeflated, ASeriesOfFilesIsRead) {
  const TempFolder folder;
  for (int z = 0; z < 3; ++z) {
    DicomElements elements = ct_elements(3, 2, 8, 2 * z);
    elements.set(0x7fe00010, "OB", std::string(6, static_cast<char>('a' + z)));
    write_file(folder.file("series/s" + std::to_string(z)), deflated_file(folder, elements));
  }
  const auto source = open_source({folder.file("series")}, {});
  EXPECT_EQ(source->description().geometry.spacing_mm[2], 2);
  EXPECT_EQ(voxels_of(*source), "aaaaaabbbbbbcccccc");
}

/// Lets this process open at most `count` files until the end of the scope.
class FewDescriptors {
 public:
  explicit FewDescriptors(rlim_t count) {
    EXPECT_EQ(getrlimit(RLIMIT_NOFILE, &before_), 0);
    const rlimit few{count, before_.rlim_max};
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  }
  ~FewDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }
  FewDescriptors(const FewDescriptors&) = delete;
  FewDescriptors& operator=(const FewDescriptors&) = delete;

 private:
  rlimit before_{};
};

TEST(SourceDicomDeflated, ASeriesOfMoreFilesThanDescriptorsIsRead) {
  constexpr int kFiles = 48;
  constexpr std::size_t kPictureBytes = 192 * 128;  // more than the window on a header takes
  const TempFolder folder;
  std::string voxels;
  for (int z = 0; z < kFiles; ++z) {
    DicomElements elements = ct_elements(192, 128, 8, z);
    voxels += std::string(kPictureBytes, static_cast<char>(z));
    elements.set(0x7fe00010, "OB", voxels.substr(voxels.size() - kPictureBytes));
    // What follows a picture is larger than the picture itself.
    elements.set(0xfffcfffc, "OB", std::string(2 * kPictureBytes, 'p'));
    write_file(folder.file("series/s" + std::to_string(100 + z)),
               deflated_file(folder, elements));
  }
  const FewDescriptors few(32);
  EXPECT_TRUE(voxels_of(*open_source({folder.file("series")}, {})) == voxels);
}

TEST(SourceDicomDeflated, EveryTruncationIsRejected) {
  const TempFolder folder;
  const std::string whole = deflated_file(folder, ct_elements(3, 2, 8));
  for (std::size_t length = 133; length < whole.size(); ++length) {
    write_file(folder.file("a.dcm"), whole.substr(0, length));
    EXPECT_EQ(source_error({folder.file("a.dcm")}).kind(), ErrorKind::source_rejected) << length;
  }
  write_file(folder.file("a.dcm"), whole + '\0');  // the standard pads to an even length
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, {})), std::string(6, '\0'));
}

}  // namespace
}  // namespace octavo::testing
