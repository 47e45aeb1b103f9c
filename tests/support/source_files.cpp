#include "support/source_files.h"

#include <gtest/gtest.h>
#include <png.h>
#include <tiffio.h>
#include <unistd.h>
#include <zlib.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace octavo::testing {

namespace fs = std::filesystem;

TempFolder::TempFolder() {
  static std::atomic<int> count = 0;
  path_ = (fs::temp_directory_path() /
           ("octavo-io-" + std::to_string(::getpid()) + "-" + std::to_string(count++)))
              .string();
  fs::create_directories(path_);
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string TempFolder::file(const std::string& name) const {
  const fs::path path = fs::path(path_) / name;
  fs::create_directories(path.parent_path());
  return path.string();
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void write_file(const std::string& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ASSERT_TRUE(file.flush()) << path;
}

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string gzip(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  std::string in = bytes;
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string voxels_of(PlaneSource& source) {
  const VolumeDescription& d = source.description();
  const auto plane_bytes = static_cast<std::size_t>(d.size.x * d.size.y * bytes_per_voxel(d.type));
  std::string all(plane_bytes * static_cast<std::size_t>(d.size.z), '\0');
  for (std::size_t z = 0; z < static_cast<std::size_t>(d.size.z); ++z) {
    source.read_plane(std::as_writable_bytes(std::span(all.data() + z * plane_bytes, plane_bytes)));
  }
  return all;
}

Error error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error was thrown";
  return Error(ErrorKind::internal, "no error was thrown");
}

Error source_error(const std::vector<std::string>& paths, const SourceOptions& options) {
  return error_of([&] { voxels_of(*open_source(paths, options)); });
}

namespace {

std::string u16(std::uint16_t value) { return bytes_of<std::uint16_t>({value}); }
std::string u32(std::uint32_t value) { return bytes_of<std::uint32_t>({value}); }

std::string item(const std::string& content) {
  return u16(0xfffe) + u16(0xe000) + u32(static_cast<std::uint32_t>(content.size())) + content;
}

std::string element(std::uint16_t group, std::uint16_t number, const std::string& vr,
                    std::string value) {
  if (value.size() % 2 == 1) value += vr == "UI" ? '\0' : ' ';
  const std::string head = u16(group) + u16(number) + vr;
  if (vr == "OW" || vr == "OB" || vr == "SQ") {
    return head + std::string(2, '\0') + u32(static_cast<std::uint32_t>(value.size())) + value;
  }
  return head + u16(static_cast<std::uint16_t>(value.size())) + value;
}

/// A sequence of one item.
std::string sequence(std::uint16_t group, std::uint16_t number, const std::string& content) {
  return element(group, number, "SQ", item(content));
}

void write_part_10(const std::string& path, const std::string& data_set) {
  const std::string meta = element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
  write_file(path, std::string(128, '\0') + "DICM" +
                       element(2, 0, "UL", u32(static_cast<std::uint32_t>(meta.size()))) + meta +
                       data_set);
}

}  // namespace

void write_dicom(const std::string& path, const DicomSample& s) {
  std::string set = element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2") +
                    element(8, 0x60, "CS", s.modality) + element(0x10, 0x10, "PN", s.patient_name) +
                    element(0x20, 0x0e, "UI", s.series);
  if (s.position) set += element(0x20, 0x32, "DS", *s.position);
  if (s.position) set += element(0x20, 0x37, "DS", s.orientation);
  set += element(0x28, 0x02, "US", u16(s.samples)) + element(0x28, 0x04, "CS", s.photometric);
  if (s.samples > 1) set += element(0x28, 0x06, "US", u16(s.planar));
  set += element(0x28, 0x10, "US", u16(s.rows)) + element(0x28, 0x11, "US", u16(s.columns));
  if (!s.pixel_spacing.empty()) set += element(0x28, 0x30, "DS", s.pixel_spacing);
  if (s.frames > 1) set += element(0x28, 0x08, "IS", std::to_string(s.frames));
  if (s.padding) set += element(0x28, 0x120, "SS", bytes_of<std::int16_t>({*s.padding}));
  set += element(0x28, 0x100, "US", u16(s.bits_allocated)) +
         element(0x28, 0x101, "US", u16(s.bits_stored)) +
         element(0x28, 0x102, "US", u16(s.high_bit)) +
         element(0x28, 0x103, "US", u16(s.is_signed)) + element(0x28, 0x1052, "DS", s.intercept) +
         element(0x28, 0x1053, "DS", s.slope);
  const std::size_t bytes = std::size_t{s.rows} * s.columns * s.samples * s.bits_allocated / 8U;
  set += element(0x7fe0, 0x10, "OW", s.voxels.empty() ? std::string(bytes, '\0') : s.voxels);
  write_part_10(path, set);
}

void write_segmentation(const std::string& path, const SegmentationSample& s) {
  std::string segments;
  std::string frames;
  for (const int number : {1, 2}) {
    segments += item(element(0x62, 0x04, "US", u16(static_cast<std::uint16_t>(number))) +
                     element(0x62, 0x05, "LO", "part " + std::to_string(number)));
  }
  for (std::size_t i = 0; i < s.positions.size(); ++i) {
    const std::uint16_t segment = s.segments.empty() ? 1 : s.segments[i];
    frames += item(sequence(0x20, 0x9113, element(0x20, 0x32, "DS", s.positions[i])) +
                   sequence(0x62, 0x0a, element(0x62, 0x0b, "US", u16(segment))));
  }
  std::string packed((s.voxels.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < s.voxels.size(); ++i) {
    if (s.voxels[i]) packed[i / 8] = static_cast<char>(packed[i / 8] | 1 << i % 8);
  }
  const std::uint16_t bits = s.fractions.empty() ? 1 : 8;
  std::string more = s.fractions.empty() ? "" : element(0x62, 0x0e, "US", u16(200));
  if (!s.overlap.empty()) more += element(0x62, 0x13, "CS", s.overlap);
  write_part_10(
      path,
      element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.66.4") + element(8, 0x60, "CS", "SEG") +
          element(0x20, 0x0e, "UI", "1.2.3") + element(0x28, 0x02, "US", u16(1)) +
          element(0x28, 0x04, "CS", "MONOCHROME2") +
          element(0x28, 0x08, "IS", std::to_string(s.positions.size())) +
          element(0x28, 0x10, "US", u16(3)) + element(0x28, 0x11, "US", u16(5)) +
          element(0x28, 0x100, "US", u16(bits)) + element(0x28, 0x101, "US", u16(bits)) +
          element(0x28, 0x102, "US", u16(static_cast<std::uint16_t>(bits - 1))) +
          element(0x28, 0x103, "US", u16(0)) +
          element(0x62, 0x01, "CS", s.type) + element(0x62, 0x02, "SQ", segments) + more +
          sequence(0x5200, 0x9229,
                   sequence(0x20, 0x9116, element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")) +
                       sequence(0x28, 0x9110, element(0x28, 0x30, "DS", "0.5\\0.5"))) +
          element(0x5200, 0x9230, "SQ", frames) +
          element(0x7fe0, 0x10, "OB", s.fractions.empty() ? packed : s.fractions));
}

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

void write_tiff(const std::string& path, const TiffSample& s) {
  TIFF* tiff = TIFFOpen(path.c_str(), s.big ? "w8" : "w");
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
    if (!s.description.empty()) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, s.description.c_str());
    if (s.resolution > 0) {
      TIFFSetField(tiff, TIFFTAG_XRESOLUTION, static_cast<double>(s.resolution));
      TIFFSetField(tiff, TIFFTAG_YRESOLUTION,
                   static_cast<double>(s.y_resolution > 0 ? s.y_resolution : s.resolution));
      TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, s.resolution_unit);
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

std::string nifti_header(const NiftiSample& s) {
  std::string h(352, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) {
    h.replace(at, bytes.size(), bytes);
  };
  const auto put16 = [&](std::size_t at, std::int16_t v) {
    put(at, bytes_of<std::int16_t>({v}, s.big_endian));
  };
  const auto put_float = [&](std::size_t at, float v) {
    put(at, bytes_of<float>({v}, s.big_endian));
  };
  put(0, bytes_of<std::int32_t>({348}, s.big_endian));
  put16(40, static_cast<std::int16_t>(s.size.size()));
  for (std::size_t axis = 0; axis < s.size.size(); ++axis) {
    put16(42 + axis * 2, s.size[axis]);
    put_float(80 + axis * 4, 1);
  }
  put16(68, s.intent);
  put16(70, s.datatype);
  put16(72, s.bits);
  put_float(108, 352);
  put_float(112, s.slope);
  put_float(116, s.intercept);
  h[123] = 2;
  put16(254, s.sform);
  for (std::size_t i = 0; i < 12; ++i) put_float(280 + i * 4, s.srow[i]);
  put(344, std::string("n+1\0", 4));
  return h;
}

}  // namespace octavo::testing
