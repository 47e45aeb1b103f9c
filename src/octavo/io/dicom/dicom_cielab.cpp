#include "octavo/io/dicom/dicom_cielab.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

constexpr double kWhiteX = 0.95047;  // D65; that of y is 1
constexpr double kWhiteZ = 1.08883;

/// From the scale of L* to that of light: a cube, and a line near black.
double light_of(double scaled) {
  constexpr double kEnd = 6.0 / 29;
  return scaled > kEnd ? scaled * scaled * scaled : 3 * kEnd * kEnd * (scaled - 4.0 / 29);
}

/// A part of linear light as sRGB has it.
std::uint8_t srgb_part(double linear) {
  constexpr double kLineEnd = 0.0031308;
  const double part =
      linear > kLineEnd ? 1.055 * std::pow(linear, 1 / 2.4) - 0.055 : 12.92 * linear;
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(part, 0.0, 1.0)));
}

}  // namespace

std::optional<LabelColor> color_of_cielab(std::span<const std::uint16_t> encoded) {
  if (encoded.size() != 3) return std::nullopt;
  constexpr double kMost = 65535;
  const double l = 100 * encoded[0] / kMost;
  const double a = 255 * encoded[1] / kMost - 128;
  const double b = 255 * encoded[2] / kMost - 128;

  const double scaled = (l + 16) / 116;
  const double x = kWhiteX * light_of(scaled + a / 500);
  const double y = light_of(scaled);
  const double z = kWhiteZ * light_of(scaled - b / 200);

  return LabelColor{srgb_part(3.2406 * x - 1.5372 * y - 0.4986 * z),
                    srgb_part(-0.9689 * x + 1.8758 * y + 0.0415 * z),
                    srgb_part(0.0557 * x - 0.2040 * y + 1.0570 * z)};
}

}  // namespace octavo
