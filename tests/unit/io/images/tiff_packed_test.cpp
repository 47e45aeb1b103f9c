#include "octavo/io/images/tiff_packed.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <initializer_list>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// Values bit by bit, the highest first; rows begin with a byte.
std::string packed(int bits, std::size_t row_values, const std::vector<std::uint16_t>& values) {
  std::string bytes;
  for (std::size_t at = 0; at < values.size(); at += row_values) {
    std::string row(packed_row_bytes(bits, row_values), '\0');
    for (std::size_t bit = 0; bit < row_values * static_cast<std::size_t>(bits); ++bit) {
      const std::size_t width = static_cast<std::size_t>(bits);
      const int value = values[at + bit / width] >> (width - 1 - bit % width) & 1;
      row[bit / 8] = static_cast<char>(row[bit / 8] | value << (7 - bit % 8));
    }
    bytes += row;
  }
  return bytes;
}

std::vector<std::uint16_t> values_of(int bits, std::size_t count) {
  std::vector<std::uint16_t> values;
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(static_cast<std::uint16_t>(i * 40503U & ((1U << bits) - 1)));
  }
  values[1] = static_cast<std::uint16_t>((1U << bits) - 1);
  return values;
}

/// As voxels of native order.
std::string voxels_of_values(int bits, const std::vector<std::uint16_t>& values) {
  if (!is_packed_byte(bits)) return bytes_of(values);
  return {values.begin(), values.end()};
}

TEST(TiffPacked, RowsHaveEachValueAtItsBits) {
  for (const int bits : {1, 2, 4, 10, 12, 14}) {
    for (std::size_t count = 2; count < 20; ++count) {
      const std::vector<std::uint16_t> values = values_of(bits, count);
      const std::string row = packed(bits, count, values);
      for (std::size_t step = 1; step < 4; ++step) {
        for (std::size_t first = 0; first < step; ++first) {
          std::vector<std::uint16_t> expected;
          for (std::size_t i = first; i < count; i += step) expected.push_back(values[i]);
          std::string found(voxels_of_values(bits, expected).size(), '\xff');
          unpack_row({bits, step, first}, std::as_bytes(std::span(row)),
                     std::as_writable_bytes(std::span(found)));
          EXPECT_EQ(found, voxels_of_values(bits, expected))
              << bits << ' ' << count << ' ' << step << ' ' << first;
        }
      }
    }
  }
}

/// A page of 21 x 7 pixels, or 16 x 16 in one tile.
struct PackedPage {
  int bits = 12;
  std::uint16_t samples = 1;
  std::uint16_t compression = COMPRESSION_NONE;
  std::uint16_t fill_order = FILLORDER_MSB2LSB;
  bool is_tile = false;
  const char* mode = "w";
  std::uint16_t predictor = 0;
  std::uint16_t format = SAMPLEFORMAT_UINT;

  std::uint32_t width() const { return is_tile ? 16 : 21; }
  std::uint32_t height() const { return is_tile ? 16 : 7; }
  std::vector<std::uint16_t> values() const {
    return values_of(bits, std::size_t{width()} * height() * samples);
  }
};

void write_page(const std::string& path, const PackedPage& page) {
  TIFF* tiff = TIFFOpen(path.c_str(), page.mode);
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, page.width());
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, page.height());
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, page.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, page.format);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, page.samples);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
               page.samples < 3 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, page.compression);
  TIFFSetField(tiff, TIFFTAG_FILLORDER, page.fill_order);
  if (page.predictor > 0) TIFFSetField(tiff, TIFFTAG_PREDICTOR, page.predictor);
  std::string bytes =
      packed(page.bits, std::size_t{page.width()} * page.samples, page.values());
  const auto length = static_cast<tmsize_t>(bytes.size());
  if (page.is_tile) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
    ASSERT_EQ(TIFFWriteEncodedTile(tiff, 0, bytes.data(), length), length);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 3);
    const auto row = static_cast<tmsize_t>(bytes.size() / page.height());
    for (std::uint32_t strip = 0; strip < 3; ++strip) {
      const tmsize_t rows = strip < 2 ? 3 : 1;
      ASSERT_EQ(TIFFWriteEncodedStrip(tiff, strip, bytes.data() + strip * 3 * row, rows * row),
                rows * row);
    }
  }
  TIFFClose(tiff);
}

