#include "support/image_samples.h"

#include <gtest/gtest.h>
#include <png.h>
#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "support/source_files.h"

namespace octavo::testing {

/// value  bytes of one pixel in this plane of samples
static void write_tiles(TIFF* tiff, const TiffSample& s, const std::string& voxels,
                        std::size_t value, std::uint16_t plane) {
  for (std::uint32_t y = 0; y < s.height; y += s.tile) {
    for (std::uint32_t x = 0; x < s.width; x += s.tile) {
      std::string tile(std::size_t{s.tile} * s.tile * value, '\0');
      for (std::uint32_t row = 0; row < std::min(s.tile, s.height - y); ++row) {
        std::memcpy(tile.data() + row * s.tile * value,
                    voxels.data() + (std::size_t{y + row} * s.width + x) * value,
                    std::min(s.tile, s.width - x) * value);
      }
      ASSERT_GE(TIFFWriteTile(tiff, tile.data(), x, y, 0, plane), 0);
    }
  }
}

constexpr std::uint16_t kStandInTag = 65000;

/// Makes the tag that stands in for a second description one, which libtiff does not write.
static void rename_stand_in(const std::string& path, bool big_endian) {
  const auto start_of_entry = [&](std::uint16_t tag) {
    const char low = static_cast<char>(tag & 0xff);
    const char high = static_cast<char>(tag >> 8);
    return big_endian ? std::string{high, low, 0, TIFF_ASCII}
                      : std::string{low, high, TIFF_ASCII, 0};
  };
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::string stand_in = start_of_entry(kStandInTag);
  for (std::size_t at = bytes.find(stand_in); at != std::string::npos; at = bytes.find(stand_in)) {
    bytes.replace(at, stand_in.size(), start_of_entry(TIFFTAG_IMAGEDESCRIPTION));
  }
  std::ofstream(path, std::ios::binary) << bytes;
}

void write_tiff(const std::string& path, const TiffSample& s) {
  const std::string mode = std::string("w") + (s.big ? "8" : "") + (s.big_endian ? "b" : "");
  TIFF* tiff = TIFFOpen(path.c_str(), mode.c_str());
  ASSERT_NE(tiff, nullptr);
  const std::size_t planes = s.separate ? s.samples : 1;
  const std::size_t value = s.bits / 8U * (s.samples / planes);
  const std::size_t row_bytes = std::size_t{s.width} * value;
  for (std::size_t number = 0; number < s.pages.size(); ++number) {
    const std::string& page = s.pages[number];
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, s.width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, s.height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, s.bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, s.format);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, s.samples);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG,
                 s.separate ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                 s.samples < 3 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, s.compression);
    if (s.predictor > 0) TIFFSetField(tiff, TIFFTAG_PREDICTOR, s.predictor);
    const std::string& text = s.descriptions.empty() ? s.description : s.descriptions[number];
    if (!text.empty()) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, text.c_str());
    if (s.resolution > 0) {
      TIFFSetField(tiff, TIFFTAG_XRESOLUTION, static_cast<double>(s.resolution));
      TIFFSetField(tiff, TIFFTAG_YRESOLUTION,
                   static_cast<double>(s.y_resolution > 0 ? s.y_resolution : s.resolution));
      TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, s.resolution_unit);
    }
    if (s.depth > 1) TIFFSetField(tiff, TIFFTAG_IMAGEDEPTH, s.depth);
    std::vector<TiffTag> tags = s.tags;
    if (!s.further_description.empty()) {
      tags.push_back({kStandInTag, TIFF_ASCII,
                      static_cast<std::uint32_t>(s.further_description.size() + 1),
                      s.further_description});
    }
    for (const TiffTag& tag : tags) {
      std::string name = "tag";
      const TIFFFieldInfo info = {tag.tag, TIFF_VARIABLE2, TIFF_VARIABLE2,
                                  static_cast<TIFFDataType>(tag.type), FIELD_CUSTOM, 1, 1,
                                  name.data()};
      TIFFMergeFieldInfo(tiff, &info, 1);
      TIFFSetField(tiff, tag.tag, tag.count, tag.values.data());
    }
    if (!s.orientations.empty()) TIFFSetField(tiff, TIFFTAG_ORIENTATION, s.orientations[number]);
    if (!s.palettes.empty() && s.palettes[number]) {
      std::vector<std::uint16_t> colors(256);
      TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_PALETTE);
      TIFFSetField(tiff, TIFFTAG_COLORMAP, colors.data(), colors.data(), colors.data());
    }
    if (s.tile > 0) {
      TIFFSetField(tiff, TIFFTAG_TILEWIDTH, s.tile);
      TIFFSetField(tiff, TIFFTAG_TILELENGTH, s.tile);
      for (std::size_t plane = 0; plane < planes; ++plane) {
        write_tiles(tiff, s, page.substr(plane * row_bytes * s.height), value,
                    static_cast<std::uint16_t>(plane));
      }
    } else {
      TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, s.rows_per_strip > 0 ? s.rows_per_strip : s.height);
      for (std::size_t row = 0; row < planes * s.height; ++row) {
        std::string bytes = page.substr(row * row_bytes, row_bytes);
        ASSERT_EQ(TIFFWriteScanline(tiff, bytes.data(), static_cast<std::uint32_t>(row % s.height),
                                    static_cast<std::uint16_t>(row / s.height)), 1);
      }
    }
    ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
  }
  TIFFClose(tiff);
  if (!s.further_description.empty()) rename_stand_in(path, s.big_endian);
}

std::size_t entry_of(const std::string& bytes, std::uint16_t tag) {
  for (const bool is_list : {false, true}) {
    for (const std::uint16_t type : {std::uint16_t{TIFF_SHORT}, std::uint16_t{TIFF_LONG}}) {
      std::vector<std::uint16_t> start = {tag, type, 1, 0};
      if (is_list) start.resize(2);
      const std::size_t at = bytes.rfind(bytes_of(start));
      if (at != std::string::npos) return at;
    }
  }
  ADD_FAILURE() << "no tag " << tag;
  return 0;
}

std::uint32_t number_of(const std::string& bytes, std::uint16_t tag) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + entry_of(bytes, tag) + 8, sizeof number);
  return number;
}

void set_number(std::string& bytes, std::uint16_t tag, std::uint32_t number) {
  bytes.replace(entry_of(bytes, tag), 12,
                bytes_of<std::uint16_t>({tag, TIFF_LONG}) + bytes_of<std::uint32_t>({1, number}));
}

void set_numbers(std::string& bytes, std::uint16_t tag, const std::vector<std::uint32_t>& numbers) {
  const auto end = static_cast<std::uint32_t>(bytes.size());
  const auto count = static_cast<std::uint32_t>(numbers.size());
  bytes.replace(entry_of(bytes, tag), 12,
                bytes_of<std::uint16_t>({tag, TIFF_LONG}) + bytes_of<std::uint32_t>({count, end}));
  bytes += bytes_of(numbers);
}

void write_png(const std::string& path, std::uint32_t width, std::uint32_t height, int bits,
               int color_type, const std::string& rows) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop header = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, header, width, height, bits, color_type, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, header);
  const std::size_t row_bytes = rows.size() / height;
  for (std::uint32_t y = 0; y < height; ++y) {
    png_write_row(png, reinterpret_cast<png_const_bytep>(rows.data()) + y * row_bytes);
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &header);
  std::fclose(file);
}

}  // namespace octavo::testing
