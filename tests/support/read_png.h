// PNG files back into pixels, and single pixels of pictures.
#pragma once

#include <png.h>

#include "octavo/render/picture.h"

namespace octavo::testing {

/// The pixels of a PNG file; an empty picture when it is none.
inline Picture read_png(const Bytes& bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0) return {};
  const bool is_color = (image.format & PNG_FORMAT_FLAG_COLOR) != 0;
  image.format = is_color ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
  Picture picture = make_picture(image.width, image.height, is_color ? 3 : 1);
  png_image_finish_read(&image, nullptr, picture.pixels.data(), 0, nullptr);
  return picture;
}

/// One pixel of a picture in color.
inline Color pixel(const Picture& picture, std::int64_t x, std::int64_t y) {
  const auto at = static_cast<std::size_t>(3 * (y * picture.width + x));
  return {picture.pixels[at], picture.pixels[at + 1], picture.pixels[at + 2]};
}

}  // namespace octavo::testing
