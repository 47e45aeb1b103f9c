#include "octavo/render/slice/overlay.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/render/color_scale.h"
#include "octavo/render/label_color.h"
#include "octavo/render/numbers.h"
#include "octavo/render/slice/isolines.h"
#include "octavo/render/slice/outline.h"
#include "octavo/render/slice/section_samples.h"
#include "octavo/render/window.h"

namespace octavo {

namespace {

constexpr double kWashOpacity = 0.4;
constexpr int kMaximumLevels = 6;
constexpr std::size_t kScaleSteps = 256;

[[noreturn]] void reject(const char* what, const char* field) {
  throw Error(ErrorKind::invalid_argument, what).with_field(field);
}

bool is_labels(const Overlay& overlay) {
  return overlay.reader->description().kind == VolumeKind::labels;
}

/// Lines keep about the same share of a picture.
std::int64_t line_px(const PixelArea& area) {
  const auto side = static_cast<double>(std::min(area.width, area.height));
  return std::max<std::int64_t>(1, std::llround(side / 300));
}

/// Round real values of the volume up to its highest, where the index knows that.
std::vector<double> usual_levels(const Overlay& overlay) {
  const VolumeDescription& volume = overlay.reader->description();
  const Window window = robust_window(*overlay.reader);
  const ValueRange range = overlay.reader->range();
  const double ends[] = {volume.rescale.to_real(window.center - window.width / 2),
                         volume.rescale.to_real(window.center + window.width / 2)};
  const double low = std::min(ends[0], ends[1]);
  double high = std::max(ends[0], ends[1]);
  for (const std::int64_t end : {range.min, range.max}) {
    if (volume.is_unbounded(end)) continue;
    high = std::max(high, volume.rescale.to_real(volume.voxel_of(end)));
  }
  std::vector<double> levels = round_levels(low, high, kMaximumLevels);
  if (levels.empty()) levels.push_back(low);
  if (*overlay.look.kind != OverlayKind::wash) return levels;
  // Up to the next round value.
  const double last = levels.back();
  const double step = levels.size() > 1 ? last - levels[levels.size() - 2] : high - last;
  return {levels.front(), high > last ? last + step : last};
}

void check(const Overlay& overlay) {
  const OverlayLook& look = overlay.look;
  const OverlayKind kind = *look.kind;
  if (is_labels(overlay) && kind == OverlayKind::isolines) {
    reject("labels have no isolines; they are drawn as outline or wash", "overlays.kind");
  }
  if (!is_labels(overlay) && kind == OverlayKind::outline) {
    reject("grey values have no outline; they are drawn as isolines or wash", "overlays.kind");
  }
  if (is_labels(overlay) && !look.levels.empty())
    reject("labels have no levels", "overlays.levels");
  if (!is_labels(overlay) && kind == OverlayKind::wash && look.color) {
    reject("a wash of grey values has a scale of colors, not one color", "overlays.color");
  }
  for (std::size_t i = 0; i < look.levels.size(); ++i) {
    const bool is_risen = i == 0 || look.levels[i] > look.levels[i - 1];
    if (!std::isfinite(look.levels[i]) || !is_risen) {
      reject("levels must be finite and each above the one before", "overlays.levels");
    }
  }
  if (kind == OverlayKind::wash && !look.levels.empty() && look.levels.size() != 2) {
    reject("a wash has two levels, where its colors begin and end", "overlays.levels");
  }
  if (look.opacity && !(*look.opacity >= 0 && *look.opacity <= 1)) {
    reject("the opacity must be between 0 and 1", "overlays.opacity");
  }
}

/// Draws one overlay on one section.
class OverlayPainter {
 public:
  OverlayPainter(Picture& picture, const PixelArea& at, const PlaneSection& section,
                 const Overlay& overlay, OverlayLegend& legend)
      : picture_(picture), at_(at), overlay_(overlay), look_(overlay.look), legend_(legend) {
    const int level = level_for_pixels(*overlay.reader, section.pixel_mm);
    samples_ = sample_section(*overlay.reader, level, section,
                              is_labels(overlay) ? SampleInterpolation::nearest
                                                 : SampleInterpolation::linear);
    if (overlay.kept) keep_labels(samples_, *overlay.kept);
  }

