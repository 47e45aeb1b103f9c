#include "octavo/io/images/tiff_page.h"

#include <gtest/gtest.h>

#include <tiffio.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// The steps along rows of `width` pixels of some samples, in place of their values.
template <class T>
std::string steps_of(const std::vector<T>& values, std::size_t width, std::size_t samples) {
  std::vector<T> steps = values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool is_first = i % (width * samples) < samples;
    if (!is_first) steps[i] = static_cast<T>(values[i] - values[i - samples]);
  }
  return bytes_of(steps);
}

TEST(TiffPage, OfPackBitsHasItsPredictorUndone) {
  const TempFolder folder;
  constexpr std::uint32_t kWidth = 19;
  constexpr std::uint32_t kHeight = 21;
  std::vector<std::int16_t> values;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
    values.push_back(static_cast<std::int16_t>(i * i * 37));
  }
  for (const bool big_endian : {false, true}) {
    for (const std::uint32_t tile : {0U, 16U}) {
      TiffSample sample;
      sample.width = kWidth;
      sample.height = kHeight;
      sample.bits = 16;
      sample.format = 2;
      sample.compression = COMPRESSION_PACKBITS;
      sample.big_endian = big_endian;
      sample.rows_per_strip = 4;
      sample.tile = tile;
      sample.tags = {{TIFFTAG_PREDICTOR, TIFF_SHORT, 1, bytes_of<std::uint16_t>({2})}};
      // A tile begins its rows anew.
      std::vector<std::int16_t> steps = values;
      for (std::uint32_t i = 0; i < values.size(); ++i) {
        const std::uint32_t x = i % kWidth;
        if (x % (tile == 0 ? kWidth : tile) > 0) {
          steps[i] = static_cast<std::int16_t>(values[i] - values[i - 1]);
        }
      }
      sample.pages = {bytes_of(steps)};
      write_tiff(folder.file("a.tif"), sample);
      const auto source = open_source({folder.file("a.tif")}, {});
      EXPECT_EQ(voxels_of(*source), bytes_of(values)) << big_endian << " " << tile;
      EXPECT_FALSE(contains(source->description().metadata.text(), "Tag 317"));
    }
  }
}

TEST(TiffPage, OfPackBitsThatMakeMoreThanABlockIsRejected) {
  const TempFolder folder;
  TiffSample sample;
  sample.compression = COMPRESSION_PACKBITS;
  sample.pages = {counted(12, 1)};
  const std::string row = '\3' + counted(4, 1);
  const auto damaged = [&](char run, const std::string& packed) {
    write_tiff(folder.file("a.tif"), sample);
    std::string bytes = read_file(folder.file("a.tif"));
    const std::size_t at = bytes.find(packed);
    ASSERT_NE(at, std::string::npos);
    bytes[at] = run;
    write_file(folder.file("a.tif"), bytes);
  };
  damaged('\x81', row);  // the first value 128 times
  expect_rejected(folder.file("a.tif"),
                  {"strip 0 of page 0 is damaged (its codes make more than its 12 bytes)"});
  // The last strip may go on behind the page.
  for (const std::uint32_t rows : {2U, 4U, 100U}) {
    sample.rows_per_strip = rows;
    damaged('\xf9', '\3' + sample.pages[0].substr(8));  // its first value 8 times
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})),
              sample.pages[0].substr(0, 8) + std::string(4, sample.pages[0][8]));
  }
}

TiffSample deflated_picture(std::uint32_t tile) {
  TiffSample sample;
  sample.width = 16;
  sample.height = 16;
  sample.compression = COMPRESSION_ADOBE_DEFLATE;
  sample.tile = tile;
  sample.pages = {std::string(256, '\0')};
  return sample;
}

TiffSample jpeg_picture() {
  TiffSample sample;
  sample.width = 64;
  sample.height = 64;
  sample.compression = COMPRESSION_JPEG;
  sample.rows_per_strip = 64;
  sample.pages = {counted(64 * 64, 1)};
  return sample;
}

