#include "common/render_transparency.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "common/failure.h"
#include "common/masks.h"
#include "common/progress_line.h"
#include "octavo/render/label_color.h"
#include "octavo/render/transparency/transparency.h"
#include "octavo/render/transparency/voxel_lines.h"
#include "octavo/tasks/value_ranges.h"
#include "text/quantities.h"
#include "text/value_range_words.h"
#include "text/volume_json.h"

namespace octavo::cli {

namespace {

constexpr double kUsualOpacity = 0.05;
constexpr double kToldDegrees = 0.05;
constexpr int kMostTurns = 8;

struct TissueLook {
  const char* name;
  Color color;
  double opacity;
};

constexpr TissueLook kTissueLooks[] = {
    {"air", {90, 110, 160}, 0.002}, {"lung", {120, 190, 255}, 0.004},
    {"fat", {255, 214, 160}, 0.01}, {"soft", {224, 96, 74}, 0.01},
    {"contrast", {255, 60, 40}, 0.08}, {"bone", {255, 250, 235}, 0.08}};

[[noreturn]] void refuse_range(const std::string& text) {
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--range: '{}'; expected LOW:HIGH[=COLOR[:OPACITY]], an opacity of 0 to "
                          "1, a color as #rrggbb or one of {}",
                          escaped(text), color_names()));
}

double parse_opacity(const std::string& text, const std::string& range) {
  const double opacity = parse_number(text, "--range");
  if (!(opacity >= 0 && opacity <= 1)) refuse_range(range);
  return opacity;
}

/// LOW:HIGH[=COLOR[:OPACITY]]; `color` where none is given.
DensityRange parse_look(const std::string& text, const Color& color) {
  const std::vector<std::string> halves = split(text, '=');
  if (halves.size() > 2) refuse_range(text);
  const AskedRange ends = parse_range(halves.front(), "--range");
  DensityRange range{ends.lowest, ends.highest, color, kUsualOpacity};
  if (halves.size() == 1) return range;
  const std::vector<std::string> look = split(halves.back(), ':');
  const auto named = find_color(look.front());
  if (!named || look.size() > 2) refuse_range(text);
  range.color = *named;
  if (look.size() == 2) range.opacity = parse_opacity(look.back(), text);
  return range;
}

DensityRange tissue_look(const std::string& name, const VolumeDescription& volume,
                         const std::string& path) {
  const AskedRange ends = tissue_range(name, volume, path);
  const auto look = std::find_if(std::begin(kTissueLooks), std::end(kTissueLooks),
                                 [&](const TissueLook& one) { return name == one.name; });
  if (look == std::end(kTissueLooks)) return {ends.lowest, ends.highest, {}, kUsualOpacity};
  return {ends.lowest, ends.highest, look->color, look->opacity};
}

std::string range_text(const DensityRange& range, const std::string& unit) {
  const auto end = [](double value) { return std::isfinite(value) ? number_text(value) : ""; };
  return fmt::format("{}:{}{}", end(range.lowest), end(range.highest),
                     unit.empty() ? "" : " " + unit);
}

std::optional<Window> asked_window(const std::string& text, bool is_average) {
  if (text.empty()) return std::nullopt;
  if (is_average) {
    throw Error(ErrorKind::invalid_argument, "--window is for sums, not for --average");
  }
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() == 2) {
    const Window window{parse_number(parts[0], "--window"), parse_number(parts[1], "--window")};
    if (window.width > 0) return window;
  }
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--window: '{}'; expected CENTER,WIDTH of the sums, a width above 0",
                          escaped(text)));
}

