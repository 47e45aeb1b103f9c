#include "octavo/io/dicom/dicom_cielab.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace octavo {
namespace {

struct EncodedColor {
  std::array<std::uint16_t, 3> encoded;
  LabelColor color;
};

// As highdicom encodes these colors
TEST(DicomCielab, BecomesTheColorThatItWasMadeOf) {
  for (const auto& [encoded, color] : std::vector<EncodedColor>{
           {{0, 32896, 32896}, {0, 0, 0}},
           {{65535, 32897, 32893}, {255, 255, 255}},
           {{34886, 53484, 50172}, {255, 0, 0}},
           {{30619, 21203, 39669}, {0, 128, 64}},
           {{41677, 41270, 39511}, {220, 130, 110}},
           {{49286, 27231, 23026}, {12, 200, 255}},
           {{35117, 32897, 32894}, {128, 128, 128}},
           {{334, 32865, 32775}, {1, 2, 3}}}) {
    EXPECT_EQ(color_of_cielab(encoded), color) << encoded[0];
  }
}

TEST(DicomCielab, BeyondSrgbIsBroughtToItsEnds) {
  EXPECT_EQ(color_of_cielab(std::array<std::uint16_t, 3>{65535, 65535, 65535}),
            (LabelColor{255, 70, 0}));
  EXPECT_EQ(color_of_cielab(std::array<std::uint16_t, 3>{32768, 0, 65535}),
            (LabelColor{0, 152, 0}));
  EXPECT_EQ(color_of_cielab(std::array<std::uint16_t, 3>{65535, 0, 0}),
            (LabelColor{0, 255, 255}));
}

TEST(DicomCielab, OfOtherThanThreeNumbersIsNoColor) {
  for (const std::size_t count : {0U, 1U, 2U, 4U}) {
    EXPECT_FALSE(color_of_cielab(std::vector<std::uint16_t>(count, 32896))) << count;
  }
}

}  // namespace
}  // namespace octavo
