#include "octavo/io/images/tiff_zstd.h"

#include <gtest/gtest.h>
#include <tiffio.h>
#include <zstd.h>

#include <string>

#include "support/source_files.h"
#include "support/tiff_block_rows.h"

namespace octavo::testing {
namespace {

std::string zstd_frame(const std::string& bytes, bool has_checksum) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, has_checksum ? 1 : 0);
  std::string frame(ZSTD_compressBound(bytes.size()), '\0');
  frame.resize(
      ZSTD_compress2(context, frame.data(), frame.size(), bytes.data(), bytes.size()));
  ZSTD_freeCCtx(context);
  return frame;
}

constexpr BlockDecoder unpacked{unpack_zstd_rows};

TEST(TiffZstd, RowsAreTheFirstBytesOfTheFrame) {
  const TempFolder folder;
  for (const std::size_t count : {0U, 1U, 1000U, 32768U, 200000U}) {
    for (const std::string& bytes : {uneven_bytes(count), std::string(count, 'x')}) {
      for (const bool has_checksum : {false, true}) {
        std::string frame = zstd_frame(bytes, has_checksum);
        for (const std::size_t rows : {std::size_t{0}, count / 3, count}) {
          const BlockRows whole = unpacked(folder, frame + "some more", rows, count);
          EXPECT_EQ(whole.made.count, count);
          EXPECT_EQ(whole.made.damage, "");
          EXPECT_EQ(whole.rows, bytes.substr(0, rows));
        }
        TIFFReverseBits(reinterpret_cast<std::uint8_t*>(frame.data()),
                        static_cast<tmsize_t>(frame.size()));
        const BlockRows mirrored = unpacked(folder, frame, count, count, true);
        EXPECT_EQ(mirrored.made.damage, "");
        EXPECT_EQ(mirrored.rows, bytes);
      }
    }
  }
}

TEST(TiffZstd, DamageIsNamed) {
  const TempFolder folder;
  const auto damage_of = [&](const std::string& block) {
    return unpacked(folder, block, 3000, 3000).made.damage;
  };
  for (const bool has_checksum : {false, true}) {
    const std::string frame = zstd_frame(uneven_bytes(3000), has_checksum);
    for (std::size_t length = 0; length < frame.size(); length += length < 2900 ? 97 : 1) {
      EXPECT_EQ(damage_of(frame.substr(0, length)), "its frame ends early") << length;
    }
    std::string wrong = frame;
    wrong[2000] = static_cast<char>(wrong[2000] ^ 1);
    EXPECT_EQ(damage_of(wrong).empty(), !has_checksum);
  }
  EXPECT_NE(damage_of("no frame at all"), "");
}

TEST(TiffZstd, FramesThatMakeTooMuchAreLeft) {
  const TempFolder folder;
  const BlockRows left =
      unpacked(folder, zstd_frame(std::string(10'000'000, 'x'), false), 50, 100);
  EXPECT_GT(left.made.count, 100U);
  EXPECT_LT(left.made.count, 100'000U);
  EXPECT_EQ(left.rows, std::string(50, 'x'));
}

}  // namespace
}  // namespace octavo::testing