TEST(TiffPage, OfJpegWithoutAllItsValuesIsRejected) {
  const TempFolder folder;
  write_tiff(folder.file("a.tif"), jpeg_picture());
  const std::string whole = read_file(folder.file("a.tif"));
  const std::size_t end = whole.find("\xff\xd9", whole.find("\xff\xda"));
  ASSERT_NE(end, std::string::npos);
  // The mark behind the last value may lack.
  std::string bytes = whole;
  bytes.replace(end, 2, 2, '\0');
  write_file(folder.file("a.tif"), bytes);
  EXPECT_EQ(open_source({folder.file("a.tif")}, {})->description().size, (Size3{64, 64, 1}));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})).size(), 64U * 64);
  // A mark in the middle ends them.
  bytes = whole;
  bytes.replace(end - 200, 2, "\xff\xd9");
  write_file(folder.file("a.tif"), bytes);
  expect_rejected(folder.file("a.tif"), {"strip 0 of page 0 is damaged (Corrupt JPEG data"});
}

TEST(TiffPage, OfJpegCutByItsByteCountIsRejected) {
  const TempFolder folder;
  write_tiff(folder.file("a.tif"), jpeg_picture());
  std::string bytes = read_file(folder.file("a.tif"));
  const std::uint32_t count = number_of(bytes, TIFFTAG_STRIPBYTECOUNTS);
  set_number(bytes, TIFFTAG_STRIPBYTECOUNTS, count - 2);
  write_file(folder.file("a.tif"), bytes);  // without its last mark
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})).size(), 64U * 64);
  set_number(bytes, TIFFTAG_STRIPBYTECOUNTS, count / 2);
  write_file(folder.file("a.tif"), bytes);
  expect_rejected(folder.file("a.tif"), {"strip 0 of page 0 is damaged (its picture ends before"});
}

TEST(TiffPage, OfLosslessJpegIsSaidNotToBeRead) {
  const TempFolder folder;
  write_tiff(folder.file("a.tif"), jpeg_picture());
  std::string bytes = read_file(folder.file("a.tif"));
  const std::size_t frame = bytes.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  bytes[frame + 1] = '\xc3';
  write_file(folder.file("a.tif"), bytes);
  const Error error = source_error({folder.file("a.tif")});
  EXPECT_TRUE(contains(error, "process of JPEG that is not read")) << with_hints(error);
  EXPECT_FALSE(contains(error, "damaged")) << with_hints(error);
}

TEST(TiffPage, ThatLeadsBackToOneInFrontIsRejected) {
  const TempFolder folder;
  for (const bool big : {false, true}) {
    TiffSample sample;
    sample.big = big;
    for (int i = 0; i < 3; ++i) sample.pages.push_back(counted(12, i));
    write_tiff(folder.file("a.tif"), sample);
    std::string bytes = read_file(folder.file("a.tif"));
    const std::size_t width = big ? 8 : 4;
    // Where the link to each directory stands, from that in the head on
    std::vector<std::size_t> links = {big ? 8U : 4U};
    for (int i = 0; i < 3; ++i) {
      std::uint64_t at = 0;
      std::memcpy(&at, bytes.data() + links.back(), width);
      std::uint16_t count = 0;
      std::memcpy(&count, bytes.data() + at, sizeof count);
      links.push_back(at + (big ? 8 + std::size_t{20} * count : 2 + std::size_t{12} * count));
    }
    for (std::size_t target = 0; target < 3; ++target) {
      std::string other = bytes;
      other.replace(links[3], width, bytes.substr(links[target], width));
      write_file(folder.file("a.tif"), other);
      expect_rejected(folder.file("a.tif"), {"page 2 is followed by byte", "page in front"});
    }
  }
}

TEST(TiffPage, OfStripsThatClaimFarTooManyBytesIsRejectedAtTheFirstOne) {
  const TempFolder folder;
  TiffSample sample = jpeg_picture();
  sample.rows_per_strip = 8;
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif"));
  constexpr std::uint32_t kClaimed = 300'000'000;
  set_numbers(bytes, TIFFTAG_STRIPBYTECOUNTS, std::vector<std::uint32_t>(8, kClaimed));
  write_file(folder.file("a.tif"), bytes);
  std::filesystem::resize_file(folder.file("a.tif"), 2 * std::uintmax_t{kClaimed});
  expect_rejected(folder.file("a.tif"),
                  {"strip 0 of page 0 is damaged (Too large strip byte count"});
}

