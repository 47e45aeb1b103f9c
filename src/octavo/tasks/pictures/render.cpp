#include "octavo/tasks/pictures/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/place_known.h"
#include "octavo/core/text.h"
#include "octavo/render/cubes/relief_picture.h"
#include "octavo/render/enlarged.h"
#include "octavo/render/rays/ray_caster.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/pictures/animation_file.h"
#include "octavo/tasks/pictures/render_scene.h"
#include "octavo/tasks/value_ranges.h"
#include "octavo/tasks/volume_facts.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kDirectionsAroundABody = 8;  // along lines of voxels

[[noreturn]] void reject_render(const std::string& what, const char* field) {
  throw Error(ErrorKind::invalid_argument, what).with_field(field);
}

/// "40:", "30:50"
std::string ends_text(const AskedRange& range) {
  const auto end = [](double value) { return std::isfinite(value) ? number_text(value) : ""; };
  return end(range.lowest) + ":" + end(range.highest);
}

/// Options that rays have, and other modes do not.
void check_ray_options(const RenderOptions& options) {
  const bool is_iso = options.mode == RenderMode::iso;
  if (is_iso && !options.isovalue) reject_render("mode iso needs a value", "isovalue.missing");
  if (!is_iso && options.isovalue) {
    reject_render("a value at which a surface lies is of mode iso", "isovalue.mode");
  }
  if (options.isovalue && !std::isfinite(*options.isovalue)) {
    reject_render("the value of a surface must be finite", "isovalue.range");
  }
  if (options.transfer && options.mode != RenderMode::volume && !is_iso) {
    reject_render("a transfer function is of modes volume and iso", "transfer.mode");
  }
  if (options.angle_degrees && !is_ray_mode(options.mode)) {
    reject_render("perspective is of modes volume, mip, minip, mean and iso", "angle_degrees");
  }
  if ((!options.meshes.empty() || !options.marks.empty()) && !is_ray_mode(options.mode)) {
    reject_render("meshes and marks are of modes volume, mip, minip, mean and iso",
                  "meshes.mode");
  }
  for (const AskedMesh& mesh : options.meshes) {
    if (!(mesh.opacity >= 0 && mesh.opacity <= 1)) {
      reject_render("the opacity of a mesh is 0 to 1", "meshes.format");
    }
  }
  if (!options.mask.empty() && !is_ray_mode(options.mode)) {
    reject_render("a mask is of modes volume, mip, minip, mean and iso", "mask.mode");
  }
  if ((options.is_adaptive || options.has_smooth_edges) && !is_ray_mode(options.mode)) {
    reject_render("rays are adaptive and have smooth edges, other modes do not", "refine.mode");
  }
  if (options.is_moving && options.mode != RenderMode::volume) {
    reject_render("light for moving pictures is of mode volume", "is_moving");
  }
  const bool has_light = options.mode == RenderMode::volume || is_iso;
  if (!options.label_map.empty() && !has_light) {
    reject_render("labels beside grey values are of modes volume and iso", "label_map.mode");
  }
  if (!options.label_looks.empty() && options.label_map.empty()) {
    reject_render("looks are of the labels of a label map", "label_looks.missing");
  }
  if ((options.has_ambient_shade || options.has_shadows) && !has_light) {
    reject_render("ambient shade and shadows are of modes volume and iso", "light.mode");
  }
}

/// Options that say how pictures follow each other.
void check_series(const RenderOptions& options) {
  if (options.turntable < 0) reject_render("a turntable has at least one picture", "turntable");
  const bool is_animated = is_animation(options.output.path);
  if (is_animated && options.turntable < 1) {
    reject_render("an animation is of the pictures of a turntable", "turntable.missing");
  }
  if (options.is_growing && options.turntable < 1) {
    reject_render("what grows does so in the pictures of a turntable", "turntable.missing");
  }
  if (options.fps && !is_animated) reject_render("a picture has no speed", "fps.picture");
  if (options.fps && (*options.fps < 1 || *options.fps > 100)) {
    reject_render("an animation has 1 to 100 fps", "fps");
  }
  const bool is_in_passes = options.time_budget_s || options.is_progressive;
  if (is_in_passes && (!is_ray_mode(options.mode) || options.turntable > 0)) {
    reject_render("coarse levels come first in one picture of rays", "passes");
  }
  if (options.time_budget_s && !(*options.time_budget_s > 0)) {
    reject_render("a time budget is above 0 seconds", "time_budget_s");
  }
}

