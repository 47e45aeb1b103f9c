// octavo render: pictures of what an octree holds, seen from a side.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/cancel.h"
#include "common/failure.h"
#include "common/masks.h"
#include "common/options.h"
#include "common/render_scene.h"
#include "common/render_transparency.h"
#include "common/task_run.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/file/storage/storage.h"
#include "octavo/io/source/place_known.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/value_ranges.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "render", "Draw the leaves of an octree as a PNG picture.",
    "Modes: cubes draws every leaf of a mask as a cube with three shades, back to front; surface\n"
    "draws those alone that are not hidden among others, the nearest first: the same picture,\n"
    "sooner. Both are fitted to what is drawn. transparency lets what lies inside a grey volume\n"
    "shine through what lies around it, summed or averaged along the lines of voxels that are\n"
    "nearest to the view: one of 26 directions.\n\n"
    "A label map has one color per label; --range chooses labels. A grey volume needs --range or\n"
    "--tissue (air, lung, fat, soft, contrast, bone, as in octavo threshold); several are several\n"
    "colors; where they overlap tissues go before ranges, then the one named first. For\n"
    "transparency a range may have a color and the opacity of one voxel,\n"
    "LOW:HIGH=COLOR:OPACITY; without any, a volume in HU is drawn as flesh and bone, another one\n"
    "in grey.\n\n"
    "--direction says where the viewer stands: front, back, left, right, top, bottom of the\n"
    "patient, or X,Y,Z in voxels along the axes of the grid. --azimuth 0 is the front, 90 the\n"
    "patient's left; --elevation 90 is above the head. --cut 'x<120' keeps the voxels below 120,\n"
    "'x>120' those above.\n"
    "--turntable 36 writes NAME-000.png to NAME-035.png, once around the patient.\n\n"
    "Examples:\n"
    "  octavo render head.8vo --tissue bone --direction front -o skull.png\n"
    "  octavo render skull.8vo --mode surface --azimuth 30 --elevation 20 -o skull.png\n"
    "  octavo render head.8vo --range -300:225 --range 226: --cut 'x<128' -o half.png\n"
    "  octavo render atlas.8vo --direction left --size 800x600 --background white -o atlas.png\n"
    "  octavo render head.8vo --mode transparency --direction front -o head.png\n"
    "  octavo render rock.8vo --mode transparency --range 90:120=sand:0.01 --range 200:=red:0.2 "
    "-o ores.png"};

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

ViewFrame asked_frame(const RenderArguments& arguments) {
  const std::vector<std::string> sides = split(arguments.size, 'x');
  if (sides.size() > 2) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--size: '{}'; expected W or WxH pixels", escaped(arguments.size)));
  }
  ViewFrame frame;
  frame.width = parse_integer(sides.front(), "--size");
  frame.height = parse_integer(sides.back(), "--size");
  frame.zoom = arguments.zoom;
  return frame;
}

/// geometry  of level 0: steps are voxels, whatever the level that is drawn
Viewpoint asked_viewpoint(const RenderArguments& arguments, const Geometry& geometry) {
  if (arguments.azimuth || arguments.elevation) {
    return viewpoint_at(arguments.azimuth.value_or(0), arguments.elevation.value_or(0));
  }
  if (const auto named = find_viewpoint(arguments.direction)) return *named;
  if (split(arguments.direction, ',').size() != 3) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--direction: '{}'; expected front, back, left, right, top, bottom or "
                            "X,Y,Z",
                            escaped(arguments.direction)));
  }
  return viewpoint_along(geometry, parse_point(arguments.direction, "--direction"));
}

Color asked_background(const std::string& text) {
  if (const auto color = find_color(text)) return *color;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--background: '{}'; expected #rrggbb or one of {}", escaped(text),
                          color_names()));
}

std::unique_ptr<RenderScene> make_scene(const std::shared_ptr<const FileReader>& reader,
                                        const RenderArguments& arguments, Context& context) {
  if (arguments.mode == "transparency") {
    return make_transparency_scene(reader, arguments, context);
  }
  return make_cube_scene(reader, arguments, context);
}

/// The names of the pictures: that of -o, or with a number before the ending.
std::vector<std::string> picture_paths(const RenderArguments& arguments) {
  if (!arguments.output.ends_with(".png")) {
    throw Error(ErrorKind::invalid_argument, "a picture is written as .png", arguments.output);
  }
  if (arguments.turntable == 0) return {arguments.output};
  std::vector<std::string> paths;
  for (int i = 0; i < arguments.turntable; ++i) {
    std::string& path = paths.emplace_back(arguments.output);
    path.insert(path.size() - 4, fmt::format("-{:03}", i));
  }
  return paths;
}

