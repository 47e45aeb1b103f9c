#include "octavo/render/slice/slice_picture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/render/annotation.h"
#include "octavo/render/label_color.h"
#include "octavo/render/numbers.h"
#include "octavo/render/slice/montage.h"
#include "octavo/render/slice/section_samples.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kMaximumPixels = std::int64_t{1} << 28;

/// What is drawn, and where: decided before anything is read.
struct Plan {
  Geometry geometry;                  // of the level
  std::vector<std::int64_t> indices;  // none: an oblique section
  std::vector<PlaneSection> sections;
  MontageGrid grid;
};

void check(const FileReader& reader, const SlicePictureOptions& options) {
  const int levels = reader.levels().count();
  if (options.level < 0 || options.level >= levels) {
    throw Error(ErrorKind::invalid_argument, "level " + std::to_string(options.level) +
                                                 "; it must be between 0 and " +
                                                 std::to_string(levels - 1));
  }
  if (options.window && !(options.window->width > 0)) {
    throw Error(ErrorKind::invalid_argument, "the window's width must be greater than 0");
  }
  if (options.columns < 1) {
    throw Error(ErrorKind::invalid_argument, "a picture has one column at least");
  }
}

Plan planned(const FileReader& reader, const SlicePictureOptions& options) {
  check(reader, options);
  Plan plan;
  const Size3& size = reader.levels().size(options.level);
  plan.geometry = reader.levels().geometry(reader.description().geometry, options.level);
  if (options.plane) {
    plan.sections.push_back(
        oblique_section(plan.geometry, size, *options.plane, options.minimum_side));
  } else {
    plan.indices = options.indices;
    if (plan.indices.empty() && options.axis >= 0 && options.axis < 3) {
      plan.indices.push_back(size[options.axis] / 2);
    }
    for (const std::int64_t index : plan.indices) {
      plan.sections.push_back(axis_section(plan.geometry, size, options.axis, index,
                                           options.minimum_side / options.columns));
    }
  }
  if (plan.sections.empty()) throw Error(ErrorKind::invalid_argument, "there is no such axis");
  plan.grid = montage_grid(static_cast<std::int64_t>(plan.sections.size()), options.columns,
                           plan.sections.front().width, plan.sections.front().height);
  const double pixels =
      static_cast<double>(plan.grid.width()) * static_cast<double>(plan.grid.height());
  if (pixels > static_cast<double>(kMaximumPixels)) {
    throw Error(ErrorKind::limit_exceeded,
                "the picture would exceed 2^28 pixels; use a coarser level");
  }
  const std::int64_t longest = std::max(plan.grid.width(), plan.grid.height());
  if (longest > kLongestPictureSide) {
    throw Error(ErrorKind::limit_exceeded,
                "the picture would be " + std::to_string(longest) + " pixels long, and a PNG is at "
                    "most " + std::to_string(kLongestPictureSide) + "; use a coarser level");
  }
  return plan;
}

/// Draws the planned sections into one picture.
class SlicePainter {
 public:
  SlicePainter(const FileReader& reader, const SlicePictureOptions& options, const Plan& plan)
      : reader_(reader), options_(options), plan_(plan) {}

  SlicePicture draw() {
    SlicePicture result;
    result.indices = plan_.indices;
    result.pixel_mm = plan_.sections.front().pixel_mm;
    result.letters = plan_.sections.front().letters;
    if (plan_.sections.size() == 1) result.place = plan_.sections.front().world;
    const bool is_labels = reader_.description().kind == VolumeKind::labels;
    const bool is_colored = is_labels || !options_.overlays.empty();

    // Sample the volume.
    std::vector<SectionSamples> samples;
    for (const PlaneSection& section : plan_.sections) {
      samples.push_back(sample_section(reader_, options_.level, section,
                                       is_labels ? SampleInterpolation::nearest
                                                 : SampleInterpolation::linear));
      if (!is_labels) to_real(samples.back(), reader_.description().rescale);
      else if (options_.kept_labels) keep_labels(samples.back(), *options_.kept_labels);
    }

    // Draw it.
    result.picture = make_picture(plan_.grid.width(), plan_.grid.height(), is_colored ? 3 : 1);
    if (!is_labels) window_ = options_.window ? *options_.window : window_of(samples);
    result.window = window_;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const PixelArea cell = plan_.grid.cell(static_cast<std::int64_t>(i));
      if (is_labels) {
        draw_labels(samples[i], cell, result.picture);
      } else {
        draw_grey(samples[i], cell, result.picture);
      }
    }
    samples.clear();

