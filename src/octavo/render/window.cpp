#include "octavo/render/window.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

namespace octavo {

namespace {

constexpr WindowPreset kPresets[] = {
    {"brain", {40, 80}},    {"stroke", {40, 40}},       {"bone", {400, 1800}},
    {"lung", {-600, 1500}}, {"mediastinum", {50, 350}}, {"abdomen", {50, 400}},
    {"liver", {30, 150}},
};

constexpr double kIgnoredShare = 0.005;
constexpr std::int64_t kMaximumSamples = std::int64_t{1} << 21;

Window window_between(double low, double high) {
  constexpr double kRounding = 1e-9;  // of the width: what is left of a center that is 0
  const double width = high > low ? high - low : 1;
  const double center = low + width / 2;
  return {std::abs(center) < kRounding * width ? 0 : center, width};
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

Window robust_window(std::vector<double> finite) {
  std::erase_if(finite, [](double v) { return !std::isfinite(v); });
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
  if (high > low) return window_between(low, high);
  return whole_high > whole_low ? window_between(whole_low, whole_high)
                                : window_of_one(whole_low);
}

Window window_of_one(double value) {
  return window_between(std::min(0.0, value), std::max(0.0, value));
}

std::vector<double> sampled_values(const FileReader& reader) {
  const Levels& levels = reader.levels();
  int level = 0;
  while (levels.size(level).voxel_count() > kMaximumSamples) ++level;
  const Size3 size = levels.size(level);
  const VoxelType type = reader.description().type;
  const auto count = static_cast<std::size_t>(size.voxel_count());
  std::vector<std::byte> samples(count * static_cast<std::size_t>(bytes_per_voxel(type)));
  reader.read(box_of(size), level, samples.data());
  std::vector<double> values(count);
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::size_t i = 0; i < count; ++i) {
      T value;
      std::memcpy(&value, samples.data() + i * sizeof value, sizeof value);
      values[i] = static_cast<double>(value);
    }
  });
  return values;
}

Window robust_window(const FileReader& reader) { return robust_window(sampled_values(reader)); }

}  // namespace octavo
