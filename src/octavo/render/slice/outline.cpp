#include "octavo/render/slice/outline.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

/// Outside the volume there is no label.
double label_at(const SectionSamples& labels, std::int64_t x, std::int64_t y) {
  const double label = labels.at(x, y);
  return std::isnan(label) ? 0 : label;
}

bool is_border(const SectionSamples& labels, std::int64_t x, std::int64_t y) {
  const double label = label_at(labels, x, y);
  if (label == 0) return false;
  return (x > 0 && label_at(labels, x - 1, y) != label) ||
         (x + 1 < labels.width && label_at(labels, x + 1, y) != label) ||
         (y > 0 && label_at(labels, x, y - 1) != label) ||
         (y + 1 < labels.height && label_at(labels, x, y + 1) != label);
}

}  // namespace

std::vector<std::uint8_t> label_outlines(const SectionSamples& labels, std::int64_t thickness) {
  std::vector<std::uint8_t> drawn(labels.values.size());
  const std::int64_t reach = thickness - 1;
  const auto grow = [&](std::int64_t x, std::int64_t y) {
    const double label = label_at(labels, x, y);
    const std::int64_t right = std::min(labels.width - 1, x + reach);
    const std::int64_t bottom = std::min(labels.height - 1, y + reach);
    for (std::int64_t v = std::max<std::int64_t>(0, y - reach); v <= bottom; ++v) {
      for (std::int64_t u = std::max<std::int64_t>(0, x - reach); u <= right; ++u) {
        const bool is_near = (u - x) * (u - x) + (v - y) * (v - y) <= reach * reach;
        if (is_near && label_at(labels, u, v) == label) {
          drawn[static_cast<std::size_t>(v * labels.width + u)] = 1;
        }
      }
    }
  };
  for (std::int64_t y = 0; y < labels.height; ++y) {
    for (std::int64_t x = 0; x < labels.width; ++x) {
      if (is_border(labels, x, y)) grow(x, y);
    }
  }
  return drawn;
}

}  // namespace octavo
