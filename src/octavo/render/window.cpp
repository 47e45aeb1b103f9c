#include "octavo/render/window.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace octavo {

namespace {

constexpr WindowPreset kPresets[] = {
    {"brain", {40, 80}},    {"stroke", {40, 40}},       {"bone", {400, 1800}},
    {"lung", {-600, 1500}}, {"mediastinum", {50, 350}}, {"abdomen", {50, 400}},
    {"liver", {30, 150}},
};

constexpr double kIgnoredShare = 0.005;

Window window_between(double low, double high) {
  const double width = high > low ? high - low : 1;
  return {low + width / 2, width};
}

}  // namespace

std::uint8_t Window::grey(double value) const {
  const double share = (value - (center - width / 2)) / width;
  if (!(share > 0)) return 0;
  return static_cast<std::uint8_t>(std::lround(255 * std::min(share, 1.0)));
}

std::span<const WindowPreset> window_presets() { return kPresets; }

std::optional<Window> find_window_preset(std::string_view name) {
  for (const WindowPreset& preset : kPresets) {
    if (preset.name == name) return preset.window;
  }
  return {};
}

Window robust_window(std::span<const double> values) {
  std::vector<double> finite;
  finite.reserve(values.size());
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite),
               [](double v) { return std::isfinite(v); });
  if (finite.empty()) return {};
  const auto [min, max] = std::minmax_element(finite.begin(), finite.end());
  const double whole_low = *min;
  const double whole_high = *max;
  const auto last = static_cast<double>(finite.size() - 1);
  const auto at = [&](double share) {
    const auto place = finite.begin() + static_cast<std::ptrdiff_t>(std::lround(share * last));
    std::nth_element(finite.begin(), place, finite.end());
    return *place;
  };
  const double low = at(kIgnoredShare);
  const double high = at(1 - kIgnoredShare);
  return high > low ? window_between(low, high) : window_between(whole_low, whole_high);
}

}  // namespace octavo