/// Options that rays do not have.
void check_rays(const RenderOptions& options) {
  if (options.fade) reject_render("rays do not fade", "fade");
  if (options.shade) reject_render("rays have no shades to choose", "shade");
  if (!options.labels.is_empty() && options.label_map.empty()) {
    reject_render("rays are of grey values, not of labels", "labels.mode");
  }
  if (!options.ranges.empty() || !options.tissues.empty()) {
    reject_render("rays see all values, not ranges or tissues", "ranges.rays");
  }
  if (options.is_average) reject_render("an average is of mode transparency", "is_average");
  const bool has_window = options.mode != RenderMode::volume && options.mode != RenderMode::iso;
  if (options.window && !has_window) {
    reject_render("a window is of modes transparency, mip, minip and mean", "window");
  }
}

/// Options that contradict each other, whatever the volume.
void check_render(const RenderOptions& options) {
  const std::string& path = options.output.path;
  if (!options.on_picture && !is_animation(path) && !path.ends_with(".png")) {
    throw Error(ErrorKind::invalid_argument,
                "a picture is written as .png, a turntable as .png, .apng, .webp or .mp4", path)
        .with_field("output.animation");
  }
  check_series(options);
  check_ray_options(options);
  if (is_ray_mode(options.mode)) {
    check_rays(options);
  } else if (options.mode == RenderMode::transparency) {
    if (options.fade) reject_render("transparency does not fade", "fade");
    if (options.shade) reject_render("transparency has no shades", "shade");
    if (!options.labels.is_empty()) {
      reject_render("transparency is of grey values, not of labels", "labels.mode");
    }
    if (!options.removed.empty()) {
      reject_render("transparency has no boxes cut out", "cuts.mode");
    }
    if (options.is_average && options.window)
      reject_render("a window is of sums, not of averages", "window");
    if (options.turntable > kDirectionsAroundABody) {
      reject_render(
          fmt::format("a turntable of {}; transparency looks along lines of voxels, and there "
                      "are {} directions around a body",
                      options.turntable, kDirectionsAroundABody),
          "turntable");
    }
  } else {
    for (const AskedLook& look : options.ranges) {
      if (look.opacity) {
        reject_render("the range " + ends_text(look.range) +
                          " has an opacity, which is of mode transparency",
                      "ranges.look");
      }
    }
    if (options.is_average) reject_render("an average is of mode transparency", "is_average");
    if (options.window) {
      reject_render("a window is of modes transparency, mip, minip and mean", "window");
    }
  }
}

ViewFrame frame_of(const RenderOptions& options) {
  return {options.width, options.height, options.zoom, {}};
}

/// geometry  of level 0: steps are voxels, whatever the level that is drawn
Viewpoint viewpoint_of(const AskedView& asked, const Geometry& geometry) {
  if (asked.azimuth_degrees || asked.elevation_degrees) {
    return viewpoint_at(asked.azimuth_degrees.value_or(0), asked.elevation_degrees.value_or(0));
  }
  if (asked.steps) return viewpoint_along(geometry, *asked.steps);
  if (const auto named = find_viewpoint(asked.side)) return *named;
  reject_render("no side is called " + escaped(asked.side), "view.side");
}

