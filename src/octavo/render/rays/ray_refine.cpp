#include "octavo/render/rays/ray_refine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "octavo/render/enlarged.h"

namespace octavo {

namespace {

constexpr int kVaryingColor = 20;  // of 255: pixels of a quarter picture that differ by more
constexpr int kEdgeColor = 24;     // neighbors that differ by more
constexpr std::int64_t kRayBlockSide = 4;
constexpr std::int64_t kTileBlocks = kRayTileSide / kRayBlockSide;

/// Blocks of a picture as bits of its tiles: of 4 x 4 pixels, in Z order as rays are.
class BlockBits {
 public:
  BlockBits(std::int64_t width, std::int64_t height)
      : columns_(tiles_along(width)),
        bits_(static_cast<std::size_t>(columns_ * tiles_along(height))) {}

  void set(std::int64_t column, std::int64_t row) { bits_[tile(column, row)] |= bit(column, row); }
  bool has(std::int64_t column, std::int64_t row) const {
    return (bits_[tile(column, row)] & bit(column, row)) != 0;
  }
  bool is_empty() const {
    return std::all_of(bits_.begin(), bits_.end(), [](std::uint64_t one) { return one == 0; });
  }
  std::vector<std::uint64_t>& all() { return bits_; }

 private:
  std::size_t tile(std::int64_t column, std::int64_t row) const {
    return static_cast<std::size_t>(row / kTileBlocks * columns_ + column / kTileBlocks);
  }
  static std::uint64_t bit(std::int64_t column, std::int64_t row) {
    int place = 0;
    for (int i = 0; i < 3; ++i) {
      place |= static_cast<int>(column >> i & 1) << (2 * i);
      place |= static_cast<int>(row >> i & 1) << (2 * i + 1);
    }
    return std::uint64_t{1} << place;
  }

