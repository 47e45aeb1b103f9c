#include "octavo/tasks/structure/thickness_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "octavo/core/text.h"
#include "octavo/render/lettering.h"

namespace octavo {

namespace {

constexpr std::int64_t kPanelWidth = 560;
constexpr std::int64_t kPlotHeight = 220;
constexpr std::int64_t kTitleHeight = 62;
constexpr std::int64_t kTickHeight = 40;
constexpr std::int64_t kSideMargin = 24;
constexpr std::size_t kMostBars = 60;
constexpr double kLetterSize = 15;
constexpr Color kPaper = {255, 255, 255};
constexpr Color kBar = {59, 110, 165};
constexpr Color kMeanLine = {194, 65, 12};
constexpr Color kAxis = {90, 90, 90};

void fill_area(Picture& picture, std::int64_t x0, std::int64_t y0, std::int64_t x1,
               std::int64_t y1, const Color& color) {
  for (std::int64_t y = y0; y < y1; ++y) {
    for (std::int64_t x = x0; x < x1; ++x) picture.set(x, y, color);
  }
}

/// Shares of voxels in bars that are wide enough to see.
struct Bars {
  double width_mm = 0;
  std::vector<double> shares;
};

Bars bars_of(const ThicknessSummary& summary) {
  const std::size_t each = (summary.bins.size() + kMostBars - 1) / kMostBars;
  Bars bars;
  bars.width_mm = summary.bin_mm * static_cast<double>(each);
  bars.shares.resize((summary.bins.size() + each - 1) / each);
  for (std::size_t i = 0; i < summary.bins.size(); ++i) {
    bars.shares[i / each] +=
        static_cast<double>(summary.bins[i]) / static_cast<double>(summary.voxels);
  }
  return bars;
}

/// 1, 2 or 5 times a power of ten, so that at most six steps make up the whole.
double tick_step(double whole) {
  const double rough = whole / 6;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double times : {1.0, 2.0, 5.0}) {
    if (times * power >= rough) return times * power;
  }
  return 10 * power;
}

void draw_panel(Picture& picture, std::int64_t top, const ThicknessSummary& summary,
                const char* name) {
  const Bars bars = bars_of(summary);
  const double whole = bars.width_mm * static_cast<double>(bars.shares.size());
  const double most = *std::max_element(bars.shares.begin(), bars.shares.end());
  const std::int64_t plot_width = kPanelWidth - 2 * kSideMargin;
  const std::int64_t base = top + kTitleHeight + kPlotHeight;
  const auto column = [&](double mm) {
    return kSideMargin +
           static_cast<std::int64_t>(mm / whole * static_cast<double>(plot_width));
  };

  // Bars, the mean, the axis.
  for (std::size_t i = 0; i < bars.shares.size(); ++i) {
    const auto rows = static_cast<std::int64_t>(bars.shares[i] / most * kPlotHeight);
    const double from = bars.width_mm * static_cast<double>(i);
    fill_area(picture, column(from), base - rows, column(from + bars.width_mm) - 1, base, kBar);
  }
  const std::int64_t mean = column(summary.mean_mm);
  fill_area(picture, mean, top + kTitleHeight, mean + 2, base, kMeanLine);
  fill_area(picture, kSideMargin, base, kSideMargin + plot_width, base + 1, kAxis);

  // Words.
  const Lettering letters(kLetterSize);
  const LetterColors colors = letter_colors_on(kPaper);
  letters.draw(picture, kSideMargin, top + 12,
               fmt::format("{}: mean {:.4g} mm, deviation {:.3g} mm", name, summary.mean_mm,
                           summary.deviation_mm),
               colors);
  letters.draw(picture, kSideMargin, top + 34,
               fmt::format("highest bar {:.3g} % of {} voxels", 100 * most,
                           count_text(static_cast<std::int64_t>(summary.voxels))),
               colors);
  const double step = tick_step(whole);
  const int steps = static_cast<int>(whole * (1 + 1e-9) / step);
  for (int i = 0; i <= steps; ++i) {
    const double mm = i * step;
    const std::string text = fmt::format("{:.6g}{}", mm, i == steps ? " mm" : "");
    const std::int64_t at = column(mm);
    fill_area(picture, at, base, at + 1, base + 5, kAxis);
    const std::int64_t width = letters.width(text);
    letters.draw(picture, std::clamp<std::int64_t>(at - width / 2, 2, kPanelWidth - width - 2),
                 base + 10, text, colors);
  }
}

}  // namespace

Picture thickness_picture(const ThicknessSummary& thickness, const ThicknessSummary& spacing) {
  constexpr std::int64_t kPanel = kTitleHeight + kPlotHeight + kTickHeight;
  const std::int64_t panels = (thickness.voxels > 0 ? 1 : 0) + (spacing.voxels > 0 ? 1 : 0);
  Picture picture = make_picture(kPanelWidth, std::max<std::int64_t>(1, panels) * kPanel, 3);
  fill_area(picture, 0, 0, picture.width, picture.height, kPaper);
  std::int64_t top = 0;
  if (thickness.voxels > 0) {
    draw_panel(picture, top, thickness, "thickness");
    top += kPanel;
  }
  if (spacing.voxels > 0) draw_panel(picture, top, spacing, "separation");
  if (panels == 0) {
    Lettering(kLetterSize).draw(picture, kSideMargin, kTitleHeight, "no thickness was measured",
                                letter_colors_on(kPaper));
  }
  return picture;
}

}  // namespace octavo
