// The scene of mode transparency.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/render/label_color.h"
#include "octavo/render/numbers.h"
#include "octavo/render/transparency/transparency.h"
#include "octavo/render/transparency/voxel_lines.h"
#include "octavo/tasks/pictures/render_scene.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

constexpr double kUsualOpacity = 0.05;
constexpr double kNotedDegrees = 0.05;

struct TissueLook {
  const char* name;
  Color color;
  double opacity;  // of a layer of 1 mm
};

constexpr TissueLook kTissueLooks[] = {
    {"air", {90, 110, 160}, 0.002},    {"lung", {120, 190, 255}, 0.004},
    {"fat", {255, 214, 160}, 0.01},    {"soft", {224, 96, 74}, 0.01},
    {"contrast", {255, 60, 40}, 0.08}, {"bone", {255, 250, 235}, 0.08}};

DensityRange tissue_look(const std::string& name) {
  const AskedRange ends = tissue_range(name);
  const auto look = std::find_if(std::begin(kTissueLooks), std::end(kTissueLooks),
                                 [&](const TissueLook& one) { return name == one.name; });
  if (look == std::end(kTissueLooks)) return {ends.lowest, ends.highest, {}, kUsualOpacity};
  return {ends.lowest, ends.highest, look->color, look->opacity};
}

class TransparencyScene final : public RenderScene {
 public:
  TransparencyScene(std::shared_ptr<const FileReader> reader, const RenderOptions& options,
                    const TaskContext& context)
      : reader_(std::move(reader)), asked_(options), context_(context) {
    const VolumeDescription& volume = reader_->description();
    if (volume.kind == VolumeKind::labels) {
      throw Error(ErrorKind::invalid_argument,
                  "transparency is of grey values, and this is a label map", options.input)
          .with_field("mode");
    }
    options_.level = options.level.value_or(0);
    options_.is_average = options.is_average;
    options_.window = options.window;
    if (!options.cuts.empty()) {
      options_.kept = kept_box(options.cuts, *reader_, options_.level);
    }
    choose_ranges();
  }

  Box shown() const override {
    return options_.kept.value_or(box_of(reader_->levels().size(options_.level)));
  }

  Box fitted() const override { return kept_box(asked_.cuts, *reader_, 0); }

  void grow_to(std::int64_t planes) override {
    if (!options_.kept) options_.kept = shown();
    options_.kept->hi.z = planes;
  }

  Viewpoint seen_from(const Viewpoint& viewpoint) const override {
    const Geometry geometry = level_geometry();
    const auto [steps, degrees] = nearest_lines(geometry, viewpoint.toward);
    if (degrees > kNotedDegrees && !asked_.view.is_usual()) {
      context_.note(fmt::format(
          "{}: transparency looks along lines of voxels; the nearest, "
          "{},{},{} voxels, is {} degrees from what was asked for",
          asked_.input, steps.x, steps.y, steps.z, number_text(std::round(degrees * 10) / 10)));
    }
    return viewpoint_along(geometry, {double(steps.x), double(steps.y), double(steps.z)});
  }

  Picture draw(const View& view, const Color& background) override {
    TransparencyOptions options = options_;
    options.background = background;
    if (!options.is_average && window_) options.window = window_;
    TransparencyPicture drawn;
    context_.require_memory(memory_bytes(view), "light along lines of voxels");
    context_.on_threads(
        [&] { drawn = render_transparency(*reader_, view, options, context_.watcher()); });
    // All pictures of a series are equally bright.
    if (!options.is_average) window_ = drawn.window;
    counts_ = drawn.counts;
    warn_of_darkness(drawn);
    return std::move(drawn.picture);
  }