  void draw() {
    legend_.pixels += samples_.pixels_inside;
    if (is_labels(overlay_)) {
      draw_labels();
      return;
    }
    to_real(samples_, overlay_.reader->description().rescale);
    if (*look_.kind == OverlayKind::wash) {
      draw_wash();
    } else {
      draw_isolines();
    }
  }

 private:
  Color color_of(std::int64_t label) const {
    return look_.color ? *look_.color : label_color(overlay_.labels, label);
  }

  void draw_labels() {
    const bool is_outline = *look_.kind == OverlayKind::outline;
    std::vector<std::uint8_t> outlines;
    if (is_outline) outlines = label_outlines(samples_, line_px(at_));
    for_each_pixel([&](std::int64_t x, std::int64_t y, double value) {
      if (std::isnan(value) || value == 0) return;
      const auto label = static_cast<std::int64_t>(value);
      ++legend_.pixels_of_label[label];
      if (is_outline && outlines[static_cast<std::size_t>(y * samples_.width + x)] == 0) return;
      picture_.blend(at_.x + x, at_.y + y, color_of(label), *look_.opacity);
    });
    legend_.rows.clear();
    for (const std::int64_t label : largest_first(legend_.pixels_of_label)) {
      legend_.rows.push_back({color_of(label), label_text(overlay_.labels, label)});
    }
  }

  void draw_wash() {
    const double low = look_.levels.front();
    const double width = std::max(look_.levels.back() - low, std::numeric_limits<double>::min());
    for_each_pixel([&](std::int64_t x, std::int64_t y, double value) {
      if (!(value >= low)) return;
      picture_.blend(at_.x + x, at_.y + y, scale_color((value - low) / width), *look_.opacity);
    });
    legend_.scale = scale_colors(kScaleSteps);
    legend_.scale_ends = {with_unit(low, overlay_.unit),
                          with_unit(look_.levels.back(), overlay_.unit)};
  }

  void draw_isolines() {
    const std::size_t count = look_.levels.size();
    const Lettering letters(std::max(9.0, 0.85 * text_size_px(at_)));
    std::vector<ValueText> texts;
    for (std::size_t i = 0; i < count; ++i) {
      const Color color = look_.color ? *look_.color : scale_colors(count)[i];
      std::vector<Isoline> lines = lines_in_picture(look_.levels[i]);
      draw_lines(lines, color);
      add_texts(lines, i, color, letters, texts);
    }
    // The values stand over all lines.
    for (const ValueText& text : texts) {
      letters.draw(picture_, text.x, text.y, text.value, {text.color, kBlack});
    }
    legend_.rows.clear();
    for (std::size_t i = count; i-- > 0;) {
      const Color color = look_.color ? *look_.color : scale_colors(count)[i];
      const std::string value = with_unit(look_.levels[i], overlay_.unit);
      legend_.rows.push_back({color, overlay_.is_named ? overlay_.name + " " + value : value});
    }
  }

  std::vector<Isoline> lines_in_picture(double level) const {
    std::vector<Isoline> lines = isolines(samples_, level);
    for (Isoline& line : lines) {
      for (PixelPoint& point : line) {
        point.x += static_cast<double>(at_.x);
        point.y += static_cast<double>(at_.y);
      }
    }
    return lines;
  }

  void draw_lines(const std::vector<Isoline>& lines, const Color& color) {
    const double width = 1.5 * static_cast<double>(line_px(at_));
    for (const bool is_casing : {true, false}) {
      StrokeMask stroke(at_, is_casing ? width + 2 : width);
      for (const Isoline& line : lines) stroke.add(line);
      stroke.draw(picture_, is_casing ? kBlack : color,
                  is_casing ? *look_.opacity / 2 : *look_.opacity);
    }
  }

  /// A value on its line: where its letters begin.
  struct ValueText {
    std::int64_t x = 0;
    std::int64_t y = 0;
    std::string value;
    Color color{};
  };