    // Draw the overlays above it.
    for (const Overlay& overlay : options_.overlays) {
      OverlayLegend& legend = overlay_legends_.emplace_back();
      for (std::size_t i = 0; i < plan_.sections.size(); ++i) {
        draw_overlay(result.picture, plan_.grid.cell(static_cast<std::int64_t>(i)),
                     plan_.sections[i], overlay, legend);
      }
      result.overlay_pixels.push_back(legend.pixels);
      for (const auto& [label, count] : legend.pixels_of_label) result.label_pixels += count;
    }
    for (const auto& [label, count] : label_pixels_) result.label_pixels += count;
    write(result.picture);
    return result;
  }

 private:
  static Window window_of(const std::vector<SectionSamples>& samples) {
    std::vector<double> all;
    for (const SectionSamples& one : samples) {
      all.insert(all.end(), one.values.begin(), one.values.end());
    }
    return robust_window(std::move(all));
  }

  void draw_grey(const SectionSamples& samples, const PixelArea& cell, Picture& picture) const {
    parallel_for(std::int64_t{0}, samples.height, [&](std::int64_t y) {
      for (std::int64_t x = 0; x < samples.width; ++x) {
        const std::uint8_t grey = window_.grey(samples.at(x, y));
        picture.set(cell.x + x, cell.y + y, {grey, grey, grey});
      }
    });
  }

  void draw_labels(const SectionSamples& samples, const PixelArea& cell, Picture& picture) {
    for (std::int64_t y = 0; y < samples.height; ++y) {
      for (std::int64_t x = 0; x < samples.width; ++x) {
        const double value = samples.at(x, y);
        if (std::isnan(value) || value == 0) continue;
        const auto label = static_cast<std::int64_t>(value);
        ++label_pixels_[label];
        picture.set(cell.x + x, cell.y + y, label_color(options_.labels, label));
      }
    }
  }

  /// All that is written: position in each cell, the rest once.
  void write(Picture& picture) const {
    const SliceCaptions& captions = options_.captions;
    const double text_px = text_size_px(plan_.grid.cell(0));
    const bool is_single = plan_.sections.size() == 1;
    Annotator whole(picture, {0, 0, picture.width, picture.height}, text_px);
    const std::int64_t lowest = (plan_.grid.rows - 1) * plan_.grid.columns;  // at the left edge
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(plan_.sections.size()); ++i) {
      Annotator cell(picture, plan_.grid.cell(i), text_px);
      Annotator& writing = is_single ? whole : cell;
      if (captions.has_scale_bar && captions.is_spacing_known && i == lowest) {
        writing.scale_bar(plan_.sections.front().pixel_mm);
      }
      if (captions.has_sides && captions.is_place_known && i == 0) {
        writing.sides(plan_.sections.front().letters);
      }
      if (captions.has_notes) {
        writing.lines(Corner::top_left, position_lines(static_cast<std::size_t>(i)));
      }
    }
    if (captions.has_notes) whole.lines(Corner::bottom_right, window_lines());
    if (!captions.has_legend) return;
    // Below the position that stands at the other side of the cell.
    if (!is_single && captions.has_notes) whole.skip_line(Corner::top_right);
    write_legends(whole, is_single ? Corner::top_left : Corner::top_right);
  }

  std::vector<std::string> position_lines(std::size_t number) const {
    std::vector<std::string> lines;
    if (options_.plane) {
      const Point3& at = options_.plane->point_mm;
      const double step = plan_.geometry.spacing_mm[0];
      lines.push_back("at " + place_number(at[0], step) + ", " + place_number(at[1], step) + ", " +
                      place_number(at[2], step) + " mm");
      lines.push_back("normal " + joined(options_.plane->normal, ", ", 3));
    } else {
      lines.push_back(slice_text(number));
    }
    if (options_.level > 0 && number == 0) {
      lines.push_back("level " + std::to_string(options_.level));
    }
    return lines;
  }

  /// "z 54   S 80.5 mm"
  std::string slice_text(std::size_t number) const {
    const std::string text =
        std::string(1, "xyz"[options_.axis]) + " " + std::to_string(plan_.indices[number]);
    if (!options_.captions.is_spacing_known) return text;
    // The middle of the slice, along the axis of the body that is nearest to its normal.
    const PlaneSection& section = plan_.sections[number];
    const Point3 middle = section.world.at(static_cast<double>(section.width - 1) / 2,
                                           static_cast<double>(section.height - 1) / 2);
    std::size_t row = 0;
    for (std::size_t r = 1; r < 3; ++r) {
      const auto column = static_cast<std::size_t>(options_.axis);
      const auto& d = plan_.geometry.direction;
      if (std::abs(d[3 * r + column]) > std::abs(d[3 * row + column])) row = r;
    }
    const double step = plan_.geometry.spacing_mm[static_cast<std::size_t>(options_.axis)];
    const bool is_placed = options_.captions.is_place_known;
    const double shown = is_placed ? std::abs(middle[row]) : middle[row];
    const std::string place = place_number(shown, step) + " mm";
    if (!is_placed) return text + "   " + place;
    const char side = middle[row] < 0 ? "RAI"[row] : "LPS"[row];
    return text + "   " + side + " " + place;
  }

  std::vector<std::string> window_lines() const {
    std::vector<std::string> lines;
    if (reader_.description().kind == VolumeKind::grey) {
      lines.push_back("C " + short_number(window_.center) + "  W " +
                      with_unit(window_.width, options_.captions.unit));
    }
    if (options_.captions.is_spacing_known) {
      lines.push_back(joined(plan_.geometry.spacing_mm, " \u00d7 ", 3) + " mm");
    }
    return lines;
  }

  void write_legends(Annotator& writing, Corner corner) const {
    std::vector<LegendRow> rows;
    for (const std::int64_t label : largest_first(label_pixels_)) {
      rows.push_back({label_color(options_.labels, label), label_text(options_.labels, label)});
    }
    for (const OverlayLegend& legend : overlay_legends_) {
      rows.insert(rows.end(), legend.rows.begin(), legend.rows.end());
    }
    for (const OverlayLegend& legend : overlay_legends_) {
      if (!legend.scale.empty()) writing.color_bar(corner, legend.scale, legend.scale_ends);
    }
    writing.legend(corner, rows);
  }

  const FileReader& reader_;
  const SlicePictureOptions& options_;
  const Plan& plan_;
  Window window_;
  std::map<std::int64_t, std::int64_t> label_pixels_;
  std::vector<OverlayLegend> overlay_legends_;
};

}  // namespace

SlicePicture render_slice(const FileReader& reader, const SlicePictureOptions& options) {
  const Plan plan = planned(reader, options);
  return SlicePainter(reader, options, plan).draw();
}

std::int64_t slice_pixels(const FileReader& reader, const SlicePictureOptions& options) {
  const Plan plan = planned(reader, options);
  return plan.grid.width() * plan.grid.height();
}

}  // namespace octavo