/// What is said of a picture beside its pixels.
struct Captions {
  bool has_scale_bar = true;
  bool has_sides = true;
  bool has_legend = true;
};

void annotate(Picture& picture, const View& view, const RenderScene& scene,
              const Captions& captions) {
  Annotator writing(picture);
  if (captions.has_scale_bar) writing.scale_bar(view.pixel_mm);
  if (captions.has_sides && is_seen_from_a_side(view)) writing.sides(edge_letters(view));
  if (captions.has_sides && !is_seen_from_a_side(view)) writing.axes(patient_axes(view));
  if (captions.has_legend) writing.legend(Corner::top_left, scene.legend());
}

std::unique_ptr<PendingFile> pending_png(const Picture& picture, const std::string& path) {
  auto file = std::make_unique<PendingFile>(local_storage(), path);
  file->append(encode_png(picture));
  file->seal();
  return file;
}

struct Drawn {
  View view;           ///< of the first picture
  double seconds = 0;  ///< for drawing all
};

/// Draws all pictures, and gives them their names when the last is complete.
Drawn draw_pictures(const RenderScene& scene, const std::vector<std::string>& paths,
                    const RenderArguments& arguments, const FileReader& reader,
                    const Context& context) {
  const VolumeDescription& volume = reader.description();
  const Geometry geometry = reader.levels().geometry(volume.geometry, arguments.level);
  const Size3& size = reader.levels().size(arguments.level);
  const Viewpoint first = asked_viewpoint(arguments, volume.geometry);
  const Color background = asked_background(arguments.background);
  const Captions captions{!arguments.no_scale_bar && is_spacing_known(volume),
                          !arguments.no_sides && is_place_known(volume),
                          !arguments.no_legend};

  // One scale for all pictures: the one at which the largest fits.
  std::vector<Viewpoint> viewpoints;
  ViewFrame frame = asked_frame(arguments);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const double degrees = 360 * static_cast<double>(i) / static_cast<double>(paths.size());
    viewpoints.push_back(scene.seen_from(turned(first, degrees)));
    frame.pixel_mm = std::max(
        frame.pixel_mm.value_or(0),
        fitting_pixel_mm(geometry, scene.shown(), viewpoints.back(), frame));
  }

  Drawn drawn;
  // Until all have their names, a signal must not leave temporary files behind.
  const CancellableWork work;
  std::vector<std::unique_ptr<PendingFile>> files;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (is_cancel_requested()) throw Error(ErrorKind::cancelled, "stopped while drawing");
    const View view = make_view(geometry, size, scene.shown(), viewpoints[i], frame);
    const Clock::time_point start = Clock::now();
    Picture picture = scene.draw(view, background);
    drawn.seconds += seconds_since(start);
    if (i == 0) drawn.view = view;
    annotate(picture, view, scene, captions);
    files.push_back(pending_png(picture, paths[i]));
  }
  for (const auto& file : files) file->publish(context.force);
  return drawn;
}

void report(const RenderScene& scene, const std::vector<std::string>& paths, const Drawn& drawn,
            const RenderArguments& arguments, const VolumeDescription& volume,
            const Context& context) {
  const View& view = drawn.view;
  const bool is_scaled = is_spacing_known(volume);
  if (context.json) {
    nlohmann::ordered_json result = {{"outputs", paths},
                                     {"mode", arguments.mode},
                                     {"level", arguments.level},
                                     {"size", {view.width, view.height}},
                                     {"pixel_mm", nullptr},
                                     {"toward", view.toward}};
    if (is_scaled) result["pixel_mm"] = view.pixel_mm;
    result.update(scene.counts_json());
    result["seconds"] = drawn.seconds;
    result["warnings"] = context.warnings;
    print_json(result);
  } else if (!context.quiet) {
    const std::string names =
        paths.size() == 1 ? paths.front() : fmt::format("{} to {}", paths.front(), paths.back());
    print(fmt::format("{}: {} x {} pixels{}, {}; drawn in {}\n", names, view.width, view.height,
                      is_scaled ? fmt::format(" of {} mm", number_text(view.pixel_mm)) : "",
                      scene.counts_text(), duration_text(drawn.seconds)));
  }
}

/// Of three channels three times: as it is drawn, as rows of a PNG file and as that file.
std::uint64_t picture_bytes(const ViewFrame& frame) {
  constexpr std::uint64_t kBytesPerPixel = 9;
  if (frame.width < 1 || frame.width > ViewFrame::kLongestSide || frame.height < 1 ||
      frame.height > ViewFrame::kLongestSide) {
    return 0;  // rejected where it is looked at
  }
  return kBytesPerPixel * static_cast<std::uint64_t>(frame.width * frame.height);
}