class TransparencyScene final : public RenderScene {
 public:
  TransparencyScene(std::shared_ptr<const FileReader> reader, const RenderArguments& arguments,
                    Context& context)
      : reader_(std::move(reader)), path_(arguments.input), context_(context) {
    const VolumeDescription& volume = reader_->description();
    if (volume.kind == VolumeKind::labels) {
      throw Error(ErrorKind::invalid_argument,
                  "--mode transparency draws grey values, and this is a label map; draw it with "
                  "--mode surface",
                  arguments.input);
    }
    unit_ = unit_of(volume);
    options_.level = arguments.level;
    options_.is_average = arguments.is_average;
    options_.window = asked_window(arguments.window, arguments.is_average);
    if (!arguments.cuts.empty()) {
      options_.kept = kept_box(arguments.cuts, *reader_, arguments.level);
    }
    choose_ranges(arguments);
  }

  Box shown() const override {
    return options_.kept.value_or(box_of(reader_->levels().size(options_.level)));
  }

  Viewpoint seen_from(const Viewpoint& viewpoint) const override {
    const Geometry geometry =
        reader_->levels().geometry(reader_->description().geometry, options_.level);
    const auto [steps, degrees] = nearest_lines(geometry, viewpoint.toward);
    if (degrees > kToldDegrees) {
      context_.note(fmt::format("{}: transparency looks along lines of voxels; the nearest, "
                                "--direction {},{},{}, is {} degrees from what was asked for",
                                path_, steps.x, steps.y, steps.z,
                                number_text(std::round(degrees * 10) / 10)));
    }
    return viewpoint_along(geometry, {double(steps.x), double(steps.y), double(steps.z)});
  }

  Picture draw(const View& view, const Color& background) const override {
    TransparencyOptions options = options_;
    options.background = background;
    if (!options.is_average && window_) options.window = window_;
    TransparencyPicture drawn;
    require_memory(memory_bytes(view), "light along lines of voxels", context_);
    ProgressLine progress(context_);
    on_threads(context_, [&] {
      drawn = render_transparency(*reader_, view, options, progress);
    });
    // All pictures of a series are equally bright.
    if (!options.is_average) window_ = drawn.window;
    counts_ = drawn.counts;
    warn_of_darkness(drawn.picture, background);
    return std::move(drawn.picture);
  }

  // Of the light of all lines, and of the picture.
  std::uint64_t memory_bytes(const View& view) const {
    const Geometry geometry =
        reader_->levels().geometry(reader_->description().geometry, options_.level);
    const VoxelLines lines = voxel_lines(reader_->levels().size(options_.level),
                                         nearest_lines(geometry, view.toward).toward.reversed());
    constexpr std::uint64_t kLineBytes = 48;
    return static_cast<std::uint64_t>(lines.width) * static_cast<std::uint64_t>(lines.height) *
               kLineBytes +
           static_cast<std::uint64_t>(view.width * view.height) * 3;
  }