  /// Puts the value on the longest lines of a level, where no other value is near.
  void add_texts(std::vector<Isoline>& lines, std::size_t level, const Color& color,
                 const Lettering& letters, std::vector<ValueText>& texts) {
    constexpr std::size_t kMaximumTexts = 3;
    constexpr std::size_t kPlaces = 24;  // tried along a line
    const std::string value = short_number(look_.levels[level]);
    const std::int64_t width = letters.width(value);
    const std::int64_t height = letters.cap_height();
    std::stable_sort(lines.begin(), lines.end(),
                     [](const Isoline& a, const Isoline& b) { return a.size() > b.size(); });
    for (std::size_t i = 0; i < std::min(lines.size(), kMaximumTexts); ++i) {
      const Isoline& line = lines[i];
      if (static_cast<std::int64_t>(line.size()) < 5 * width) return;
      for (std::size_t k = 0; k < kPlaces; ++k) {
        // Values of neighboring levels begin to look at different parts of their lines.
        const std::size_t place = (line.size() * k / kPlaces + line.size() * (3 * level % 8) / 8);
        const PixelPoint& point = line[place % line.size()];
        const PixelArea area{std::llround(point.x) - width / 2, std::llround(point.y) - height / 2,
                             width, height};
        if (!is_free(area)) continue;
        taken_.push_back(area);
        texts.push_back({area.x, area.y, value, color});
        break;
      }
    }
  }

  bool is_free(const PixelArea& area) const {
    const std::int64_t gap = 2 * area.height;
    const std::int64_t left = area.x - at_.x;
    const std::int64_t top = area.y - at_.y;
    const bool is_inside = left >= gap && top >= gap && left + area.width + gap <= at_.width &&
                           top + area.height + gap <= at_.height;
    return is_inside && std::none_of(taken_.begin(), taken_.end(), [&](const PixelArea& other) {
             return area.x < other.x + other.width + gap && other.x < area.x + area.width + gap &&
                    area.y < other.y + other.height + gap && other.y < area.y + area.height + gap;
           });
  }

  template <class Visit>
  void for_each_pixel(Visit visit) const {
    for (std::int64_t y = 0; y < samples_.height; ++y) {
      for (std::int64_t x = 0; x < samples_.width; ++x) visit(x, y, samples_.at(x, y));
    }
  }

  Picture& picture_;
  PixelArea at_;
  const Overlay& overlay_;
  const OverlayLook& look_;
  OverlayLegend& legend_;
  SectionSamples samples_;
  std::vector<PixelArea> taken_;  // by values on lines
};

}  // namespace

std::vector<std::int64_t> largest_first(const std::map<std::int64_t, std::int64_t>& pixels) {
  std::vector<std::int64_t> labels;
  for (const auto& [label, count] : pixels) labels.push_back(label);
  std::stable_sort(labels.begin(), labels.end(), [&](std::int64_t a, std::int64_t b) {
    return pixels.at(a) > pixels.at(b);
  });
  return labels;
}

Overlay decided(Overlay overlay) {
  OverlayLook& look = overlay.look;
  if (!look.kind) look.kind = is_labels(overlay) ? OverlayKind::outline : OverlayKind::isolines;
  check(overlay);
  if (!look.opacity) look.opacity = *look.kind == OverlayKind::wash ? kWashOpacity : 1;
  if (!is_labels(overlay) && look.levels.empty()) look.levels = usual_levels(overlay);
  const ValueRange range = overlay.reader->range();
  const bool is_mask = is_labels(overlay) && range.min >= 0 && range.max <= 1;
  if (is_mask && !look.color) look.color = overlay_color(overlay.number);
  if (is_mask && overlay.labels.name_of(1).empty()) overlay.labels.set(1, {overlay.name, {}});
  return overlay;
}

void draw_overlay(Picture& picture, const PixelArea& at, const PlaneSection& section,
                  const Overlay& overlay, OverlayLegend& legend) {
  OverlayPainter(picture, at, section, overlay, legend).draw();
}

}  // namespace octavo
