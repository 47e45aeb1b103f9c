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

constexpr int kOuterEntries = 16;      // below the points, and above
constexpr std::size_t kEntryParts = 16;
constexpr double kMostOpacity = 1 - 1e-7;
// Shares of all values: how far outer pieces reach at least, how far they reach between the points,
// and what entries that no value has are wide. Between the points that is less than half a part.
constexpr double kOuterMinimum = 1e-2;
constexpr double kOuterOverlap = 1e-5;
constexpr double kOverlapBetween = 5e-5;
constexpr double kUnusedWidth = 1e-6;

/// Per layer.
double extinction_of(double opacity) { return -std::log1p(-std::min(opacity, kMostOpacity)); }

/// Extinction and color up to a value.
struct LayerIntegral {
  double width = 0;
  double extinction = 0;
  std::array<double, 3> color{};        // times extinction
  std::array<double, 3> plain_color{};  // times width

  void add(const Color& of, double extinction_here, double width_here) {
    width += width_here;
    extinction += extinction_here * width_here;
    for (std::size_t i = 0; i < 3; ++i) {
      color[i] += of[i] * extinction_here * width_here;
      plain_color[i] += of[i] * width_here;
    }
  }

  float opacity_since(const LayerIntegral& begin, double layers) const {
    const double mean = (extinction - begin.extinction) / (width - begin.width);
    return static_cast<float>(1 - std::exp(-mean * layers));
  }

  std::uint32_t color_since(const LayerIntegral& begin) const {
    const double weight = extinction - begin.extinction;
    std::uint32_t packed = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double mean = weight > 0 ? (color[i] - begin.color[i]) / weight
                                     : (plain_color[i] - begin.plain_color[i]) /
                                           (width - begin.width);
      const auto channel = static_cast<std::uint32_t>(std::lround(std::clamp(mean, 0.0, 255.0)));
      packed |= channel << (8 * i);
    }
    return packed;
  }
};

bool is_any_seen_at(double value, std::span<const SteppedTransfer> transfers) {
  return std::any_of(transfers.begin(), transfers.end(), [&](const SteppedTransfer& stepped) {
    return stepped.transfer.opacity_at(value) > 0;
  });
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
  if (real.gradient) {
    real.gradient->low *= window.width;
    real.gradient->high *= window.width;
  }
  real.is_relative = false;
  return real;
}

TransferTable::TransferTable(const TransferFunction& transfer, const Rescale& rescale,
                             const PooledScale& scale, const SampleRange& pooled,
                             double layer_share)
    : TransferTable(std::array{SteppedTransfer{transfer, layer_share}}, rescale, scale, pooled) {}

TransferTable::TransferTable(std::span<const SteppedTransfer> transfers, const Rescale& rescale,
                             const PooledScale& scale, const SampleRange& pooled) {
  set_pieces(transfers, rescale, scale, pooled);
  for (const SteppedTransfer& stepped : transfers) add(stepped, rescale, scale);
}

