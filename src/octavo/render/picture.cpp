#include "octavo/render/picture.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <string>

#include "octavo/core/error.h"

namespace octavo {

namespace {

/// libpng reports a failure by jumping back to the call; no object with a destructor lives in
/// between.
struct PngWriter {
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

void append_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  auto& out = *static_cast<Bytes*>(png_get_io_ptr(png));
  try {
    out.insert(out.end(), bytes, bytes + count);
  } catch (...) {
    png_error(png, "no memory");
  }
}

void flush_nothing(png_structp) {}

void jump_back(png_structp png, png_const_charp) { png_longjmp(png, 1); }

void stay_silent(png_structp, png_const_charp) {}

bool write_rows(PngWriter& writer, const Picture& picture) {
  if (setjmp(png_jmpbuf(writer.png)) != 0) return false;
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(picture.width),
               static_cast<png_uint_32>(picture.height), 8,
               picture.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(writer.png, 6);
  png_write_info(writer.png, writer.info);
  const auto row_bytes = static_cast<std::size_t>(picture.width * picture.channels);
  for (std::size_t y = 0; y < static_cast<std::size_t>(picture.height); ++y) {
    png_write_row(writer.png, picture.pixels.data() + y * row_bytes);
  }
  png_write_end(writer.png, writer.info);
  return true;
}

void check_picture(const Picture& picture) {
  const bool is_sized = picture.width > 0 && picture.height > 0 &&
                        picture.width <= kLongestPictureSide &&
                        picture.height <= kLongestPictureSide;
  const bool has_channels = picture.channels == 1 || picture.channels == 3;
  if (is_sized && has_channels &&
      picture.pixels.size() ==
          static_cast<std::size_t>(picture.width * picture.height * picture.channels)) {
    return;
  }
  throw Error(ErrorKind::invalid_argument,
              "a picture of " + std::to_string(picture.width) + " x " +
                  std::to_string(picture.height) + " pixels, " + std::to_string(picture.channels) +
                  " channels and " + std::to_string(picture.pixels.size()) + " bytes is no PNG");
}

}  // namespace

void Picture::set(std::int64_t x, std::int64_t y, const Color& color) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  std::uint8_t* const pixel = pixels.data() + (y * width + x) * channels;
  std::copy_n(color.begin(), channels, pixel);
}

void Picture::blend(std::int64_t x, std::int64_t y, const Color& color, double share) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  std::uint8_t* const pixel = pixels.data() + (y * width + x) * channels;
  for (int c = 0; c < channels; ++c) {
    const double mixed = pixel[c] + (color[static_cast<std::size_t>(c)] - pixel[c]) * share;
    pixel[c] = static_cast<std::uint8_t>(std::lround(std::clamp(mixed, 0.0, 255.0)));
  }
}

Picture make_picture(std::int64_t width, std::int64_t height, int channels) {
  return {width, height, channels,
          std::vector<std::uint8_t>(static_cast<std::size_t>(width * height * channels))};
}

Picture in_colors(Picture picture) {
  if (picture.channels == 3) return picture;
  Picture result = make_picture(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    std::fill_n(result.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, picture.pixels[i]);
  }
  return result;
}

Bytes encode_png(const Picture& picture) {
  check_picture(picture);
  Bytes out;
  PngWriter writer;
  writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, jump_back, stay_silent);
  if (writer.png != nullptr) writer.info = png_create_info_struct(writer.png);
  if (writer.info == nullptr) throw Error(ErrorKind::out_of_memory, "no memory for a PNG");
  png_set_write_fn(writer.png, &out, append_bytes, flush_nothing);
  if (!write_rows(writer, picture)) throw Error(ErrorKind::internal, "libpng rejected a picture");
  return out;
}

}  // namespace octavo
