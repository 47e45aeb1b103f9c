// Pixels in memory, and PNG out of them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/bytes.h"

namespace octavo {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue

inline constexpr Color kBlack = {0, 0, 0};

/// The longest side of a PNG file, which readers of such files share.
inline constexpr std::int64_t kLongestPictureSide = 1'000'000;

/// 8-bit pixels, rows from the top, channels interleaved.
struct Picture {
  std::int64_t width = 0;
  std::int64_t height = 0;
  int channels = 1;  ///< 1: grey, 3: red green blue
  std::vector<std::uint8_t> pixels;

  /// Sets one pixel; outside the picture nothing happens. A grey picture takes the red of `color`.
  void set(std::int64_t x, std::int64_t y, const Color& color);
  /// Mixes one pixel with `color`, whose share is 0 .. 1, in the same way.
  void blend(std::int64_t x, std::int64_t y, const Color& color, double share);
};

/// A black picture.
Picture make_picture(std::int64_t width, std::int64_t height, int channels);

/// The same picture in three channels.
Picture in_colors(Picture picture);

/// The PNG file of a picture; the same pixels give the same bytes.
/// Throws Error{invalid_argument} when size, channels and pixels do not fit together.
Bytes encode_png(const Picture& picture);

}  // namespace octavo
