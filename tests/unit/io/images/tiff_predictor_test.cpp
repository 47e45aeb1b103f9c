#include "octavo/io/images/tiff_predictor.h"

#include <gtest/gtest.h>

#include <tiffio.h>

#include <string>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

using namespace std::string_literals;

std::string undone(TiffPrediction prediction, const PredictedRows& layout, std::string rows) {
  undo_prediction(prediction, layout, std::as_writable_bytes(std::span(rows)));
  return rows;
}

TEST(TiffPredictor, IsLeftByCodecsThatDoNotUndoIt) {
  for (const int kind : {COMPRESSION_PACKBITS, COMPRESSION_LERC}) {
    const auto codec = static_cast<std::uint16_t>(kind);
    EXPECT_EQ(prediction_left(codec, 1, VoxelType::int16), TiffPrediction::none);
    EXPECT_EQ(prediction_left(codec, 2, VoxelType::int16), TiffPrediction::differences);
    EXPECT_EQ(prediction_left(codec, 2, WideType::uint64), TiffPrediction::differences);
    EXPECT_FALSE(prediction_left(codec, 2, VoxelType::float32));
    EXPECT_FALSE(prediction_left(codec, 3, VoxelType::int16));
    EXPECT_FALSE(prediction_left(codec, 34892, VoxelType::int16));
  }
  for (const StoredType type : {StoredType(VoxelType::float32), StoredType(WideType::float64)}) {
    EXPECT_EQ(prediction_left(COMPRESSION_PACKBITS, 3, type), TiffPrediction::float_bytes);
    EXPECT_FALSE(prediction_left(COMPRESSION_LERC, 3, type));
  }
  for (const int kind :
       {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_LZMA, COMPRESSION_JPEG,
        COMPRESSION_WEBP}) {
    const auto codec = static_cast<std::uint16_t>(kind);
    EXPECT_EQ(prediction_left(codec, 2, VoxelType::int16), TiffPrediction::none) << codec;
  }
}

TEST(TiffPredictor, OfDeflateAndZstdStandsInTheStream) {
  for (const int kind : {COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE, COMPRESSION_ZSTD}) {
    const auto codec = static_cast<std::uint16_t>(kind);
    for (const StoredType type :
         {StoredType(VoxelType::uint8), StoredType(VoxelType::float32)}) {
      EXPECT_EQ(prediction_left(codec, 1, type), TiffPrediction::none);
      EXPECT_EQ(prediction_left(codec, 2, type), TiffPrediction::differences);
      EXPECT_FALSE(prediction_left(codec, 0, type));
      EXPECT_FALSE(prediction_left(codec, 34892, type));
    }
    EXPECT_EQ(prediction_left(codec, 3, VoxelType::float32), TiffPrediction::float_bytes);
    EXPECT_FALSE(prediction_left(codec, 3, VoxelType::uint8));
  }
}

TEST(TiffPredictor, StepsAddUpAlongEachRowOfEachSample) {
  const std::string rows = bytes_of<std::uint8_t>({1, 2, 3, 255, 9, 1, 1, 1});
  EXPECT_EQ(undone(TiffPrediction::differences, {4, 1, 1, true}, rows),
            bytes_of<std::uint8_t>({1, 3, 6, 5, 9, 10, 11, 12}));
  EXPECT_EQ(undone(TiffPrediction::differences, {8, 2, 1, false}, rows),
            bytes_of<std::uint8_t>({1, 2, 4, 1, 13, 2, 14, 3}));
  EXPECT_EQ(undone(TiffPrediction::differences, {3, 1, 2, false},
                   bytes_of<std::int16_t>({-5, 300, -1, 32767, 1, 0})),
            bytes_of<std::int16_t>({-5, 295, 294, 32767, -32768, -32768}));
  EXPECT_EQ(undone(TiffPrediction::differences, {2, 1, 4, false},
                   bytes_of<std::int32_t>({100000, -1, 7, 8})),
            bytes_of<std::int32_t>({100000, 99999, 7, 15}));
  EXPECT_EQ(undone(TiffPrediction::differences, {2, 1, 8, false},
                   bytes_of<std::int64_t>({std::int64_t{1} << 40, -1})),
            bytes_of<std::int64_t>({std::int64_t{1} << 40, (std::int64_t{1} << 40) - 1}));
  EXPECT_EQ(undone(TiffPrediction::none, {4, 1, 1, false}, rows), rows);
}

TEST(TiffPredictor, BytesOfFloatsComeTogether) {
  // 1.5 is 3f c0 00 00, -2 is c0 00 00 00: first bytes 3f c0, then c0 00 00 00 00 00.
  const std::string steps = "\x3f\x81\x00\x40\x00\x00\x00\x00"s;
  const std::string values = bytes_of<float>({1.5F, -2.0F});
  EXPECT_EQ(undone(TiffPrediction::float_bytes, {2, 1, 4, false}, steps), values);
  const std::string swapped = "\x40\x00\x81\x3f\x00\x00\x00\x00"s;
  EXPECT_EQ(undone(TiffPrediction::float_bytes, {2, 1, 4, true}, swapped + swapped),
            values + values);
  // Steps from the byte of the same sample before: 3f c0 | c0-3f 00-c0 | ...
  const std::string of_two = "\x3f\xc0\x81\x40\x40\x00\x00\x00"s;
  EXPECT_EQ(undone(TiffPrediction::float_bytes, {2, 2, 4, false}, of_two), values);
}

}  // namespace
}  // namespace octavo::testing