  std::vector<LegendRow> legend() const override {
    std::vector<LegendRow> rows;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      rows.push_back({options_.ranges[i].color, names_[i]});
    }
    if (!rows.empty()) return rows;
    const Rescale& rescale = reader_->description().rescale;
    const std::string lowest = with_unit(rescale.to_real(options_.ramp.low), unit());
    for (const int end : {1, -1}) {
      const std::uint8_t grey = end > 0 ? 255 : 0;
      std::string text = end > 0 ? with_unit(rescale.to_real(options_.ramp.high), unit()) : lowest;
      if (!options_.is_average) {
        const double sum = window_->center + end * window_->width / 2;
        text = with_unit(sum, unit()) + " \u00d7 mm";
        if (end > 0 && rescale.to_real(options_.ramp.low) != 0) text += " above " + lowest;
      }
      rows.push_back({{grey, grey, grey}, text});
    }
    return rows;
  }

  RenderCounts counts() const override {
    RenderCounts counts;
    counts.leaves = counts_.leaves;
    counts.decoded_bricks = counts_.decoded_bricks;
    counts.ranges = options_.ranges;
    counts.window = window_;
    if (options_.ranges.empty()) {
      const Rescale& rescale = reader_->description().rescale;
      counts.ramp = {rescale.to_real(options_.ramp.low), rescale.to_real(options_.ramp.high)};
    }
    return counts;
  }

 private:
  std::string unit() const { return unit_of(reader_->description()); }

  Geometry level_geometry() const {
    return reader_->levels().geometry(reader_->description().geometry, options_.level);
  }

  /// Of the light of all lines, and of the picture.
  std::uint64_t memory_bytes(const View& view) const {
    const VoxelLines lines =
        voxel_lines(reader_->levels().size(options_.level),
                    nearest_lines(level_geometry(), view.toward).toward.reversed());
    constexpr std::uint64_t kLineBytes = 48;
    return static_cast<std::uint64_t>(lines.width) * static_cast<std::uint64_t>(lines.height) *
               kLineBytes +
           static_cast<std::uint64_t>(view.width * view.height) * 3;
  }

  void choose_ranges() {
    const VolumeDescription& volume = reader_->description();
    const auto& spacing = volume.geometry.spacing_mm;
    const double finest = *std::min_element(spacing.begin(), spacing.end());
    for (const std::string& name : asked_.tissues) {
      DensityRange range = tissue_look(name);
      range.opacity = 1 - std::pow(1 - range.opacity, finest);
      names_.push_back(name + " " + look_text({{range.lowest, range.highest}, {}, {}, {}}, volume));
      options_.ranges.push_back(range);
    }
    std::int64_t number = 0;
    for (const AskedLook& look : asked_.ranges) {
      options_.ranges.push_back({look.range.lowest, look.range.highest,
                                 look.color.value_or(label_color(++number)),
                                 look.opacity.value_or(kUsualOpacity)});
      names_.push_back(look_text(look, volume));
    }
    if (!options_.ranges.empty()) return;
    if (unit() != "HU") {
      options_.ramp = robust_ramp(*reader_, !asked_.is_average);
      return;
    }
    options_.ranges = hounsfield_ranges(finest, options_.is_average);
    for (const DensityRange& range : options_.ranges) {
      names_.push_back(look_text({{range.lowest, range.highest}, {}, {}, {}}, volume));
    }
  }

  /// Once for all pictures of a series.
  void warn_of_darkness(const TransparencyPicture& drawn) {
    if (drawn.is_seen || std::exchange(is_darkness_told_, true)) return;
    context_.warn(asked_.input + (drawn.is_lit ? ": all sums are below the window; they are black"
                                               : ": no voxel is lit; the picture is empty"));
  }

  std::shared_ptr<const FileReader> reader_;
  const RenderOptions& asked_;
  const TaskContext& context_;
  TransparencyOptions options_;
  std::vector<std::string> names_;  // of the ranges, for the legend
  std::optional<Window> window_;    // of the first picture
  LineCounts counts_;
  bool is_darkness_told_ = false;
};

}  // namespace

std::unique_ptr<RenderScene> make_transparency_scene(
    const std::shared_ptr<const FileReader>& reader, const RenderOptions& options,
    const TaskContext& context) {
  return std::make_unique<TransparencyScene>(reader, options, context);
}

}  // namespace octavo
