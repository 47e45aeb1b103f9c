#include "octavo/io/images/tiff_page.h"

#include <gtest/gtest.h>

#include <tiffio.h>

#include <cstring>
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
  expect_rejected(folder.file("a.tif"), {"strip 0 is damaged (Discarding "});
  // The last strip may go on behind the page.
  sample.rows_per_strip = 2;
  damaged('\xf9', '\3' + sample.pages[0].substr(8));  // its first value 8 times
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})),
            sample.pages[0].substr(0, 8) + std::string(4, sample.pages[0][8]));
}

TEST(TiffPage, OfJpegWithoutAllItsValuesIsRejected) {
  const TempFolder folder;
  TiffSample sample;
  sample.width = 64;
  sample.height = 64;
  sample.compression = COMPRESSION_JPEG;
  sample.rows_per_strip = 64;
  sample.pages = {counted(64 * 64, 1)};
  write_tiff(folder.file("a.tif"), sample);
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
  expect_rejected(folder.file("a.tif"), {"strip 0 is damaged (Corrupt JPEG data"});
}

TEST(TiffPage, OfJpegCutByItsByteCountIsRejected) {
  const TempFolder folder;
  TiffSample sample;
  sample.width = 64;
  sample.height = 64;
  sample.compression = COMPRESSION_JPEG;
  sample.rows_per_strip = 64;
  sample.pages = {counted(64 * 64, 1)};
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif"));
  // An entry of one number, in the lower bytes of its last four.
  std::size_t entry = bytes.find(bytes_of<std::uint16_t>({TIFFTAG_STRIPBYTECOUNTS, TIFF_SHORT}));
  if (entry == std::string::npos) {
    entry = bytes.find(bytes_of<std::uint16_t>({TIFFTAG_STRIPBYTECOUNTS, TIFF_LONG}));
  }
  ASSERT_NE(entry, std::string::npos);
  std::uint16_t count = 0;
  std::memcpy(&count, bytes.data() + entry + 8, sizeof count);
  bytes.replace(entry + 8, 2, bytes_of<std::uint16_t>({static_cast<std::uint16_t>(count - 2)}));
  write_file(folder.file("a.tif"), bytes);  // without its last mark
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})).size(), 64U * 64);
  bytes.replace(entry + 8, 2, bytes_of<std::uint16_t>({static_cast<std::uint16_t>(count / 2)}));
  write_file(folder.file("a.tif"), bytes);
  expect_rejected(folder.file("a.tif"), {"strip 0 is damaged (its picture ends before"});
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