TEST(TiffPage, OfSeveralIsNamedWhereItIsDamaged) {
  const TempFolder folder;
  TiffSample sample = deflated_picture(0);
  for (int i = 0; i < 2; ++i) sample.pages.push_back(counted(256, i));
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif"));
  set_number(bytes, TIFFTAG_STRIPBYTECOUNTS, number_of(bytes, TIFFTAG_STRIPBYTECOUNTS) - 1);
  write_file(folder.file("a.tif"), bytes);
  expect_rejected(folder.file("a.tif"), {"strip 0 of page 2 is damaged"});
}

/// A picture of one strip or tile of 16 x 16 values, with another block.
/// counted_bytes  of the block, as its tag says
void write_block(const std::string& path, const TiffSample& sample, const std::string& block,
                 std::size_t counted_bytes) {
  write_tiff(path, sample);
  std::string bytes = read_file(path);
  const bool is_tile = sample.tile > 0;
  set_number(bytes, is_tile ? TIFFTAG_TILEOFFSETS : TIFFTAG_STRIPOFFSETS,
             static_cast<std::uint32_t>(bytes.size()));
  set_number(bytes, is_tile ? TIFFTAG_TILEBYTECOUNTS : TIFFTAG_STRIPBYTECOUNTS,
             static_cast<std::uint32_t>(counted_bytes));
  write_file(path, bytes + block);
}

TEST(TiffPage, OfDeflateThatIsDamagedIsRejected) {
  const TempFolder folder;
  std::string values;
  for (int i = 0; i < 256; ++i) values += static_cast<char>(100 + i * i * 7 % 11);
  const std::string stream = zlib_stream(values);
  for (const std::uint32_t tile : {0U, 16U}) {
    const TiffSample sample = deflated_picture(tile);
    const std::string kind = tile > 0 ? "tile" : "strip";
    const std::string block = kind + " 0 of page 0 is damaged";
    const auto write = [&](const std::string& bytes, std::size_t counted_bytes) {
      write_block(folder.file("a.tif"), sample, bytes, counted_bytes);
    };
    write(stream, stream.size());
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), values);
    write(stream + "behind the end", stream.size() + 14);
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), values);
    for (std::size_t lacking = 1; lacking < stream.size(); ++lacking) {
      write(stream, stream.size() - lacking);  // the file goes on, the block does not
      expect_rejected(folder.file("a.tif"), {block});
      write(stream.substr(0, stream.size() - lacking) + std::string(lacking, '\0'), stream.size());
      expect_rejected(folder.file("a.tif"), {block});
    }
    std::size_t rejected = 0;
    // Behind the head, which says how the stream was packed.
    for (std::size_t bit = 16; bit < stream.size() * 8; ++bit) {
      std::string flipped = stream;
      flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
      write(flipped, flipped.size());
      // What ends the stream may be flipped where its values and their checksum are right.
      std::string found = values;
      try {
        found = voxels_of(*open_source({folder.file("a.tif")}, {}));
      } catch (const Error& error) {
        EXPECT_TRUE(contains(error, block)) << bit;
        ++rejected;
      }
      EXPECT_EQ(found, values) << bit;
    }
    constexpr std::size_t kEndBits = 7 + 7;  // of the last code, and up to the next byte
    EXPECT_GE(rejected + kEndBits, stream.size() * 8 - 16);
    const std::string more = zlib_stream(values + values.substr(0, 16));
    write(more, more.size());
    expect_rejected(folder.file("a.tif"), {block, "more than its 256 bytes"});
    const std::string less = zlib_stream(values.substr(16));
    write(less, less.size());
    expect_rejected(folder.file("a.tif"), {block});
  }
}