/// Pieces: below the points, between them, and above. The first value has an entry of those below,
/// and the last one of those above, so that what begins with no opacity there has none; where
/// functions begin with a step, the first value has what is above it.
void TransferTable::set_pieces(std::span<const SteppedTransfer> transfers, const Rescale& rescale,
                               const PooledScale& scale, const SampleRange& pooled) {
  const bool is_nan_below = scale.of_nan < 0;
  const double lowest = is_nan_below ? 0 : pooled.lowest;
  double low = pooled.highest;
  double high = lowest;
  bool is_step = false;
  for (const SteppedTransfer& stepped : transfers) {
    const auto& points = stepped.transfer.points;
    // What is alike for all values has no points of its own.
    if (transfers.size() > 1 && points.size() == 1) continue;
    is_step = is_step || (points.size() > 1 && points[0].value == points[1].value);
    for (const TransferPoint& point : {points.front(), points.back()}) {
      const double stored = (point.value - rescale.intercept) / rescale.slope;
      const double value = std::clamp(scale.pooled(stored), lowest, pooled.highest);
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  high = std::max(low, high);
  const bool is_falling = rescale.slope < 0;
  bool is_low_step = is_step && !is_falling;
  if (is_nan_below && is_any_seen_at(rescale.to_real(scale.stored(lowest)), transfers)) {
    low = lowest;
    is_low_step = true;
  }
  colored_width_ = high - low;
  const double all = pooled.highest > lowest ? pooled.highest - lowest : 1.0;
  const double overlap = std::min(kOuterOverlap * all, kOverlapBetween * (high - low));
  const double ends[] = {std::min(pooled.lowest, low - kOuterMinimum * all),
                         low + (is_low_step ? -overlap : overlap),
                         high + (is_step && is_falling ? overlap : -overlap),
                         std::max(pooled.highest, high + kOuterMinimum * all)};
  last_value_ = ends[3];
  unused_width_ = kUnusedWidth * all;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const double width = ends[i + 1] - ends[i];
    const double entries = i == 1 ? ColorTable::kSide - 2 * kOuterEntries : kOuterEntries;
    pieces_[i].begin = static_cast<float>(ends[i]);
    if (!(width > 0)) continue;
    pieces_[i].entries = static_cast<float>(entries);
    pieces_[i].entries_per_value = static_cast<float>(entries / width);
  }
}

void TransferTable::add(const SteppedTransfer& stepped, const Rescale& rescale,
                        const PooledScale& scale) {
  const TransferFunction& transfer = stepped.transfer;
  // Integrals of extinction and color up to each part of an entry.
  constexpr std::size_t kSide = ColorTable::kSide;
  std::vector<LayerIntegral> sums(1);
  for (std::size_t part = 0; part < kSide * kEntryParts; ++part) {
    const double begin = value_at(static_cast<double>(part) / kEntryParts);
    const double end = value_at(static_cast<double>(part + 1) / kEntryParts);
    const double real = rescale.to_real(scale.stored(0.5 * (begin + end)));
    const bool is_nan = scale.of_nan < 0 && begin + end < 0;
    const double opacity = is_nan ? 0 : transfer.opacity_at(real);
    // Entries beyond the last value are as that is.
    const double width = end > begin ? end - begin : unused_width_;
    sums.push_back(sums.back());
    sums.back().add(transfer.color_at(real), extinction_of(opacity), width);
  }

  // A step from the middle of an entry to that of another one; within an entry over all of it.
  const std::size_t first_entry = opacities_.size();
  for (std::size_t front = 0; front < kSide; ++front) {
    for (std::size_t back = 0; back < kSide; ++back) {
      const auto [first, last] = std::minmax(front, back);
      const std::size_t half = first == last ? 0 : kEntryParts / 2;
      const LayerIntegral& begin = sums[first * kEntryParts + half];
      const LayerIntegral& end = sums[(last + 1) * kEntryParts - half];
      opacities_.push_back(end.opacity_since(begin, stepped.layer_share));
      colors_.push_back(end.color_since(begin));
    }
  }
  seen_before_.push_back(0);
  for (std::size_t i = 0; i < kSide; ++i) {
    const bool is_seen = opacities_[first_entry + i * kSide + i] > 0;
    seen_before_.push_back(seen_before_.back() + (is_seen ? 1 : 0));
  }
}

ColorTable TransferTable::table() const {
  return {opacities_.data(), colors_.data(), pieces_};
}

double TransferTable::value_at(double entry) const {
  for (const ColorTable::Piece& piece : pieces_) {
    if (!(piece.entries > 0)) continue;
    if (entry < piece.entries) return piece.begin + entry / piece.entries_per_value;
    entry -= piece.entries;
  }
  return last_value_;
}

std::int32_t TransferTable::entry_of(float value) const {
  float entry = 0;
  for (const ColorTable::Piece& piece : pieces_) {
    entry += std::clamp((value - piece.begin) * piece.entries_per_value, 0.0f, piece.entries);
  }
  return std::min(static_cast<std::int32_t>(entry), ColorTable::kSide - 1);
}

bool TransferTable::is_seen(float lowest, float highest, std::size_t function) const {
  const std::size_t begin = function * (ColorTable::kSide + 1);
  const auto first = static_cast<std::size_t>(entry_of(lowest));
  const auto last = static_cast<std::size_t>(entry_of(highest));
  return seen_before_[begin + last + 1] > seen_before_[begin + first];
}

}  // namespace octavo
