#include "octavo/io/dicom/dicom_palette.h"

#include <gtest/gtest.h>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::uint32_t kDescriptor = 0x00281101;
constexpr std::uint32_t kTable = 0x00281201;

/// A picture of the values 0 to 5 whose palette has four colors, from the value 1 on.
DicomElements palette_elements(std::uint16_t bits) {
  DicomElements elements = ct_elements(3, 2, 8);
  elements.set(0x00280004, "CS", "PALETTE COLOR");
  elements.set(0x7fe00010, "OB", std::string("\0\1\2\3\4\5", 6));
  for (std::uint32_t color = 0; color < 3; ++color) {
    elements.set(kDescriptor + color, "US", bytes_of<std::uint16_t>({4, 1, bits}));
    std::vector<std::uint16_t> colors;
    for (std::uint32_t i = 0; i < 4; ++i) {
      colors.push_back(static_cast<std::uint16_t>((bits == 8 ? 1 : 256) * (10 * (color + 1) + i)));
    }
    elements.set(kTable + color, "OW", bytes_of(colors));
  }
  return elements;
}

SourceOptions of_channel(const std::string& channel) {
  SourceOptions options;
  options.channel = channel;
  return options;
}

class SourceDicomPalette : public ::testing::Test {
 protected:
  std::string voxels(const DicomElements& elements, const std::string& channel) {
    elements.write(path_, kExplicitLittle);
    const auto source = open_source({path_}, of_channel(channel));
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"name\":\"" + channel + "\""));
    type_ = source->description().type;
    return voxels_of(*source);
  }

  TempFolder folder_;
  std::string path_ = folder_.file("a.dcm");
  VoxelType type_ = VoxelType::uint8;
};

TEST_F(SourceDicomPalette, TheIndexOrAColorIsTaken) {
  const DicomElements bytes = palette_elements(8);
  EXPECT_EQ(voxels(bytes, "index"), std::string("\0\1\2\3\4\5", 6));
  // Values outside of the table take the color that is nearest.
  EXPECT_EQ(voxels(bytes, "red"), bytes_of<std::uint8_t>({10, 10, 11, 12, 13, 13}));
  EXPECT_EQ(voxels(bytes, "blue"), bytes_of<std::uint8_t>({30, 30, 31, 32, 33, 33}));
  EXPECT_EQ(type_, VoxelType::uint8);
  EXPECT_EQ(voxels(palette_elements(16), "green"),
            bytes_of<std::uint16_t>({5120, 5120, 5376, 5632, 5888, 5888}));
  EXPECT_EQ(type_, VoxelType::uint16);
}

TEST_F(SourceDicomPalette, ColorsOfEightBitsMayShareWords) {
  DicomElements elements = palette_elements(8);
  elements.set(kTable, "OW", std::string("\1\2\3\4", 4));
  EXPECT_EQ(voxels(elements, "red"), bytes_of<std::uint8_t>({1, 1, 2, 3, 4, 4}));
}

TEST_F(SourceDicomPalette, NothingIsTakenUnasked) {
  palette_elements(8).write(path_, kExplicitLittle);
  const Error error = source_error({path_});
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  EXPECT_TRUE(contains(error, "4 channels (index, red, green, blue)")) << error.what();
}

TEST_F(SourceDicomPalette, ATableThatDoesNotFitIsRejectedButTheIndexIsTaken) {
  for (const std::size_t length : {0U, 2U, 6U, 10U}) {
    DicomElements elements = palette_elements(16);
    elements.set(kTable + 1, "OW", std::string(length, 'x'));
    elements.write(path_, kExplicitLittle);
    const Error error = source_error({path_}, of_channel("green"));
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, "(0028,1202)")) << error.what();
    EXPECT_EQ(voxels(elements, "index"), std::string("\0\1\2\3\4\5", 6));
  }
}

}  // namespace
}  // namespace octavo::testing
