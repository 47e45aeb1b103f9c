#include "octavo/io/dicom/dicom_pixels.h"

#include <gtest/gtest.h>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::uint32_t kFloatPixels = 0x7fe00008;
constexpr std::uint32_t kDoublePixels = 0x7fe00009;
constexpr std::uint32_t kPixels = 0x7fe00010;

/// A parametric map of 3 x 2 numbers without its voxels.
DicomElements map_elements(std::uint16_t bits, bool big_endian = false) {
  DicomElements elements = ct_elements(3, 2, bits, 0, big_endian);
  elements.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.30");
  elements.remove(kPixels);
  return elements;
}

TEST(SourceDicomFloat, PixelDataOfBothWidthsAreRead) {
  const TempFolder folder;
  for (const bool big_endian : {false, true}) {
    const std::string syntax = big_endian ? kExplicitBig : kExplicitLittle;
    DicomElements floats = map_elements(32, big_endian);
    const std::vector<float> values = {0.5F, -1e30F, 3, 0, 0.1F, 7};
    floats.set(kFloatPixels, "OF", bytes_of(values, big_endian));
    floats.write(folder.file("a.dcm"), syntax);
    const auto source = open_source({folder.file("a.dcm")}, {});
    EXPECT_EQ(source->description().type, VoxelType::float32);
    EXPECT_EQ(voxels_of(*source), bytes_of(values));
    DicomElements doubles = map_elements(64, big_endian);
    doubles.set(kDoublePixels, "OD",
                bytes_of(std::vector<double>(values.begin(), values.end()), big_endian));
    doubles.write(folder.file("b.dcm"), syntax);
    const auto rounded = open_source({folder.file("b.dcm")}, {});
    EXPECT_EQ(voxels_of(*rounded), bytes_of(values));
    EXPECT_TRUE(contains(rounded->warnings().front(), "rounded to float32"));
  }
}

TEST(SourceDicomFloat, WhatDoesNotFitIsRejected) {
  const TempFolder folder;
  DicomElements elements = map_elements(64);
  elements.set(kDoublePixels, "OD", bytes_of<double>({0, 0, 0, 0, 1e300, 0}));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  expect_rejected(folder.file("a.dcm"), {"1e+300 at x,y,z = 1,1,0", "float32"});
  elements = map_elements(16);
  elements.set(kFloatPixels, "OF", std::string(12, '\0'));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  expect_rejected(folder.file("a.dcm"), {"float pixel data of 16 bits"});
  elements = map_elements(32);
  elements.set(kFloatPixels, "OF", std::string(20, '\0'));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  expect_rejected(folder.file("a.dcm"), {"20 bytes", "24"});
}

TEST(SourceDicomFloat, TheMappingToTheRealWorldIsTheRescale) {
  const TempFolder folder;
  DicomElements elements = map_elements(32);
  elements.set(kFloatPixels, "OF", std::string(24, '\0'));
  DicomElements mapping;
  mapping.set(0x00409224, "FD", bytes_of<double>({-3.5}));
  mapping.set(0x00409225, "FD", bytes_of<double>({0.25}));
  DicomElements position;
  position.set(0x00200032, "DS", "0\\0\\0");
  DicomElements frame;
  frame.set_items(0x00409096, {mapping});
  frame.set_items(0x00209113, {position});
  elements.set_items(0x52009230, {frame});
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  SourceOptions options;
  options.spacing_mm = Point3{1, 1, 1};
  EXPECT_EQ(open_source({folder.file("a.dcm")}, options)->description().rescale,
            (Rescale{0.25, -3.5}));
}

}  // namespace
}  // namespace octavo::testing