/// The name of the output, or for a turntable with a number before the ending.
std::vector<std::string> picture_paths(const RenderOptions& options) {
  if (options.turntable == 0 || is_animation(options.output.path)) return {options.output.path};
  if (options.on_picture) {
    return std::vector<std::string>(static_cast<std::size_t>(options.turntable));
  }
  std::vector<std::string> paths;
  for (int i = 0; i < options.turntable; ++i) {
    std::string& path = paths.emplace_back(options.output.path);
    path.insert(path.size() - 4, fmt::format("-{:03}", i));
  }
  return paths;
}

/// Of three channels three times: as it is drawn, as rows of a PNG file and as that file; where it
/// is smooth, once beside what drawing takes. Of rays besides what they gather.
std::uint64_t picture_bytes(const RenderOptions& options, int threads) {
  const auto bytes = 3 * static_cast<std::uint64_t>(options.width * options.height);
  if (is_ray_mode(options.mode)) {
    return 3 * bytes + field_bytes(options);
  }
  const bool is_relief =
      options.mode != RenderMode::transparency && shade_of(options) == RenderShade::smooth;
  if (!is_relief) return 3 * bytes;
  return std::max(3 * bytes, bytes + relief_memory_bytes(options.width, options.height, threads));
}

/// What can be rejected without the file is rejected before it is read.
void check_picture(const RenderOptions& options, const TaskContext& context) {
  fitting_pixel_mm({}, {{0, 0, 0}, {1, 1, 1}}, viewpoint_of(options.view, {}), frame_of(options));
  context.require_memory(picture_bytes(options, context.thread_count()), "the picture");
}

/// The level to draw, where none is asked for.
RenderOptions with_level(const RenderOptions& asked, const FileReader& reader) {
  RenderOptions options = asked;
  if (options.level) return options;
  options.level = 0;
  if (is_ray_mode(options.mode)) {
    const Geometry& geometry = reader.description().geometry;
    const ViewFrame frame = frame_of(options);
    const double pixel_mm =
        fitting_pixel_mm(geometry, kept_box(options.cuts, reader, 0),
                         viewpoint_of(options.view, geometry), frame) /
        frame.zoom;
    options.level = ray_level(reader.levels(), geometry, pixel_mm);
  }
  return options;
}

std::unique_ptr<RenderScene> make_scene(const std::shared_ptr<const FileReader>& reader,
                                        const RenderOptions& options, const TaskContext& context,
                                        Communicator* ranks) {
  if (options.mode == RenderMode::transparency) {
    return make_transparency_scene(reader, options, context);
  }
  CastField cast;
  if (ranks != nullptr) {
    cast = [ranks, &context](RayBricks& bricks, const RayFrame& frame,
                             std::span<const RayRegion> regions, std::int64_t width,
                             std::int64_t height) {
      return cast_by_ranks(bricks, frame, regions, width, height, *ranks, context);
    };
  }
  if (is_ray_mode(options.mode)) return make_ray_scene(reader, options, context, cast);
  return make_cube_scene(reader, options, context);
}

void annotate(Picture& picture, const View& view, const RenderScene& scene,
              const RenderOptions& options, const VolumeDescription& volume) {
  Annotator writing(picture);
  writing.set_ground(options.background);
  const bool has_scale = is_spacing_known(volume) && !options.angle_degrees;
  if (options.has_scale_bar && has_scale) writing.scale_bar(view.pixel_mm);
  if (options.has_sides) {
    // Where no patient is known the axes are those of the grid.
    const bool is_of_patient = is_place_known(volume);
    if (is_of_patient && is_seen_from_a_side(view)) writing.sides(edge_letters(view));
    else writing.axes(is_of_patient ? patient_axes(view) : grid_axes(view));
  }
  if (options.has_legend) {
    writing.legend(Corner::top_left, scene.legend());
    if (const auto bar = scene.color_legend()) {
      writing.color_bar(Corner::top_left, bar->colors, bar->ends);
    }
  }
  for (const PlacedText& text : scene.texts()) writing.text_beside(text.x, text.y, text.text);
}

