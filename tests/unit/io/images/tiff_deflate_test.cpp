#include "octavo/io/images/tiff_deflate.h"

#include <gtest/gtest.h>
#include <tiffio.h>
#include <zlib.h>

#include <string>

#include "octavo/io/source/byte_order.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

std::string zlib_stream(const std::string& bytes) {
  uLongf length = compressBound(static_cast<uLong>(bytes.size()));
  std::string stream(length, '\0');
  compress(reinterpret_cast<Bytef*>(stream.data()), &length,
           reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
  stream.resize(length);
  return stream;
}

/// Values that hardly shrink.
std::string uneven_bytes(std::size_t count) {
  std::string bytes;
  std::uint32_t state = 7;
  for (std::size_t i = 0; i < count; ++i) {
    state = state * 1664525 + 1013904223;
    bytes += static_cast<char>(state >> 24);
  }
  return bytes;
}

InflatedLength length_of(const TempFolder& folder, const std::string& block, std::uint64_t most,
                         bool is_mirrored = false) {
  write_file(folder.file("block"), "head" + block + "tail");
  return inflated_length(SourceFile(folder.file("block")), {4, block.size(), is_mirrored}, most);
}

TEST(TiffDeflate, LengthIsThatOfTheWholeStream) {
  const TempFolder folder;
  for (const std::size_t count : {0U, 1U, 1000U, 32768U, 65536U, 200000U}) {
    for (const std::string& bytes : {uneven_bytes(count), std::string(count, 'x')}) {
      std::string stream = zlib_stream(bytes);
      for (const char* behind : {"", "some more"}) {
        const InflatedLength found = length_of(folder, stream + behind, count);
        EXPECT_EQ(found.bytes, count);
        EXPECT_EQ(found.damage, "");
      }
      TIFFReverseBits(reinterpret_cast<std::uint8_t*>(stream.data()),
                      static_cast<tmsize_t>(stream.size()));
      const InflatedLength mirrored = length_of(folder, stream, count, true);
      EXPECT_EQ(mirrored.bytes, count);
      EXPECT_EQ(mirrored.damage, "");
    }
  }
}

TEST(TiffDeflate, DamageIsNamed) {
  const TempFolder folder;
  const std::string stream = zlib_stream(uneven_bytes(300));
  for (std::size_t length = 0; length < stream.size(); ++length) {
    EXPECT_EQ(length_of(folder, stream.substr(0, length), 300).damage, "its stream ends early");
  }
  std::string wrong = stream;
  wrong.back() = static_cast<char>(wrong.back() ^ 1);
  EXPECT_EQ(length_of(folder, wrong, 300).damage, "incorrect data check");
  EXPECT_NE(length_of(folder, "no stream at all", 300).damage, "");
  // "x\xbb": a head that names a dictionary.
  EXPECT_EQ(length_of(folder, "x\xbb" + stream, 300).damage, "its stream asks for a dictionary");
}

TEST(TiffDeflate, StreamsThatMakeTooMuchAreLeft) {
  const TempFolder folder;
  const InflatedLength found = length_of(folder, zlib_stream(std::string(10'000'000, 'x')), 100);
  EXPECT_GT(found.bytes, 100U);
  EXPECT_LT(found.bytes, 100'000U);
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
        const DeflatedBlock block = {4, file.size() - 4, false};
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
  const auto is_proven = [&](const DeflatedBlock& block, TiffPrediction prediction) {
    return ends_with_checksum_of(file, block, prediction, layout, bytes);
  };
  EXPECT_TRUE(is_proven({0, file.size(), false}, TiffPrediction::none));
  EXPECT_FALSE(is_proven({0, file.size(), false}, TiffPrediction::float_bytes));
  EXPECT_FALSE(is_proven({0, file.size(), true}, TiffPrediction::none));
  EXPECT_FALSE(is_proven({0, 4, false}, TiffPrediction::none));
  EXPECT_FALSE(is_proven({0, file.size() + 2, false}, TiffPrediction::none));
}

}  // namespace
}  // namespace octavo::testing
