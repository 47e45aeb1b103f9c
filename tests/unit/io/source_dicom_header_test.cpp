// What headers of DICOM files say about stored voxels and their meaning, and what cannot be taken.
#include <gtest/gtest.h>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::uint32_t kFrames = 0x00280008;
constexpr std::uint32_t kPixelData = 0x7fe00010;

std::string swapped_pairs(std::string bytes) {
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) std::swap(bytes[at], bytes[at + 1]);
  return bytes;
}

/// 0, 1, 2, ... of 15 voxels a frame.
std::string counted(std::size_t count) {
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) bytes += static_cast<char>(i);
  return bytes;
}

SourceOptions with_spacing() {
  SourceOptions options;
  options.spacing_mm = Point3{1, 1, 1};
  return options;
}

TEST(SourceDicomWords, OfBigEndianFilesHoldTheFirstOfTwoBytesBehindTheSecond) {
  const TempFolder folder;
  for (const char* vr : {"OW", "OB"}) {
    DicomElements elements = ct_elements(5, 3, 8, 0, true);
    elements.set(kFrames, "IS", "3");
    // Frames of 15 bytes: the second starts in the middle of a word.
    const std::string voxels = counted(45) + std::string(1, '\0');
    elements.set(kPixelData, vr, vr == std::string("OW") ? swapped_pairs(voxels) : voxels);
    elements.write(folder.file("a.dcm"), kExplicitBig);
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, with_spacing())), counted(45)) << vr;
  }
}

TEST(SourceDicomWords, OfLittleEndianFilesStayAsTheyAre) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(kPixelData, "OW", counted(15));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, {})), counted(15));
}

TEST(SourceDicomWords, OfBigEndianColourHoldSwappedSamples) {
  const TempFolder folder;
  for (const int planar : {0, 1}) {
    DicomElements elements = ct_elements(5, 3, 8, 0, true);
    elements.set_number(0x00280002, 3);
    elements.set(0x00280004, "CS", "RGB");
    elements.set_number(0x00280006, static_cast<std::uint16_t>(planar));
    elements.set(kPixelData, "OW", swapped_pairs(counted(45) + std::string(1, '\0')));
    elements.write(folder.file("a.dcm"), kExplicitBig);
    SourceOptions options;
    options.channel = "green";
    std::string green;
    for (int i = 0; i < 15; ++i) green += static_cast<char>(planar == 1 ? 15 + i : 3 * i + 1);
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, options)), green) << planar;
  }
}

TEST(SourceDicomWords, OfBigEndianSegmentationsHoldSwappedBits) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 1, 0, true);
  elements.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.66.4");
  elements.set(0x00080060, "CS", "SEG");
  elements.set(0x00620001, "CS", "BINARY");
  elements.set(kFrames, "IS", "3");
  // 45 bits: every third one of the frames behind one another.
  std::string packed(6, '\0');
  std::string labels(45, '\0');
  for (std::size_t i = 0; i < labels.size(); i += 3) {
    labels[i] = 1;
    packed[i / 8] = static_cast<char>(packed[i / 8] | 1 << i % 8);
  }
  elements.set(kPixelData, "OW", swapped_pairs(packed));
  elements.write(folder.file("a.dcm"), kExplicitBig);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, with_spacing())), labels);
}

}  // namespace
}  // namespace octavo::testing