int run_render(const RenderArguments& arguments, Context& context) {
  // What can be rejected without the file is rejected before it is read.
  const std::vector<std::string> paths = picture_paths(arguments);
  for (const std::string& path : paths) require_free({path, context.force});
  asked_background(arguments.background);
  const ViewFrame frame = asked_frame(arguments);
  require_memory(picture_bytes(frame), "the picture", context);
  fitting_pixel_mm({}, {{0, 0, 0}, {1, 1, 1}}, asked_viewpoint(arguments, {}), frame);
  check_transparency_options(arguments);
  const std::shared_ptr<const FileReader> reader =
      open_volume(arguments.input, brief_task(context));
  check_level(reader->levels(), arguments.level);
  const Box whole = box_of(reader->levels().size(arguments.level));
  const VolumeDescription& volume = reader->description();
  const Geometry geometry = reader->levels().geometry(volume.geometry, arguments.level);
  make_view(geometry, reader->levels().size(arguments.level), whole,
            asked_viewpoint(arguments, volume.geometry), frame);
  const bool is_of_patient = arguments.azimuth || arguments.elevation || arguments.turntable > 0 ||
                             find_viewpoint(arguments.direction).has_value();
  if (is_of_patient && !is_place_known(volume)) {
    context.note(arguments.input + ": does not say how the patient lies; x is taken to run to the "
                                   "left, y to the back and z to the head");
  }

  const auto scene = make_scene(reader, arguments, context);
  const Drawn drawn = draw_pictures(*scene, paths, arguments, *reader, context);
  report(*scene, paths, drawn, arguments, volume, context);
  return kExitDone;
}

void add_view_options(Verb verb, RenderArguments& arguments) {
  verb.add_option("--size", arguments.size, "Pixels: W, or WxH")
      ->type_name("W[xH]")
      ->capture_default_str();
  Option direction =
      verb.add_option("--direction", arguments.direction, "Where the viewer stands");
  direction->type_name("SIDE|X,Y,Z")->capture_default_str();
  verb.add_option("--azimuth", arguments.azimuth, "The viewer's angle around the patient")
      ->type_name("DEGREES")
      ->excludes(direction);
  verb.add_option("--elevation", arguments.elevation, "The viewer's angle above the level")
      ->type_name("DEGREES")
      ->check(number_within(-90, 90))
      ->excludes(direction);
  verb.add_option("--zoom", arguments.zoom, "Enlarge around the middle of the picture")
      ->type_name("FACTOR")
      ->check(above_zero())
      ->capture_default_str();
  verb.add_option("--turntable", arguments.turntable, "Pictures once around the patient")
      ->type_name("N")
      ->check(whole_within(1, 999));
  verb.add_option("--background", arguments.background, "Its color: a name, or #rrggbb")
      ->type_name("COLOR")
      ->capture_default_str();
  verb.add_option("--fade", arguments.fade, "How much darker the farthest is than the nearest;\n"
                                             "default 0.5; not for transparency")
      ->type_name("F")
      ->check(number_within(0, 1));
  verb.add_flag("--no-scale-bar", arguments.no_scale_bar, "Leave the scale bar out");
  verb.add_flag("--no-sides", arguments.no_sides, "Leave the letters R L A P S I out");
  verb.add_flag("--no-legend", arguments.no_legend, "Leave the legend out");
}

}  // namespace

void add_render(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<RenderArguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_render(*arguments, context); });
  verb.add_option("file", arguments->input, "An .8vo file or a URL of one")
      ->type_name("FILE")
      ->required();
  verb.add_option("-o,--output", arguments->output, "The .png file to write")
      ->type_name("FILE")
      ->required();
  verb.add_option("--mode", arguments->mode, "What is drawn: cubes, surface or transparency")
      ->type_name("MODE")
      ->check(one_of({"cubes", "surface", "transparency"}))
      ->capture_default_str();
  verb.add_option("--range", arguments->ranges, "Values, or labels, to draw")
      ->type_name("LOW:HIGH")
      ->allow_extra_args(false);
  verb.add_option("--tissue", arguments->tissues, "A range by name")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->check(one_of(tissue_names()));
  verb.add_option("--level", arguments->level, "Level of detail")
      ->type_name("K")
      ->capture_default_str();
  verb.add_option("--cut", arguments->cuts, "Keep the voxels on one side: AXIS<N or AXIS>N")
      ->type_name("PLANE")
      ->allow_extra_args(false);
  add_transparency_options(verb, *arguments);
  add_view_options(verb, *arguments);
}

}  // namespace octavo::cli