/// The pictures of a series, on one scale.
class Series {
 public:
  Series(RenderScene& scene, const FileReader& reader, const RenderOptions& options,
         std::size_t count)
      : scene_(scene), reader_(reader), options_(options), frame_(frame_of(options)) {
    const VolumeDescription& volume = reader.description();
    const Viewpoint first = viewpoint_of(options.view, volume.geometry);
    for (std::size_t i = 0; i < count; ++i) {
      const double degrees = 360 * static_cast<double>(i) / static_cast<double>(count);
      viewpoints_.push_back(scene.seen_from(turned(first, degrees)));
      // The scale at which the largest fits.
      frame_.pixel_mm =
          std::max(frame_.pixel_mm.value_or(0),
                   fitting_pixel_mm(volume.geometry, scene.fitted(), viewpoints_.back(), frame_));
    }
    // What cannot be drawn is rejected before anything is.
    for (std::size_t i = 0; i < count; ++i) view(i);
  }

  View view(std::size_t number) const { return view_in(number, frame_); }

  /// A picture with all that is written on it; adds the time for drawing it.
  /// shrink  2: one pixel is drawn for 2 x 2
  Picture draw(std::size_t number, double& seconds, int shrink = 1) const {
    const View seen = view(number);
    const Clock::time_point start = Clock::now();
    if (options_.is_growing) grow(number);
    Picture picture;
    if (shrink == 1) {
      picture = scene_.draw(seen, options_.background);
    } else {
      ViewFrame small = frame_;
      small.width = (frame_.width + 1) / shrink;
      small.height = (frame_.height + 1) / shrink;
      small.pixel_mm = *frame_.pixel_mm * shrink;
      picture = enlarged(scene_.draw(view_in(number, small), options_.background), frame_.width,
                         frame_.height, shrink);
    }
    seconds += std::chrono::duration<double>(Clock::now() - start).count();
    if (picture.width > 0) annotate(picture, seen, scene_, options_, reader_.description());
    return picture;
  }

 private:
  View view_in(std::size_t number, const ViewFrame& frame) const {
    const Levels& levels = reader_.levels();
    const int level = *options_.level;
    Point3 middle = middle_of(scene_.fitted());
    for (int axis = 0; axis < 3; ++axis) {
      double& at = middle[static_cast<std::size_t>(axis)];
      at = std::ldexp(at, -levels.halving_count(level, axis));
    }
    return view_around(levels.geometry(reader_.description().geometry, level), levels.size(level),
                       middle, viewpoints_[number], frame);
  }

  void grow(std::size_t number) const {
    const Box shown = scene_.shown();
    const auto planes = static_cast<double>(shown.hi.z - shown.lo.z);
    const double share =
        static_cast<double>(number + 1) / static_cast<double>(viewpoints_.size());
    const auto grown = static_cast<std::int64_t>(std::ceil(planes * share - 1e-9));
    scene_.grow_to(shown.lo.z + std::max<std::int64_t>(grown, 1));
  }

  RenderScene& scene_;
  const FileReader& reader_;
  const RenderOptions& options_;
  ViewFrame frame_;
  std::vector<Viewpoint> viewpoints_;
};

/// What a picture is like.
void describe(const View& view, const RenderScene& scene, int level, RenderResult& result) {
  result.level = level;
  result.width = view.width;
  result.height = view.height;
  result.pixel_mm = view.pixel_mm;
  result.toward = view.toward;
  result.counts = scene.counts();
}