  std::int64_t columns_;
  std::vector<std::uint64_t> bits_;
};

const std::uint8_t* pixel_at(const Picture& picture, std::int64_t x, std::int64_t y) {
  return picture.pixels.data() + 3 * (y * picture.width + x);
}

bool differ(const std::uint8_t* a, const std::uint8_t* b, int by) {
  return std::abs(a[0] - b[0]) > by || std::abs(a[1] - b[1]) > by || std::abs(a[2] - b[2]) > by;
}

/// The pixels of a picture of half as many that those from `first` to `last` are interpolated from.
std::array<std::int64_t, 2> quarter_span(std::int64_t first, std::int64_t last,
                                         std::int64_t pixels, std::int64_t quarter_pixels) {
  const auto place = [&](std::int64_t at) {
    const double by_middle = (static_cast<double>(at) + 0.5 - static_cast<double>(pixels) / 2) / 2;
    return static_cast<std::int64_t>(
        std::floor(by_middle + static_cast<double>(quarter_pixels) / 2 - 0.5));
  };
  return {std::clamp<std::int64_t>(place(first), 0, quarter_pixels - 1),
          std::clamp<std::int64_t>(place(last) + 1, 0, quarter_pixels - 1)};
}

bool is_varying(const Picture& picture, const std::array<std::int64_t, 2>& columns,
                const std::array<std::int64_t, 2>& rows) {
  std::array<int, 3> low{255, 255, 255};
  std::array<int, 3> high{0, 0, 0};
  for (std::int64_t y = rows[0]; y <= rows[1]; ++y) {
    for (std::int64_t x = columns[0]; x <= columns[1]; ++x) {
      const std::uint8_t* const pixel = pixel_at(picture, x, y);
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min<int>(low[i], pixel[i]);
        high[i] = std::max<int>(high[i], pixel[i]);
      }
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (high[i] - low[i] > kVaryingColor) return true;
  }
  return false;
}

BlockBits varying(const Picture& quarter, std::int64_t width, std::int64_t height) {
  BlockBits blocks(width, height);
  for (std::int64_t y = 0; y < height; y += kRayBlockSide) {
    const auto rows =
        quarter_span(y, std::min(y + kRayBlockSide, height) - 1, height, quarter.height);
    for (std::int64_t x = 0; x < width; x += kRayBlockSide) {
      const auto columns =
          quarter_span(x, std::min(x + kRayBlockSide, width) - 1, width, quarter.width);
      if (is_varying(quarter, columns, rows)) blocks.set(x / kRayBlockSide, y / kRayBlockSide);
    }
  }
  return blocks;
}

/// Whether a pixel differs much from one beside, above or below it.
bool is_at_edge(const Picture& picture, std::int64_t x, std::int64_t y) {
  const std::uint8_t* const here = pixel_at(picture, x, y);
  const auto differs = [&](std::int64_t column, std::int64_t row) {
    const bool is_inside =
        column >= 0 && row >= 0 && column < picture.width && row < picture.height;
    return is_inside && differ(here, pixel_at(picture, column, row), kEdgeColor);
  };
  return differs(x - 1, y) || differs(x + 1, y) || differs(x, y - 1) || differs(x, y + 1);
}

/// One ray for 2 x 2 pixels, and all of them where these differ.
Picture adaptive_picture(const RayFrame& frame, std::int64_t width, std::int64_t height,
                         const CastFrame& cast, const LookOfField& look_of, RayLook& look) {
  Picture quarter;
  {
    const RayField field = cast(frame_of_pixels(frame, 0.5f), (width + 1) / 2, (height + 1) / 2);
    look = look_of(field);
    quarter = ray_picture(field, look);
  }
  Picture picture = enlarged(quarter, width, height, 2);
  BlockBits blocks = varying(quarter, width, height);
  if (blocks.is_empty()) return picture;
  RayFrame fine = frame;
  fine.chosen = blocks.all().data();
  visit_ray_colors(cast(fine, width, height), look,
                   [&](std::int64_t x, std::int64_t y, const Color& color) {
                     if (blocks.has(x / kRayBlockSide, y / kRayBlockSide)) picture.set(x, y, color);
                   });
  return picture;
}

/// Pixels at edges as means of 2 x 2 rays.
void smooth_edges(const RayFrame& frame, const CastFrame& cast, const RayLook& look,
                  Picture& picture) {
  BlockBits blocks(2 * picture.width, 2 * picture.height);
  std::vector<std::uint8_t> is_edge(static_cast<std::size_t>(picture.width * picture.height));
  for (std::int64_t y = 0; y < picture.height; ++y) {
    for (std::int64_t x = 0; x < picture.width; ++x) {
      if (!is_at_edge(picture, x, y)) continue;
      is_edge[static_cast<std::size_t>(y * picture.width + x)] = 1;
      blocks.set(2 * x / kRayBlockSide, 2 * y / kRayBlockSide);
    }
  }
  if (blocks.is_empty()) return;
  RayFrame fine = frame_of_pixels(frame, 2);
  fine.chosen = blocks.all().data();
  // The four rays of a pixel follow each other.
  std::array<int, 3> sums{};
  int count = 0;
  visit_ray_colors(cast(fine, 2 * picture.width, 2 * picture.height), look,
                   [&](std::int64_t x, std::int64_t y, const Color& color) {
                     for (std::size_t i = 0; i < 3; ++i) sums[i] += color[i];
                     if (++count < 4) return;
                     Color mean;
                     for (std::size_t i = 0; i < 3; ++i) {
                       mean[i] = static_cast<std::uint8_t>((sums[i] + 2) / 4);
                     }
                     const std::int64_t place = y / 2 * picture.width + x / 2;
                     if (is_edge[static_cast<std::size_t>(place)] != 0) {
                       picture.set(x / 2, y / 2, mean);
                     }
                     sums = {};
                     count = 0;
                   });
}

}  // namespace

RayFrame frame_of_pixels(const RayFrame& frame, float factor) {
  RayFrame scaled = frame;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    scaled.origin_across[axis] /= factor;
    scaled.origin_down[axis] /= factor;
    scaled.direction_across[axis] /= factor;
    scaled.direction_down[axis] /= factor;
  }
  scaled.eye_pixels *= factor;
  scaled.step_pixels *= factor;
  return scaled;
}

std::vector<std::uint64_t> varying_blocks(const Picture& quarter, std::int64_t width,
                                          std::int64_t height) {
  return varying(quarter, width, height).all();
}

Picture refined_picture(const RayFrame& frame, std::int64_t width, std::int64_t height,
                        const RayRefinement& how, const CastFrame& cast,
                        const LookOfField& look_of) {
  RayLook look;
  Picture picture;
  if (how.is_adaptive) {
    picture = adaptive_picture(frame, width, height, cast, look_of, look);
  } else {
    const RayField field = cast(frame, width, height);
    if (field.tiles.empty()) return {};
    look = look_of(field);
    picture = ray_picture(field, look);
  }
  if (how.has_smooth_edges) smooth_edges(frame, cast, look, picture);
  return picture;
}

}  // namespace octavo
