#include "octavo/render/rays/ray_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

using Channels = std::array<double, 3>;

Channels channels_of(const Color& color) {
  return {color[0] / 255.0, color[1] / 255.0, color[2] / 255.0};
}

/// What a ray shows of the volume over the background.
Channels volume_channels(const RayTile& tile, std::size_t ray, const RayLook& look) {
  const Channels behind = channels_of(look.background);
  if (look.mode == RayMode::extreme || look.mode == RayMode::mean) {
    const auto value = ray_value(tile, ray, look.mode, look.sign);
    if (!value) return behind;
    const std::uint8_t grey = look.window.grey(look.to_real.to_real(*value));
    return channels_of({grey, grey, grey});
  }
  const double opacity = tile.gathered[ray];
  Channels seen = {tile.red[ray], tile.green[ray], tile.blue[ray]};
  if (look.mode == RayMode::iso) {
    if (!(opacity > 0)) return behind;
    const auto number = static_cast<std::uint16_t>(opacity - 1);
    const Color surface =
        look.surface_of ? look.surface_of(number, look.surface) : look.surface;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      seen[i] = std::min(1.0, surface[i] / 255.0 * tile.red[ray] + tile.green[ray]);
    }
    return seen;
  }
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i] += (1 - opacity) * behind[i];
  return seen;
}

/// The layers that lie before what a ray shows: of an isosurface those before the hit; of what has
/// no depth all. In a volume they are part of what was gathered.
double layers_end(const RayTile& tile, std::size_t ray, RayMode mode) {
  const bool is_hit = mode == RayMode::iso && tile.gathered[ray] > 0;
  return is_hit ? static_cast<double>(tile.blue[ray]) : std::numeric_limits<double>::infinity();
}

Color color_of(const RayField& field, const RayTile& tile, std::size_t ray, const RayLook& look) {
  Channels seen = volume_channels(tile, ray, look);
  if (!field.layers.empty() && look.mode != RayMode::volume) {
    const std::size_t number =
        field.number_of(static_cast<std::size_t>(&tile - field.tiles.data()));
    seen = seen_through(field.layers[number], ray, layers_end(tile, ray, look.mode), seen);
  }
  return {seen_channel(seen[0]), seen_channel(seen[1]), seen_channel(seen[2])};
}

}  // namespace

std::vector<double> ray_values(const RayField& field, RayMode mode, float sign) {
  std::vector<double> values;
  field.for_each_pixel([&](std::int64_t, std::int64_t, const RayTile& tile, std::size_t ray) {
    if (const auto value = ray_value(tile, ray, mode, sign)) values.push_back(*value);
  });
  return values;
}

void visit_ray_colors(
    const RayField& field, const RayLook& look,
    const std::function<void(std::int64_t, std::int64_t, const Color&)>& visit) {
  field.for_each_pixel([&](std::int64_t x, std::int64_t y, const RayTile& tile, std::size_t ray) {
    visit(x, y, color_of(field, tile, ray, look));
  });
}

Picture ray_picture(const RayField& field, const RayLook& look) {
  Picture picture = make_picture(field.width, field.height, 3);
  field.for_each_pixel([&](std::int64_t x, std::int64_t y, const RayTile& tile, std::size_t ray) {
    picture.set(x, y, color_of(field, tile, ray, look));
  });
  return picture;
}

}  // namespace octavo
