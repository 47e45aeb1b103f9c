#include "octavo/render/rays/ray_picture.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace octavo {

namespace {

std::uint8_t seen_channel(double share) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(share, 0.0, 1.0) * 255));
}

/// The highest, lowest or mean value along a ray, if it met a sample.
std::optional<double> ray_value(const RayTile& tile, std::size_t ray, RayMode mode, float sign) {
  const double gathered = tile.gathered[ray];
  if (mode == RayMode::extreme) {
    return std::isfinite(gathered) ? std::optional(gathered * sign) : std::nullopt;
  }
  return gathered > 0 ? std::optional(tile.red[ray] / gathered) : std::nullopt;
}

Color color_of(const RayTile& tile, std::size_t ray, const RayLook& look) {
  if (look.mode == RayMode::extreme || look.mode == RayMode::mean) {
    const auto value = ray_value(tile, ray, look.mode, look.sign);
    if (!value) return look.background;
    const std::uint8_t grey = look.window.grey(look.to_real.to_real(*value));
    return {grey, grey, grey};
  }
  const std::array<float, 3> seen = {tile.red[ray], tile.green[ray], tile.blue[ray]};
  const double opacity = tile.gathered[ray];
  Color color;
  for (std::size_t i = 0; i < color.size(); ++i) {
    const double behind = look.background[i] / 255.0;
    if (look.mode == RayMode::iso) {
      const double lit = look.surface[i] / 255.0 * tile.red[ray] + tile.green[ray];
      color[i] = seen_channel(opacity > 0 ? lit : behind);
    } else {
      color[i] = seen_channel(seen[i] + (1 - opacity) * behind);
    }
  }
  return color;
}

}  // namespace

std::vector<double> ray_values(const RayField& field, RayMode mode, float sign) {
  std::vector<double> values;
  field.for_each_pixel([&](std::int64_t, std::int64_t, const RayTile& tile, std::size_t ray) {
    if (const auto value = ray_value(tile, ray, mode, sign)) values.push_back(*value);
  });
  return values;
}

Picture ray_picture(const RayField& field, const RayLook& look) {
  Picture picture = make_picture(field.width, field.height, 3);
  field.for_each_pixel([&](std::int64_t x, std::int64_t y, const RayTile& tile, std::size_t ray) {
    picture.set(x, y, color_of(tile, ray, look));
  });
  return picture;
}

}  // namespace octavo