double seconds_from(const Clock::time_point& start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void note_unknown_place(const VolumeDescription& volume, const RenderOptions& options,
                        const TaskContext& context) {
  if (is_place_known(volume) || (options.view.steps && options.turntable == 0)) return;
  context.note(options.input +
               ": does not say how the patient lies; x is taken to run to the "
               "left, y to the back and z to the head");
}

/// ranks  or none; only the first one has pictures
void draw_all(const std::shared_ptr<const FileReader>& reader, const RenderOptions& options,
              const Clock::time_point& opened, const TaskContext& context, Communicator* ranks,
              RenderResult& result) {
  const auto scene = make_scene(reader, options, context, ranks);
  const bool writes = ranks == nullptr || ranks->is_first();
  const std::size_t count = static_cast<std::size_t>(std::max(options.turntable, 1));
  const Series series(*scene, *reader, options, count);
  note_unknown_place(reader->description(), options, context);
  PictureFiles files(context, options.on_picture);
  std::optional<AnimationFile> animation;
  if (writes && is_animation(options.output.path)) {
    const AnimationFrame frame{options.width, options.height, static_cast<std::uint32_t>(count),
                               options.fps.value_or(AnimationFrame{}.fps)};
    animation.emplace(options.output.path, frame, context);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Picture picture = series.draw(i, result.seconds);
    if (i == 0) result.first_seconds = seconds_from(opened);
    if (animation) animation->add(picture);
    else if (writes) files.add(result.outputs[i], picture);
  }
  if (animation) animation->publish(options.output.overwrite);
  else files.publish(options.output.overwrite);
  describe(series.view(0), *scene, *options.level, result);
}

/// A watcher that stops the work once its time is over, after it was given one.
class TimedProgress final : public Progress {
 public:
  explicit TimedProgress(Progress& watched) : watched_(watched) {}

  void set_end(const Clock::time_point& end) {
    end_ = end;
    has_end_ = true;
  }
  bool is_over() const { return has_end_ && Clock::now() > end_; }
  bool is_stopped() const { return watched_.is_cancelled(); }

  void begin(std::string_view what, std::int64_t total, std::string_view unit) override {
    watched_.begin(what, total, unit);
  }
  void advance(std::int64_t units) override { watched_.advance(units); }
  void end() override { watched_.end(); }
  bool is_cancelled() const override { return is_stopped() || is_over(); }

 private:
  Progress& watched_;
  Clock::time_point end_;
  std::atomic<bool> has_end_ = false;
};

/// What all passes have to warn of is reported once.
TaskContext::WarningListener told_once(const TaskContext& context) {
  if (!context.on_warning) return {};
  return [told = std::vector<Warning>(), &context](const Warning& warning) mutable {
    if (std::find(told.begin(), told.end(), warning) != told.end()) return;
    told.push_back(warning);
    context.on_warning(warning);
  };
}

/// Coarse levels first: the first picture has voxels of up to 2^kCoarseLevels pixels, and one ray
/// for 2 x 2 of these.
constexpr int kCoarseLevels = 3;

void draw_in_passes(const RenderOptions& asked,
                    const std::shared_ptr<const FileReader>& opened_reader,
                    const RenderOptions& options, const Clock::time_point& opened,
                    const TaskContext& context, RenderResult& result) {
  TimedProgress watch(context.watcher());
  TaskContext timed = context;
  timed.progress = &watch;
  timed.on_warning = told_once(context);
  // Of time that is limited bricks have to stop as well.
  const auto reader = asked.time_budget_s
                          ? std::shared_ptr<const FileReader>(open_volume(asked.input, timed))
                          : opened_reader;
  const int finest = *options.level;
  const int coarsest = std::min(finest + kCoarseLevels, reader->levels().count() - 1);
  Picture last;
  bool has_name = options.output.overwrite;
  for (int pass = coarsest + 1; pass >= finest; --pass) {
    RenderOptions of_pass = options;
    of_pass.level = std::min(pass, coarsest);
    const int shrink = pass > coarsest ? 2 : 1;
    Picture picture;
    try {
      const auto scene = make_ray_scene(reader, of_pass, timed);
      const Series series(*scene, *reader, of_pass, 1);
      if (result.passes.empty()) note_unknown_place(reader->description(), options, context);
      picture = series.draw(0, result.seconds, shrink);
      describe(series.view(0), *scene, *of_pass.level, result);
    } catch (const Error& error) {
      const bool is_over = error.kind() == ErrorKind::cancelled && !watch.is_stopped();
      if (!is_over || result.passes.empty()) throw;
      result.is_complete = false;
      break;
    }
    result.passes.push_back({*of_pass.level, shrink, seconds_from(opened)});
    if (result.passes.size() == 1) {
      result.first_seconds = result.passes.front().seconds;
      if (asked.time_budget_s) {
        watch.set_end(opened + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(*asked.time_budget_s)));
      }
    }
    last = std::move(picture);
    if (!options.is_progressive) continue;
    PictureFiles files(context, options.on_picture);
    files.add(options.output.path, last);
    files.publish(has_name);
    has_name = true;
  }
  if (!options.is_progressive) {
    PictureFiles files(context, options.on_picture);
    files.add(options.output.path, last);
    files.publish(has_name);
  }
  if (!result.is_complete) {
    const RenderPass& reached = result.passes.back();
    context.note(fmt::format("the time budget of {} s ended at level {}{}; level {} is what the "
                             "picture can show",
                             number_text(*asked.time_budget_s), reached.level,
                             reached.shrink > 1 ? ", one ray for 4 pixels" : "", finest),
                 "time_budget_s");
  }
}

}  // namespace