TEST(TiffPage, OfDeflateMayHaveRowsBehindItInItsLastStrip) {
  const TempFolder folder;
  TiffSample sample = deflated_picture(0);
  sample.rows_per_strip = 20;
  const std::string rows = counted(16 * 21, 3);
  for (std::size_t found = 16; found <= 21; ++found) {
    const std::string stream = zlib_stream(rows.substr(0, found * 16));
    write_block(folder.file("a.tif"), sample, stream, stream.size());
    if (found == 21) {
      expect_rejected(folder.file("a.tif"), {"strip 0 of page 0", "more than its 320 bytes"});
    } else {
      EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), rows.substr(0, 256)) << found;
    }
  }
  std::string stream = zlib_stream(rows.substr(0, 17 * 16 + 5));
  write_block(folder.file("a.tif"), sample, stream, stream.size());
  expect_rejected(folder.file("a.tif"), {"strip 0 of page 0", "277 bytes, and each row has 16"});
  stream = zlib_stream(rows.substr(0, 18 * 16));
  stream.back() = static_cast<char>(~stream.back());
  write_block(folder.file("a.tif"), sample, stream, stream.size());
  expect_rejected(folder.file("a.tif"), {"strip 0 of page 0 is damaged", "incorrect data check"});
  // The second of two strips, of which a row counts no more.
  sample = deflated_picture(0);
  sample.rows_per_strip = 8;
  sample.pages = {rows.substr(0, 256)};
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif"));
  set_number(bytes, TIFFTAG_IMAGELENGTH, 15);
  write_file(folder.file("a.tif"), bytes);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), rows.substr(0, 240));
}

TEST(TiffPage, OfCodesThatMakeAnotherNumberOfBytesIsRejected) {
  const TempFolder folder;
  const std::string rows = uneven_bytes(16 * 21);
  for (const int compression : {COMPRESSION_LZW, COMPRESSION_PACKBITS, COMPRESSION_ZSTD}) {
    // Blocks of more and fewer rows, in place of those of the picture.
    const auto error_of_rows = [&](std::size_t count, std::uint32_t claimed_rows) {
      TiffSample sample = deflated_picture(0);
      sample.compression = static_cast<std::uint16_t>(compression);
      sample.height = static_cast<std::uint32_t>(count);
      sample.pages = {rows.substr(0, count * 16)};
      write_tiff(folder.file("a.tif"), sample);
      std::string bytes = read_file(folder.file("a.tif"));
      set_number(bytes, TIFFTAG_IMAGELENGTH, 16);
      set_number(bytes, TIFFTAG_ROWSPERSTRIP, claimed_rows);
      write_file(folder.file("a.tif"), bytes);
      try {
        EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), rows.substr(0, 256));
      } catch (const Error& error) {
        return with_hints(error);
      }
      return std::string();
    };
    const std::string damaged = "strip 0 of page 0 is damaged";
    EXPECT_EQ(error_of_rows(16, 16), "") << compression;
    EXPECT_TRUE(contains(error_of_rows(15, 16), damaged)) << compression;
    EXPECT_TRUE(contains(error_of_rows(17, 16), "more than its 256 bytes")) << compression;
    EXPECT_EQ(error_of_rows(19, 20), "") << compression;
    EXPECT_TRUE(contains(error_of_rows(21, 20), "more than its 320 bytes")) << compression;
  }
}

TEST(TiffPage, OfDeflateAndZstdIsReadWithPredictorsInBothByteOrders) {
  const TempFolder folder;
  std::vector<std::uint32_t> values;
  for (std::uint32_t i = 0; i < 19 * 21; ++i) values.push_back(0x3f800000 + i * i * 4099);
  const std::string bytes = bytes_of(values);
  for (const bool big_endian : {false, true}) {
    for (const std::uint32_t tile : {0U, 16U}) {
      for (const std::uint16_t predictor : std::array<std::uint16_t, 3>{0, 2, 3}) {
        for (const std::uint16_t bits : std::array<std::uint16_t, 3>{8, 16, 32}) {
          // Floats of big-endian files are written wrong by libtiff.
          if (predictor == 3 && (bits < 32 || big_endian)) continue;
          TiffSample sample;
          sample.width = 19;
          sample.height = 21;
          sample.bits = bits;
          sample.format = predictor == 3 ? 3 : 1;
          sample.predictor = predictor;
          sample.big_endian = big_endian;
          sample.rows_per_strip = 4;
          sample.tile = tile;
          sample.pages = {bytes.substr(0, values.size() * bits / 8)};
          for (const int compression : {COMPRESSION_ADOBE_DEFLATE, COMPRESSION_ZSTD}) {
            sample.compression = static_cast<std::uint16_t>(compression);
            write_tiff(folder.file("a.tif"), sample);
            EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), sample.pages[0])
                << big_endian << " " << tile << " " << predictor << " " << bits << " "
                << compression;
          }
        }
      }
    }
  }
}

