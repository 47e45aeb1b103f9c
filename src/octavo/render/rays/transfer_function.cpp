#include "octavo/render/rays/transfer_function.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

constexpr TransferPreset kTransferPresets[] = {{"bone", true},    {"skin", true},
                                               {"vessels", true}, {"lung", true},
                                               {"mr", false},     {"lightsheet", false}};

TransferFunction of_hu(std::vector<TransferPoint> points) {
  return {std::move(points), 1.0, false};
}

TransferFunction of_shares(std::vector<TransferPoint> points) {
  return {std::move(points), std::nullopt, true};
}

/// The place of a value between two points.
struct BetweenPoints {
  std::size_t first = 0;
  std::size_t second = 0;
  double share = 0;
};

BetweenPoints between_points(const std::vector<TransferPoint>& points, double value) {
  const auto after =
      std::upper_bound(points.begin(), points.end(), value,
                       [](double v, const TransferPoint& point) { return v < point.value; });
  const auto second = static_cast<std::size_t>(after - points.begin());
  if (second == 0) return {};
  if (second == points.size()) return {second - 1, second - 1, 0};
  const TransferPoint& a = points[second - 1];
  const TransferPoint& b = points[second];
  return {second - 1, second, (value - a.value) / (b.value - a.value)};
}

}  // namespace

Color TransferFunction::color_at(double value) const {
  const BetweenPoints at = between_points(points, value);
  Color color;
  for (std::size_t i = 0; i < color.size(); ++i) {
    const double a = points[at.first].color[i];
    const double b = points[at.second].color[i];
    color[i] = static_cast<std::uint8_t>(std::lround(a + (b - a) * at.share));
  }
  return color;
}

double TransferFunction::opacity_at(double value) const {
  const BetweenPoints at = between_points(points, value);
  const double a = points[at.first].opacity;
  return a + (points[at.second].opacity - a) * at.share;
}

std::span<const TransferPreset> transfer_presets() { return kTransferPresets; }

std::optional<TransferFunction> find_transfer_preset(std::string_view name) {
  if (name == "bone") {
    return of_hu({{150, {214, 168, 128}, 0},
                  {260, {232, 198, 160}, 0.25},
                  {500, {250, 236, 212}, 0.7},
                  {1500, {255, 252, 242}, 0.95}});
  }
  if (name == "skin") {
    return of_hu({{-600, {222, 164, 132}, 0},
                  {-350, {232, 178, 146}, 0.16},
                  {-150, {226, 150, 120}, 0.06},
                  {-60, {214, 110, 90}, 0},
                  {150, {214, 168, 128}, 0},
                  {300, {244, 224, 196}, 0.4},
                  {1500, {255, 252, 242}, 0.95}});
  }
  if (name == "vessels") {
    return of_hu({{140, {120, 10, 10}, 0},
                  {200, {190, 32, 24}, 0.12},
                  {320, {226, 72, 52}, 0.5},
                  {450, {240, 196, 164}, 0.5},
                  {900, {255, 246, 230}, 0.8}});
  }
  if (name == "lung") {
    return of_hu({{-960, {90, 150, 210}, 0},
                  {-880, {104, 166, 222}, 0.012},
                  {-700, {150, 196, 232}, 0.018},
                  {-520, {206, 150, 150}, 0.03},
                  {-380, {214, 120, 110}, 0},
                  {160, {226, 176, 140}, 0},
                  {320, {248, 228, 200}, 0.3},
                  {1200, {255, 250, 238}, 0.8}});
  }
  if (name == "mr") {
    return of_shares({{0.18, {120, 70, 60}, 0},
                      {0.35, {204, 146, 116}, 0.05},
                      {0.65, {236, 202, 170}, 0.2},
                      {1, {255, 250, 240}, 0.5}});
  }
  if (name == "lightsheet") {
    return of_shares({{0.2, {8, 40, 60}, 0},
                      {0.45, {16, 120, 110}, 0.02},
                      {0.75, {80, 214, 140}, 0.12},
                      {1, {240, 255, 220}, 0.5}});
  }
  return std::nullopt;
}

TransferFunction usual_transfer_function() {
  return of_shares({{0.25, {110, 84, 66}, 0},
                    {0.5, {196, 156, 120}, 0.08},
                    {0.8, {236, 214, 184}, 0.3},
                    {1, {255, 250, 240}, 0.7}});
}

TransferFunction in_real_values(const TransferFunction& transfer, const Window& window) {
  TransferFunction real = transfer;
  if (!transfer.is_relative) return real;
  for (TransferPoint& point : real.points) {
    point.value = window.center + (point.value - 0.5) * window.width;
  }
  real.is_relative = false;
  return real;
}

TransferTable::TransferTable(const TransferFunction& transfer, const Rescale& rescale,
                             const PooledScale& scale, const SampleRange& pooled,
                             double layer_share) {
  // From the first to the last point, as far as there are values.
  const auto pooled_of = [&](const TransferPoint& point) {
    const double stored = (point.value - rescale.intercept) / rescale.slope;
    return std::clamp(scale.pooled(stored), pooled.lowest, pooled.highest);
  };
  const auto [low, high] =
      std::minmax({pooled_of(transfer.points.front()), pooled_of(transfer.points.back())});
  lowest_ = static_cast<float>(low);
  const double width = high - low;
  entries_per_value_ = width > 0 ? static_cast<float>(kEntries / width) : 1;

  seen_before_ = {0};
  for (std::size_t i = 0; i < kEntries; ++i) {
    // The outer ones stand for all that lies beyond them.
    const double part = i == 0 ? 0 : i + 1 == kEntries ? kEntries : static_cast<double>(i) + 0.5;
    const double value = low + part / kEntries * width;
    const double real = rescale.to_real(scale.stored(value));
    const double opacity = 1 - std::pow(1 - transfer.opacity_at(real), layer_share);
    const Color color = transfer.color_at(real);
    opacities_.push_back(static_cast<float>(opacity));
    colors_.push_back(static_cast<std::uint32_t>(color[0]) |
                      static_cast<std::uint32_t>(color[1]) << 8 |
                      static_cast<std::uint32_t>(color[2]) << 16);
    seen_before_.push_back(seen_before_.back() + (opacities_.back() > 0 ? 1 : 0));
  }
}

ColorTable TransferTable::table() const {
  return {opacities_.data(), colors_.data(), lowest_, entries_per_value_,
          static_cast<std::int32_t>(kEntries) - 1};
}

std::int32_t TransferTable::entry_of(float value) const {
  constexpr auto kLast = static_cast<float>(kEntries - 1);
  return static_cast<std::int32_t>(
      std::clamp((value - lowest_) * entries_per_value_, 0.0f, kLast));
}

bool TransferTable::is_seen(float lowest, float highest) const {
  const std::int32_t first = entry_of(lowest);
  const std::int32_t last = entry_of(highest);
  return seen_before_[static_cast<std::size_t>(last) + 1] >
         seen_before_[static_cast<std::size_t>(first)];
}

}  // namespace octavo