RenderShade shade_of(const RenderOptions& options) {
  // Flat cubes show the octree, smooth surfaces the object.
  return options.shade.value_or(options.mode == RenderMode::surface ? RenderShade::smooth
                                                                    : RenderShade::flat);
}

std::string look_text(const AskedLook& look, const VolumeDescription& volume) {
  if (!look.text.empty()) return look.text;
  const std::string unit = unit_of(volume);
  const AskedRange& range = look.range;
  std::string text = number_text(range.lowest) + " to " + number_text(range.highest);
  if (range.lowest == range.highest) text = number_text(range.lowest);
  else if (!std::isfinite(range.highest)) text = "\u2265 " + number_text(range.lowest);
  else if (!std::isfinite(range.lowest)) text = "\u2264 " + number_text(range.highest);
  return unit.empty() ? text : text + " " + unit;
}

namespace {

RenderResult render_for(const RenderOptions& asked, const TaskContext& context,
                        Communicator* ranks) {
  check_render(asked);
  const std::vector<std::string> paths = picture_paths(asked);
  check_picture(asked, context);
  const Clock::time_point opened = Clock::now();
  const std::shared_ptr<const FileReader> reader = open_volume(asked.input, context);
  const RenderOptions options = with_level(asked, *reader);
  require_level(reader->levels(), *options.level);
  check_tissues(options.tissues, reader->description(), options.input, context);
  const bool is_of_masks =
      options.mode == RenderMode::cubes || options.mode == RenderMode::surface;
  if (is_of_masks) require_cube_scene(*reader, options);
  const bool writes = ranks == nullptr || ranks->is_first();
  for (const std::string& path : paths) {
    if (!writes || options.on_picture) break;
    require_free({path, options.output.overwrite});
    require_no_input(path, {options.input});
  }

  RenderResult result;
  result.volume = reader->description();
  result.outputs = paths;
  result.shade = shade_of(options);
  const bool is_in_passes = options.time_budget_s || options.is_progressive;
  if (is_in_passes) draw_in_passes(asked, reader, options, opened, context, result);
  else draw_all(reader, options, opened, context, ranks, result);
  return result;
}

}  // namespace

RenderResult render(const RenderOptions& options, const TaskContext& context) {
  return render_for(options, context, nullptr);
}

RenderResult render_by_ranks(const RenderOptions& options, Communicator& ranks,
                             const TaskContext& context) {
  if (!is_ray_mode(options.mode)) {
    reject_render("ranks draw modes volume, mip, minip, mean and iso", "ranks.mode");
  }
  if (options.time_budget_s || options.is_progressive || options.is_adaptive ||
      options.has_smooth_edges) {
    reject_render("ranks draw no coarse pictures first, and one ray for each pixel",
                  "ranks.options");
  }
  // All come to the same warnings.
  TaskContext own = context;
  if (!ranks.is_first()) own.on_warning = {};
  return render_for(options, own, &ranks);
}

}  // namespace octavo
