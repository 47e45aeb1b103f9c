#include "octavo/io/dicom/dicom_nuclear.h"

#include <gtest/gtest.h>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::uint32_t kVector = 0x00540080;
constexpr std::uint32_t kStep = 0x00180088;

/// Three frames of 5 x 3 voxels, which hold 0, 1, 2 ... in their order in the file.
DicomElements nuclear_elements(const std::vector<std::uint16_t>& numbers) {
  DicomElements elements = ct_elements(5, 3, 8);
  elements.remove(0x00200032);
  elements.remove(0x00200037);
  elements.set(0x00080060, "CS", "NM");
  elements.set(0x00080008, "CS", "ORIGINAL\\PRIMARY\\RECON TOMO\\EMISSION");
  elements.set(kStep, "DS", "4");
  elements.set(0x00280008, "IS", "3");
  elements.set(kVector, "US", bytes_of(numbers));
  DicomElements detector;
  detector.set(0x00200032, "DS", "-10\\-20\\5");
  detector.set(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
  elements.set_items(0x00540022, {detector});
  std::string voxels;
  for (int i = 0; i < 45; ++i) voxels += static_cast<char>(i);
  elements.set(0x7fe00010, "OB", voxels);
  return elements;
}

class SourceDicomNuclear : public ::testing::Test {
 protected:
  std::string path() const { return folder_.file("a.dcm"); }

  std::string voxels(const DicomElements& elements, const SourceOptions& options = {}) {
    elements.write(path(), kExplicitLittle);
    return voxels_of(*open_source({path()}, options));
  }

  TempFolder folder_;
};

TEST_F(SourceDicomNuclear, FramesLieByTheirDetectorInTheOrderOfTheirSlices) {
  const std::string plain = voxels(nuclear_elements({1, 2, 3}));
  const Geometry geometry = geometry_of(path());
  EXPECT_EQ(geometry.origin_mm, (Point3{-10, -20, 5}));
  EXPECT_EQ(geometry.spacing_mm, (Point3{0.5, 0.5, 4}));
  EXPECT_EQ(voxels(nuclear_elements({2, 1, 3})),
            plain.substr(15, 15) + plain.substr(0, 15) + plain.substr(30));
  // A negative step leads the other way: the last slice lies lowest.
  DicomElements down = nuclear_elements({1, 2, 3});
  down.set(kStep, "DS", "-4");
  EXPECT_EQ(voxels(down), plain.substr(30) + plain.substr(15, 15) + plain.substr(0, 15));
  EXPECT_EQ(geometry_of(path()).origin_mm, (Point3{-10, -20, -3}));
}

TEST_F(SourceDicomNuclear, WithoutADetectorTheOrderIsThatOfTheSlices) {
  DicomElements elements = nuclear_elements({3, 2, 1});
  const std::string plain = voxels(nuclear_elements({1, 2, 3}));
  elements.remove(0x00540022);
  EXPECT_EQ(voxels(elements, with_spacing(1, 1, 4)),
            plain.substr(30) + plain.substr(15, 15) + plain.substr(0, 15));
  expect_rejected(path(), {"no geometry"});
}

TEST_F(SourceDicomNuclear, SeveralVolumesInOneFileAreRejected) {
  nuclear_elements({1, 2, 1}).write(path(), kExplicitLittle);
  expect_rejected(path(), {"Slice Vector (0054,0080)", "slice 1 more than once"},
                  with_spacing(1, 1, 4));
  nuclear_elements({1, 2}).write(path(), kExplicitLittle);
  expect_rejected(path(), {"2 numbers", "3 frames"});
}

}  // namespace
}  // namespace octavo::testing