TEST(TiffPacked, PagesBecomeUint8OrUint16) {
  const TempFolder folder;
  const std::string path = folder.file("a.tif");
  for (const int bits : {1, 2, 4, 10, 12, 14}) {
    for (const std::uint16_t compression :
         std::initializer_list<std::uint16_t>{COMPRESSION_NONE, COMPRESSION_LZW,
                                              COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
      for (const std::uint16_t fill_order :
           std::initializer_list<std::uint16_t>{FILLORDER_MSB2LSB, FILLORDER_LSB2MSB}) {
        for (const bool is_tile : {false, true}) {
          for (const char* mode : {"wl", "wb"}) {
            const PackedPage page{bits, 1, compression, fill_order, is_tile, mode};
            write_page(path, page);
            const auto source = open_source({path}, with_spacing(1, 1, 1));
            EXPECT_EQ(source->description().type,
                      bits < 8 ? VoxelType::uint8 : VoxelType::uint16);
            EXPECT_EQ(voxels_of(*source), voxels_of_values(bits, page.values()))
                << bits << ' ' << compression << ' ' << fill_order << ' ' << is_tile << mode;
          }
        }
      }
    }
  }
}

TEST(TiffPacked, FewLevelsAreToldAndNotMixedWithMore) {
  const TempFolder folder;
  const PackedPage page{1};
  write_page(folder.file("a1.tif"), page);
  const auto source = open_source({folder.file("a1.tif")}, with_spacing(1, 1, 1));
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(source->warnings()[0],
                       "pages of 1 bit: voxels are the stored numbers, 0 to 1"));
  write_page(folder.file("a2.tif"), {4});
  expect_rejected(folder.path(), {"a2.tif holds uint8 of 4 bits", "a1.tif holds uint8 of 1 bit"});
}

TEST(TiffPacked, ChannelsTakeTurns) {
  const TempFolder folder;
  const std::string path = folder.file("a.tif");
  for (const bool is_tile : {false, true}) {
    const PackedPage page{12, 3, COMPRESSION_LZW, FILLORDER_MSB2LSB, is_tile};
    write_page(path, page);
    const std::vector<std::uint16_t> values = page.values();
    for (std::size_t channel = 0; channel < 3; ++channel) {
      std::vector<std::uint16_t> expected;
      for (std::size_t i = channel; i < values.size(); i += 3) expected.push_back(values[i]);
      SourceOptions options = with_spacing(1, 1, 1);
      options.channel = std::to_string(channel);
      EXPECT_EQ(voxels_of(*open_source({path}, options)), bytes_of(expected)) << channel;
    }
  }
}

TEST(TiffPacked, OtherWidthsAndSignsAreRejected) {
  const TempFolder folder;
  const std::string path = folder.file("a.tif");
  PackedPage page;
  page.bits = 11;
  write_page(path, page);
  expect_rejected(path, {"11 bits per sample", "1, 2, 4, 10, 12 or 14 bits without a sign"});
  page.bits = 12;
  page.format = SAMPLEFORMAT_INT;
  write_page(path, page);
  expect_rejected(path, {"12 bits per sample of format 2"});
}

TEST(TiffPacked, OtherCompressionsAreRejectedByName) {
  const TempFolder folder;
  const std::string path = folder.file("a.tif");
  write_page(path, {1, 1, COMPRESSION_ZSTD});
  expect_rejected(path, {"values of 1 bit with compression of ZSTD are not read"});
}

TEST(TiffPacked, CutPagesAreRejected) {
  const TempFolder folder;
  const std::string path = folder.file("a.tif");
  for (const std::uint16_t compression :
       std::initializer_list<std::uint16_t>{COMPRESSION_NONE, COMPRESSION_ADOBE_DEFLATE}) {
    write_page(path, {14, 1, compression});
    const std::string whole = read_file(path);
    expect_every_truncation_rejected(path, whole);
  }
}

}  // namespace
}  // namespace octavo::testing
