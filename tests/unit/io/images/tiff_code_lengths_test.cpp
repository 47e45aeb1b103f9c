#include "octavo/io/images/tiff_code_lengths.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <string>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// The block that libtiff makes of bytes.
std::string coded_by_libtiff(const TempFolder& folder, const std::string& bytes, int compression) {
  TiffSample sample;
  sample.width = static_cast<std::uint32_t>(bytes.size());
  sample.height = 1;
  sample.compression = static_cast<std::uint16_t>(compression);
  sample.pages = {bytes};
  write_tiff(folder.file("a.tif"), sample);
  TIFF* tiff = TIFFOpen(folder.file("a.tif").c_str(), "r");
  std::string block(2 * bytes.size() + 100, '\0');
  const tmsize_t length =
      TIFFReadRawStrip(tiff, 0, block.data(), static_cast<tmsize_t>(block.size()));
  TIFFClose(tiff);
  EXPECT_GT(length, 0);
  block.resize(static_cast<std::size_t>(std::max<tmsize_t>(length, 0)));
  return block;
}

MadeBytes bytes_by(int compression, const std::string& coded, const WantedRows& rows) {
  const auto bytes = std::as_bytes(std::span(coded));
  if (compression == COMPRESSION_PACKBITS) return packbits_bytes(bytes, rows);
  const std::optional<MadeBytes> made = lzw_bytes(bytes, rows);
  EXPECT_TRUE(made);
  return made.value_or(MadeBytes());
}

MadeBytes made_by(int compression, const std::string& coded, std::uint64_t wanted,
                  std::uint64_t most) {
  return bytes_by(compression, coded, {wanted, most, 1});
}

std::vector<std::string> samples() {
  std::vector<std::string> all;
  for (const std::size_t count : {1U, 2U, 100U, 5000U, 60000U}) {
    all.push_back(uneven_bytes(count));
    all.push_back(std::string(count, 'x'));
    all.push_back(counted(count, 3));
  }
  return all;
}

TEST(TiffCodeLengths, AreThoseOfWhatWasCoded) {
  const TempFolder folder;
  for (const int compression : {COMPRESSION_LZW, COMPRESSION_PACKBITS}) {
    for (const std::string& bytes : samples()) {
      const std::string coded = coded_by_libtiff(folder, bytes, compression);
      for (const std::string& behind : {std::string(), std::string(3, '\0')}) {
        const MadeBytes made = made_by(compression, coded + behind, bytes.size(), bytes.size());
        EXPECT_EQ(made.count, bytes.size()) << compression;
        EXPECT_EQ(made.damage, "");
      }
      // Rows behind those that are wanted count as well.
      const MadeBytes more =
          bytes_by(compression, coded, {(bytes.size() + 1) / 2, bytes.size(), bytes.size()});
      EXPECT_EQ(more.count, bytes.size()) << compression;
    }
  }
}

TEST(TiffCodeLengths, AreFewerWhereCodesAreCut) {
  const TempFolder folder;
  const std::string bytes = uneven_bytes(300);
  for (const int compression : {COMPRESSION_LZW, COMPRESSION_PACKBITS}) {
    const std::string coded = coded_by_libtiff(folder, bytes, compression);
    // Of the code of the end, no byte is needed.
    const std::size_t end = compression == COMPRESSION_LZW ? 2 : 0;
    for (std::size_t length = 2; length + end < coded.size(); ++length) {
      const MadeBytes made = made_by(compression, coded.substr(0, length), 300, 300);
      EXPECT_TRUE(made.count < 300 || !made.damage.empty()) << compression << " " << length;
    }
  }
}

TEST(TiffCodeLengths, StopBehindTheMostThatIsAllowed) {
  const TempFolder folder;
  const std::string bytes(60000, 'x');
  for (const int compression : {COMPRESSION_LZW, COMPRESSION_PACKBITS}) {
    const MadeBytes made =
        made_by(compression, coded_by_libtiff(folder, bytes, compression), 100, 200);
    EXPECT_GT(made.count, 200U);
    EXPECT_LT(made.count, 5000U);
  }
}

TEST(TiffCodeLengths, CodesWithoutAStringAreDamage) {
  // The code of clearing, then 300, of which the table knows nothing.
  EXPECT_NE(made_by(COMPRESSION_LZW, "\x80\x4b\x30", 10, 10).damage, "");
  EXPECT_NE(made_by(COMPRESSION_PACKBITS, "\5abc", 10, 10).damage, "");
}

TEST(TiffCodeLengths, AreUnknownOfOtherKindsOfLzw) {
  for (const std::string& coded : {std::string(), std::string("\0\1abc", 5), std::string("abcd")}) {
    EXPECT_FALSE(lzw_bytes(std::as_bytes(std::span(coded)), {10, 10, 1}));
  }
}

}  // namespace
}  // namespace octavo::testing
