#include "octavo/io/images/tiff_deflate.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <string>

#include "octavo/io/source/byte_order.h"
#include "support/source_files.h"
#include "support/tiff_block_rows.h"

namespace octavo::testing {
namespace {

constexpr BlockDecoder inflated{inflate_rows};

TEST(TiffDeflate, RowsAreTheFirstBytesOfTheStream) {
  const TempFolder folder;
  for (const std::size_t count : {0U, 1U, 1000U, 32768U, 65536U, 200000U}) {
    for (const std::string& bytes : {uneven_bytes(count), std::string(count, 'x')}) {
      std::string stream = zlib_stream(bytes);
      for (const char* behind : {"", "some more"}) {
        for (const std::size_t rows : {std::size_t{0}, count / 3, count}) {
          const BlockRows whole = inflated(folder, stream + behind, rows, count);
          EXPECT_EQ(whole.made.count, count);
          EXPECT_EQ(whole.made.damage, "");
          EXPECT_EQ(whole.rows, bytes.substr(0, rows));
        }
      }
      TIFFReverseBits(reinterpret_cast<std::uint8_t*>(stream.data()),
                      static_cast<tmsize_t>(stream.size()));
      const BlockRows mirrored = inflated(folder, stream, count, count, true);
      EXPECT_EQ(mirrored.made.count, count);
      EXPECT_EQ(mirrored.made.damage, "");
      EXPECT_EQ(mirrored.rows, bytes);
    }
  }
}

TEST(TiffDeflate, DamageIsNamed) {
  const TempFolder folder;
  const auto damage_of = [&](const std::string& block) {
    return inflated(folder, block, 300, 300).made.damage;
  };
  const std::string stream = zlib_stream(uneven_bytes(300));
  for (std::size_t length = 0; length < stream.size(); ++length) {
    EXPECT_EQ(damage_of(stream.substr(0, length)), "its stream ends early");
  }
  std::string wrong = stream;
  wrong.back() = static_cast<char>(wrong.back() ^ 1);
  EXPECT_EQ(damage_of(wrong), "incorrect data check");
  EXPECT_NE(damage_of("no stream at all"), "");
  // "x\xbb": a head that names a dictionary.
  EXPECT_EQ(damage_of("x\xbb" + stream), "its stream asks for a dictionary");
}

TEST(TiffDeflate, StreamsThatMakeTooMuchAreLeft) {
  const TempFolder folder;
  const BlockRows left = inflated(folder, zlib_stream(std::string(10'000'000, 'x')), 50, 100);
  EXPECT_GT(left.made.count, 100U);
  EXPECT_LT(left.made.count, 100'000U);
  EXPECT_EQ(left.rows, std::string(50, 'x'));
}

TEST(TiffDeflate, ChecksumIsThatOfRowsAsTheyAreStored) {
  const TempFolder folder;
  for (const std::size_t value_bytes : {1U, 2U, 4U, 8U}) {
    for (const bool are_swapped : {false, true}) {
      for (const std::size_t step : {1U, 3U}) {
        const PredictedRows layout = {step * 5, step, value_bytes, are_swapped};
        const std::string stored = uneven_bytes(4 * layout.row_values * value_bytes);
        write_file(folder.file("block"), "head" + zlib_stream(stored));
        const SourceFile file(folder.file("block"));
        const CodedBlock block = {4, file.size() - 4, false};
        for (const TiffPrediction prediction :
             {TiffPrediction::none, TiffPrediction::differences}) {
          std::string rows = stored;
          const auto bytes = std::as_writable_bytes(std::span(rows));
          if (are_swapped) swap_values(bytes, value_bytes);
          undo_prediction(prediction, layout, bytes);
          EXPECT_TRUE(ends_with_checksum_of(file, block, prediction, layout, bytes))
              << value_bytes << are_swapped << step;
          rows[rows.size() / 2] = static_cast<char>(rows[rows.size() / 2] ^ 4);
          EXPECT_FALSE(ends_with_checksum_of(file, block, prediction, layout, bytes));
        }
      }
    }
  }
}

TEST(TiffDeflate, ChecksumIsUnknownOfFloatBytesMirrorsAndBlocksOutsideTheFile) {
  const TempFolder folder;
  const std::string rows = uneven_bytes(16);
  write_file(folder.file("block"), zlib_stream(rows));
  const SourceFile file(folder.file("block"));
  const PredictedRows layout = {4, 1, 4, false};
  const auto bytes = std::as_bytes(std::span(rows));
  const auto is_proven = [&](const CodedBlock& block, TiffPrediction prediction) {
    return ends_with_checksum_of(file, block, prediction, layout, bytes);
  };
  EXPECT_TRUE(is_proven({0, file.size(), false}, TiffPrediction::none));
  EXPECT_TRUE(may_end_with_checksum({0, 5, false}, TiffPrediction::differences));
  EXPECT_FALSE(may_end_with_checksum({0, 5, true}, TiffPrediction::none));
  EXPECT_FALSE(is_proven({0, file.size(), false}, TiffPrediction::float_bytes));
  EXPECT_FALSE(is_proven({0, file.size(), true}, TiffPrediction::none));
  EXPECT_FALSE(is_proven({0, 4, false}, TiffPrediction::none));
  EXPECT_FALSE(is_proven({0, file.size() + 2, false}, TiffPrediction::none));
}

}  // namespace
}  // namespace octavo::testing