TEST(TiffPage, WithMirroredBytesIsNoPlainRun) {
  const TempFolder folder;
  TiffSample sample;
  sample.description = R"({"shape": [3, 3, 4], "truncated": true})";
  constexpr std::uint16_t kStandIn = 65001;
  sample.tags = {{kStandIn, TIFF_SHORT, 1, bytes_of<std::uint16_t>({FILLORDER_LSB2MSB})}};
  sample.pages = {counted(12, 0)};
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif")) + counted(24, 12);
  write_file(folder.file("a.tif"), bytes);
  EXPECT_EQ(open_source({folder.file("a.tif")}, {})->description().size.z, 3);
  const std::string tag = bytes_of<std::uint16_t>({kStandIn, TIFF_SHORT});
  ASSERT_NE(bytes.find(tag), std::string::npos);
  bytes.replace(bytes.find(tag), 2, bytes_of<std::uint16_t>({TIFFTAG_FILLORDER}));
  write_file(folder.file("a.tif"), bytes);
  expect_rejected(folder.file("a.tif"), {"not one plain run of bytes"});
}

TEST(TiffPage, OfSamplesThatAlternateHasEachPredictorUndone) {
  const TempFolder folder;
  TiffSample sample;
  sample.width = 6;
  sample.height = 2;
  sample.samples = 3;
  sample.compression = COMPRESSION_PACKBITS;
  sample.tags = {{TIFFTAG_PREDICTOR, TIFF_SHORT, 1, bytes_of<std::uint16_t>({2})}};
  std::vector<std::uint8_t> values;
  for (std::uint32_t i = 0; i < 36; ++i) values.push_back(static_cast<std::uint8_t>(i * i * 5));
  sample.pages = {steps_of(values, sample.width, sample.samples)};
  write_tiff(folder.file("a.tif"), sample);
  SourceOptions options;
  options.channel = "green";
  const auto source = open_source({folder.file("a.tif")}, options);
  std::string green;
  for (std::size_t i = 1; i < values.size(); i += 3) green += static_cast<char>(values[i]);
  EXPECT_EQ(voxels_of(*source), green);
}

TEST(TiffPage, WithAPredictorThatItsValuesCannotHaveIsRejected) {
  const TempFolder folder;
  TiffSample sample;
  sample.compression = COMPRESSION_PACKBITS;
  sample.tags = {{TIFFTAG_PREDICTOR, TIFF_SHORT, 1, bytes_of<std::uint16_t>({3})}};
  sample.pages = {counted(12, 0)};
  write_tiff(folder.file("a.tif"), sample);
  expect_rejected(folder.file("a.tif"), {"predictor 3 of uint8", "PackBits"});
}

TEST(TiffPage, WithATextThatIsHugeIsRejected) {
  const TempFolder folder;
  TiffSample sample;
  sample.description = "some text";
  sample.pages = {counted(12, 0)};
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif"));
  const std::string entry = bytes_of<std::uint16_t>({TIFFTAG_IMAGEDESCRIPTION, TIFF_ASCII});
  constexpr std::uint32_t kLength = (1U << 27) + 1;
  ASSERT_NE(bytes.find(entry), std::string::npos);
  bytes.replace(bytes.find(entry) + 4, 8,
                bytes_of<std::uint32_t>({kLength, static_cast<std::uint32_t>(bytes.size())}));
  write_file(folder.file("a.tif"), bytes);
  // Its bytes are a hole of the file.
  std::ofstream end(folder.file("a.tif"), std::ios::binary | std::ios::in);
  end.seekp(static_cast<std::streamoff>(bytes.size() + kLength - 1));
  end.put('\0');
  end.close();
  expect_rejected(folder.file("a.tif"), {std::to_string(kLength) + " bytes in its tags"});
}

}  // namespace
}  // namespace octavo::testing