  std::vector<LegendRow> legend() const override {
    std::vector<LegendRow> rows;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      rows.push_back({options_.ranges[i].color, names_[i]});
    }
    if (rows.empty() && options_.is_average) {
      const Rescale& rescale = reader_->description().rescale;
      for (const double end : {options_.ramp.high, options_.ramp.low}) {
        const std::uint8_t grey = end == options_.ramp.high ? 255 : 0;
        const std::string unit = unit_.empty() ? "" : " " + unit_;
        rows.push_back({{grey, grey, grey}, number_text(rescale.to_real(end)) + unit});
      }
    }
    return rows;
  }

  nlohmann::ordered_json counts_json() const override {
    nlohmann::ordered_json ranges = nlohmann::ordered_json::array();
    for (const DensityRange& range : options_.ranges) {
      ranges.push_back({{"low", range_end_json(range.lowest)},
                        {"high", range_end_json(range.highest)},
                        {"color", range.color},
                        {"opacity", range.opacity}});
    }
    nlohmann::ordered_json json = {{"leaves", counts_.leaves},
                                   {"decoded_bricks", counts_.decoded_bricks},
                                   {"average", options_.is_average},
                                   {"ranges", ranges},
                                   {"ramp", nullptr},
                                   {"window", nullptr}};
    if (options_.ranges.empty()) {
      const Rescale& rescale = reader_->description().rescale;
      json["ramp"] = {rescale.to_real(options_.ramp.low), rescale.to_real(options_.ramp.high)};
    }
    if (window_) json["window"] = {{"center", window_->center}, {"width", window_->width}};
    return json;
  }

  std::string counts_text() const override {
    const std::string text = counted_text(counts_.leaves, "leaf", "leaves") + ", " +
                             counted_text(counts_.decoded_bricks, "brick") + " decoded";
    if (!window_) return text;
    return text + fmt::format(", window {},{}", number_text(window_->center),
                              number_text(window_->width));
  }

 private:
  void choose_ranges(const RenderArguments& arguments) {
    const VolumeDescription& volume = reader_->description();
    const auto& spacing = volume.geometry.spacing_mm;
    const double finest = *std::min_element(spacing.begin(), spacing.end());
    for (const std::string& name : arguments.tissues) {
      DensityRange range = tissue_look(name, volume, arguments.input);
      range.opacity = 1 - std::pow(1 - range.opacity, finest);
      names_.push_back(name + " " + range_text(range, unit_));
      options_.ranges.push_back(range);
    }
    std::int64_t number = 0;
    for (const std::string& text : arguments.ranges) {
      options_.ranges.push_back(parse_look(text, label_color(++number)));
      names_.push_back(range_text(options_.ranges.back(), unit_));
    }
    if (!options_.ranges.empty()) return;
    if (unit_ == "HU") options_.ranges = hounsfield_ranges(finest, options_.is_average);
    else options_.ramp = robust_ramp(*reader_, !arguments.is_average);
    for (const DensityRange& range : options_.ranges) names_.push_back(range_text(range, unit_));
  }

  /// Once for all pictures of a series.
  void warn_of_darkness(const Picture& picture, const Color& background) const {
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      if (picture.pixels[i] != background[i % background.size()]) return;
    }
    if (!std::exchange(is_darkness_told_, true)) {
      context_.warn(path_ + ": no voxel is lit; the picture is empty");
    }
  }

  std::shared_ptr<const FileReader> reader_;
  std::string path_;
  Context& context_;
  TransparencyOptions options_;
  std::string unit_;
  std::vector<std::string> names_;  // of the ranges, for the legend
  mutable std::optional<Window> window_;  // of the first picture
  mutable LineCounts counts_;
  mutable bool is_darkness_told_ = false;
};

}  // namespace

void add_transparency_options(Verb verb, RenderArguments& arguments) {
  Option average = verb.add_flag(
      "--average", arguments.is_average,
      "transparency: what is in front hides what is behind, in place of the sum");
  verb.add_option("--window", arguments.window,
                  "transparency: the sums from black to white (default: from the sums)")
      ->type_name("C,W")
      ->excludes(average);
}

void check_transparency_options(const RenderArguments& arguments) {
  if (arguments.mode == "transparency" && arguments.fade) {
    throw Error(ErrorKind::invalid_argument, "--fade is for --mode cubes and surface");
  }
  const bool is_asked = arguments.is_average || !arguments.window.empty();
  if (arguments.mode != "transparency") {
    for (const std::string& text : arguments.ranges) {
      if (text.find('=') == std::string::npos) continue;
      throw Error(ErrorKind::invalid_argument,
                  fmt::format("--range: '{}'; a color and an opacity are for --mode transparency; "
                              "--mode {} takes LOW:HIGH and has its own colors",
                              escaped(text), arguments.mode));
    }
    if (!is_asked) return;
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--average and --window are for --mode transparency, not for {}",
                            arguments.mode));
  }
  asked_window(arguments.window, arguments.is_average);
  if (arguments.turntable > kMostTurns) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--turntable {}: transparency looks along lines of voxels; there are "
                            "{} directions around a body",
                            arguments.turntable, kMostTurns));
  }
}

std::unique_ptr<RenderScene> make_transparency_scene(
    const std::shared_ptr<const FileReader>& reader, const RenderArguments& arguments,
    Context& context) {
  return std::make_unique<TransparencyScene>(reader, arguments, context);
}

}  // namespace octavo::cli
