#include "octavo/render/color_scale.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace octavo {

namespace {

constexpr Color kScale[] = {{60, 90, 240},  {40, 200, 235}, {70, 210, 90},
                            {250, 225, 60}, {250, 140, 40}, {235, 40, 50}};
constexpr Color kOverlays[] = {{255, 210, 40}, {60, 200, 255}, {255, 90, 160},
                               {110, 230, 90}, {255, 140, 40}, {190, 130, 255}};

}  // namespace

Color scale_color(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(std::size(kScale) - 1);
  const auto low = std::min(static_cast<std::size_t>(at), std::size(kScale) - 2);
  const double part = at - static_cast<double>(low);
  Color color{};
  for (std::size_t c = 0; c < color.size(); ++c) {
    const double mixed = kScale[low][c] * (1 - part) + kScale[low + 1][c] * part;
    color[c] = static_cast<std::uint8_t>(std::lround(mixed));
  }
  return color;
}

std::vector<Color> scale_colors(std::size_t count) {
  std::vector<Color> colors;
  for (std::size_t i = 0; i < count; ++i) {
    colors.push_back(
        scale_color(count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 1));
  }
  return colors;
}

Color overlay_color(std::size_t number) { return kOverlays[number % std::size(kOverlays)]; }

}  // namespace octavo
