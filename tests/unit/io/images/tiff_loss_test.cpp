#include "octavo/io/images/tiff_loss.h"

#include <gtest/gtest.h>

#include <tiffio.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

bool is_lossy(std::uint16_t compression, const StoredType& type, const std::string& start) {
  return is_lossy_block(compression, type, std::as_bytes(std::span(start)));
}

/// The start of a LERC block of that version with that error.
std::string lerc_start(std::int32_t version, double error) {
  const std::size_t more = version == 2 ? 6 : version == 3 ? 7 : 8;
  std::string block = "Lerc2 " + bytes_of<std::int32_t>({version});
  for (std::size_t i = 0; i < more; ++i) block += bytes_of<std::int32_t>({40});
  block += bytes_of<double>({error});
  block.resize(kBlockStartBytes, '\x11');
  return block;
}

TEST(TiffLoss, OfLercIsItsError) {
  for (const std::int32_t version : {2, 3, 4, 5}) {
    const auto lossy = [&](const StoredType& type, double error) {
      return is_lossy(COMPRESSION_LERC, type, lerc_start(version, error));
    };
    EXPECT_FALSE(lossy(VoxelType::uint16, 0.5)) << version;
    EXPECT_FALSE(lossy(VoxelType::uint8, 0)) << version;
    EXPECT_TRUE(lossy(VoxelType::uint16, 1)) << version;
    EXPECT_FALSE(lossy(VoxelType::float32, 0)) << version;
    EXPECT_TRUE(lossy(VoxelType::float32, 1e-9)) << version;
    EXPECT_TRUE(lossy(WideType::float64, 0.5)) << version;
  }
  EXPECT_TRUE(is_lossy(COMPRESSION_LERC, VoxelType::uint8, lerc_start(6, 0)));
  EXPECT_TRUE(is_lossy(COMPRESSION_LERC, VoxelType::uint8, lerc_start(4, 0).substr(0, 50)));
  EXPECT_TRUE(is_lossy(COMPRESSION_LERC, VoxelType::uint8, std::string(kBlockStartBytes, 'x')));
}

TEST(TiffLoss, OfWebPIsThatOfItsPicture) {
  EXPECT_FALSE(is_lossy(COMPRESSION_WEBP, VoxelType::uint8, "RIFF1234WEBPVP8L...."));
  EXPECT_TRUE(is_lossy(COMPRESSION_WEBP, VoxelType::uint8, "RIFF1234WEBPVP8 ...."));
  EXPECT_TRUE(is_lossy(COMPRESSION_WEBP, VoxelType::uint8, "RIFF"));
}

TEST(TiffLoss, OfOtherKindsIsKnown) {
  EXPECT_TRUE(is_lossy(COMPRESSION_JPEG, VoxelType::uint8, ""));
  EXPECT_FALSE(is_lossy(COMPRESSION_LZW, VoxelType::uint8, ""));
  EXPECT_TRUE(has_varying_loss(COMPRESSION_LERC));
  EXPECT_FALSE(has_varying_loss(COMPRESSION_JPEG));
}

}  // namespace
}  // namespace octavo::testing
