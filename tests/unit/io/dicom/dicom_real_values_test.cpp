#include "octavo/io/dicom/dicom_real_values.h"

#include <gtest/gtest.h>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::uint32_t kModality = 0x00080060;
constexpr std::uint32_t kPadding = 0x00280120;

/// A slice of 5 x 3 voxels of 16 bits at each of the heights 0, 2, 4 ..., with a slope each.
void write_slopes(const TempFolder& folder, DicomElements (*start)(std::uint16_t, double),
                  const std::vector<std::string>& slopes) {
  for (std::size_t z = 0; z < slopes.size(); ++z) {
    DicomElements elements = start(16, 2.0 * static_cast<double>(z));
    elements.set(kSlope, "DS", slopes[z]);
    elements.set(kIntercept, "DS", "0");
    std::vector<std::uint16_t> voxels;
    for (std::uint16_t i = 0; i < 15; ++i) voxels.push_back(static_cast<std::uint16_t>(1000 * i));
    elements.set(kPixelData, "OW", bytes_of(voxels));
    elements.write(folder.file("s" + std::to_string(z)), kExplicitLittle);
  }
}

DicomElements pet_elements(std::uint16_t bits, double z_mm) {
  DicomElements elements = ct_elements(5, 3, bits, z_mm);
  elements.set(kModality, "CS", "PT");
  elements.set(0x00541001, "CS", "BQML");
  return elements;
}

TEST(DicomRealValues, OfPetWithSeveralRescalesAreFloats) {
  const TempFolder folder;
  const std::vector<std::string> slopes = {"0.1", "2.5", "7"};
  write_slopes(folder, pet_elements, slopes);
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(source->description().type, VoxelType::float32);
  EXPECT_EQ(source->description().rescale, Rescale{});
  EXPECT_TRUE(contains(source->description().metadata.text(), "\"unit\":\"Bq/mL\""));
  std::vector<float> expected;
  for (const double slope : {0.1, 2.5, 7.0}) {
    for (int i = 0; i < 15; ++i) expected.push_back(static_cast<float>(slope * 1000 * i));
  }
  EXPECT_EQ(voxels_of(*source), bytes_of(expected));
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(with_hints(source->warnings()), "0.1 x + 0 in s0, 2.5 x + 0 in s1"));
  EXPECT_FALSE(source->files().outline);
}

TEST(DicomRealValues, OfPetWithOneRescaleStayAsTheyAre) {
  const TempFolder folder;
  write_slopes(folder, pet_elements, {"0.5", "0.5", "0.5"});
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(source->description().type, VoxelType::uint16);
  EXPECT_EQ(source->description().rescale, (Rescale{0.5, 0}));
  EXPECT_TRUE(source->warnings().empty());
}

TEST(DicomRealValues, AreNotMadeOfOtherSeries) {
  const TempFolder folder;
  const auto ct = [](std::uint16_t bits, double z_mm) { return ct_elements(5, 3, bits, z_mm); };
  const auto padded = [](std::uint16_t bits, double z_mm) {
    DicomElements elements = pet_elements(bits, z_mm);
    elements.set_number(kPadding, 0);
    return elements;
  };
  for (DicomElements (*start)(std::uint16_t, double) :
       {static_cast<DicomElements (*)(std::uint16_t, double)>(ct),
        static_cast<DicomElements (*)(std::uint16_t, double)>(padded)}) {
    write_slopes(folder, start, {"0.1", "2.5"});
    EXPECT_TRUE(contains(source_error({folder.path()}), "the rescale is 2.5 x + 0"));
  }
}

TEST(DicomRealValues, ThatFloatsDoNotHoldAreRejected) {
  const TempFolder folder;
  for (const char* slope : {"1e36", "1e-50"}) {
    write_slopes(folder, pet_elements, {"1", slope, "2"});
    const Error error = source_error({folder.path()});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_EQ(error.path(), folder.file("s1"));
    EXPECT_TRUE(contains(error, "which float32 does not hold")) << error.what();
  }
  EXPECT_TRUE(contains(source_error({folder.path()}), "(1e-50 x + 0) makes 1000 1e-47"));
}

TEST(DicomRealValues, TakeTheSignOfStoredOnes) {
  const std::vector<std::int16_t> stored = {-3, 0, 32767};
  std::vector<float> real(3);
  make_real({0.5, -1}, VoxelType::int16, std::as_bytes(std::span(stored)),
            std::as_writable_bytes(std::span(real)));
  EXPECT_EQ(real, (std::vector<float>{-2.5F, -1, 16382.5F}));
}

}  // namespace
}  // namespace octavo::testing
