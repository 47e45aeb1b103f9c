// octavo render: pictures of what an octree holds, seen from a side.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/failure.h"
#include "common/label_option.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/pictures/render.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
#include "text/value_range_words.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kRenderText = {
    "render", "Draw what a volume holds, seen from a side, as a PNG picture.",
    "Modes: cubes draws every leaf of a mask as a cube with three shades, back to front; surface\n"
    "draws those alone that are not hidden among others, the nearest first, and shades them\n"
    "smoothly, by the gradient of grey values or of the mask. --shade flat or smooth goes with\n"
    "both. Both are fitted to what is drawn. transparency lets what lies inside a grey volume\n"
    "shine through what lies around it, summed or averaged along the lines of voxels that are\n"
    "nearest to the view: one of 26 directions.\n\n"
    "Rays see grey values from any side: volume by colors and opacities of --transfer, in light;\n"
    "mip and minip the highest and the lowest value along each ray, mean their mean, iso the\n"
    "surface at --isovalue. --transfer is bone, skin, vessels, lung (all in HU), mr, lightsheet\n"
    "or a JSON file: {\"points\": [{\"value\": 150, \"color\": \"#d6a880\",\n"
    "\"opacity\": 0}, ...]}, with \"layer_mm\" the thickness that has these opacities (default:\n"
    "the finest spacing), \"relative\": true where 0 to 1 span the values and \"gradient\":\n"
    "[LOW, HIGH] the values per mm at which opacity begins and is whole. Without --level\n"
    "the picture is of the coarsest level whose voxels are no longer than a pixel; bricks that no\n"
    "ray comes to are not decoded.\n\n"
    "A label map has one color per label; --label and --range choose labels. A grey volume needs\n"
    "--range or --tissue (air, lung, fat, soft, contrast, bone, as in octavo threshold); several\n"
    "are several colors; where they overlap tissues go before ranges, then the one named first. A\n"
    "range may have a color, LOW:HIGH=COLOR, and for transparency the opacity of a layer as\n"
    "thick as the finest spacing, LOW:HIGH=COLOR:OPACITY. Transparency without a range draws a\n"
    "volume in HU as flesh and bone, another one in grey: sums of real values times mm.\n\n"
    "--direction says where the viewer stands: front, back, left, right, top, bottom of the\n"
    "patient, joined as in left-front-top; or X,Y,Z in voxels along the axes of the grid.\n"
    "--azimuth 0 is the front, 90 the patient's left; --elevation 90 is above the head.\n"
    "Letters name the patient's sides at the edges or at the ends of three axes; where nothing is\n"
    "known of a patient the axes are x, y and z of the grid.\n"
    "--cut 'x<120' keeps the voxels below 120, 'x>120' those above.\n"
    "--turntable 36 writes NAME-000.png to NAME-035.png, once around the patient.\n\n"
    "Examples:\n"
    "  octavo render head.8vo --mode surface --tissue bone -o skull.png\n"
    "  octavo render skull.8vo --mode cubes --azimuth 30 --elevation 20 -o cubes.png\n"
    "  octavo render head.8vo --range -300:225=orange --range 226:=sand --cut 'x<128' -o half.png\n"
    "  octavo render atlas.8vo --direction left --size 800x600 --background white -o atlas.png\n"
    "  octavo render organs.8vo --mode surface --label liver --label 7 -o liver.png\n"
    "  octavo render head.8vo --mode transparency --direction front -o head.png\n"
    "  octavo render head.8vo --mode volume --transfer skin --azimuth 30 -o head.png\n"
    "  octavo render head.8vo --mode iso --isovalue 226 --perspective 30 -o skull.png\n"
    "  octavo render head.8vo --mode mip --direction left -o mip.png\n"
    "  octavo render rock.8vo --mode transparency --range 90:120=sand:0.01 --range 200:=red:0.2 "
    "-o ores.png"};

struct NamedMode {
  const char* name;
  RenderMode mode;
};

constexpr NamedMode kModes[] = {
    {"cubes", RenderMode::cubes},   {"surface", RenderMode::surface},
    {"transparency", RenderMode::transparency},
    {"volume", RenderMode::volume}, {"mip", RenderMode::mip},
    {"minip", RenderMode::minip},   {"mean", RenderMode::mean},
    {"iso", RenderMode::iso}};

struct RenderArguments {
  std::string input;
  std::string output;
  std::string mode = "cubes";
  std::string shade;
  std::string size = "1024";
  std::string direction{kUsualViewpoint};
  std::optional<double> azimuth;
  std::optional<double> elevation;
  double zoom = 1;
  std::string background = "black";
  std::vector<std::string> ranges;
  std::vector<std::string> tissues;
  std::vector<std::string> labels;
  std::vector<std::string> cuts;
  std::optional<int> level;
  std::string transfer;
  std::optional<double> isovalue;
  std::optional<double> perspective;
  int turntable = 0;
  std::optional<double> fade;
  bool is_average = false;
  std::string window;
  bool no_scale_bar = false;
  bool no_sides = false;
  bool no_legend = false;
};

void take_size(const std::string& text, RenderOptions& options) {
  const std::vector<std::string> sides = split(text, 'x');
  if (sides.size() > 2) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--size: '{}'; expected W or WxH pixels", escaped(text)));
  }
  options.width = parse_integer(sides.front(), "--size");
  options.height = parse_integer(sides.back(), "--size");
}

AskedView asked_view(const RenderArguments& arguments) {
  AskedView view;
  view.azimuth_degrees = arguments.azimuth;
  view.elevation_degrees = arguments.elevation;
  if (find_viewpoint(arguments.direction)) {
    view.side = arguments.direction;
  } else if (split(arguments.direction, ',').size() == 3) {
    view.steps = parse_point(arguments.direction, "--direction");
  } else {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--direction: '{}'; expected front, back, left, right, top, bottom, "
                            "joined as in left-front, or X,Y,Z",
                            escaped(arguments.direction)));
  }
  return view;
}

Color asked_background(const std::string& text) {
  if (const auto color = find_color(text)) return *color;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--background: '{}'; expected #rrggbb or one of {}", escaped(text),
                          color_names()));
}

[[noreturn]] void reject_look(const std::string& text) {
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--range: '{}'; expected LOW:HIGH[=COLOR[:OPACITY]], an opacity of 0 to "
                          "1, a color as #rrggbb or one of {}",
                          escaped(text), color_names()));
}

/// LOW:HIGH[=COLOR[:OPACITY]]
AskedLook parse_look(const std::string& text) {
  const std::vector<std::string> halves = split(text, '=');
  if (halves.size() > 2) reject_look(text);
  AskedLook look;
  look.range = parse_range(halves.front(), "--range");
  if (halves.size() == 1) return look;
  const std::vector<std::string> parts = split(halves.back(), ':');
  look.color = find_color(parts.front());
  if (!look.color || parts.size() > 2) reject_look(text);
  if (parts.size() == 2) {
    look.opacity = parse_number(parts.back(), "--range");
    if (!(*look.opacity >= 0 && *look.opacity <= 1)) reject_look(text);
  }
  return look;
}

AskedCut parse_cut(const std::string& text) {
  const std::size_t axis = text.empty() ? std::string::npos : std::string("xyz").find(text[0]);
  const bool is_plane =
      axis != std::string::npos && text.size() > 2 && (text[1] == '<' || text[1] == '>');
  if (!is_plane) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--cut: '{}'; expected AXIS<INDEX or AXIS>INDEX, as in 'x<120'",
                            escaped(text)));
  }
  return {static_cast<int>(axis), text[1] == '<', parse_integer(text.substr(2), "--cut")};
}

Window parse_window(const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() == 2) {
    const Window window{parse_number(parts[0], "--window"), parse_number(parts[1], "--window")};
    if (window.width > 0) return window;
  }
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--window: '{}'; expected CENTER,WIDTH, a width above 0",
                          escaped(text)));
}

RenderMode mode_of(const std::string& name) {
  const auto mode = std::find_if(std::begin(kModes), std::end(kModes),
                                 [&](const NamedMode& one) { return name == one.name; });
  return mode->mode;
}

RenderOptions options_of(const RenderArguments& arguments, const Context& context) {
  RenderOptions options;
  options.input = arguments.input;
  options.output = {arguments.output, context.force};
  options.mode = mode_of(arguments.mode);
  if (!arguments.shade.empty()) {
    options.shade = arguments.shade == "flat" ? RenderShade::flat : RenderShade::smooth;
  }
  options.level = arguments.level;
  for (const std::string& text : arguments.ranges) options.ranges.push_back(parse_look(text));
  options.tissues = arguments.tissues;
  options.labels = parse_labels(arguments.labels);
  for (const std::string& text : arguments.cuts) options.cuts.push_back(parse_cut(text));
  options.view = asked_view(arguments);
  take_size(arguments.size, options);
  options.zoom = arguments.zoom;
  options.turntable = arguments.turntable;
  options.background = asked_background(arguments.background);
  options.fade = arguments.fade;
  options.is_average = arguments.is_average;
  if (!arguments.window.empty()) options.window = parse_window(arguments.window);
  if (!arguments.transfer.empty()) options.transfer = arguments.transfer;
  options.isovalue = arguments.isovalue;
  options.angle_degrees = arguments.perspective;
  options.has_scale_bar = !arguments.no_scale_bar;
  options.has_sides = !arguments.no_sides;
  options.has_legend = !arguments.no_legend;
  return options;
}

nlohmann::ordered_json cube_counts_json(const RenderCounts& counts) {
  nlohmann::ordered_json json = {{"masks", counts.masks},
                                 {"leaves", counts.leaves},
                                 {"drawn", counts.drawn},
                                 {"removed", counts.leaves - counts.drawn}};
  if (counts.shell_seconds) json["shell_seconds"] = *counts.shell_seconds;
  return json;
}

nlohmann::ordered_json line_counts_json(const RenderCounts& counts, bool is_average) {
  nlohmann::ordered_json ranges = nlohmann::ordered_json::array();
  for (const DensityRange& range : counts.ranges) {
    ranges.push_back({{"low", range_end_json(range.lowest)},
                      {"high", range_end_json(range.highest)},
                      {"color", range.color},
                      {"opacity", range.opacity}});
  }
  nlohmann::ordered_json json = {
      {"leaves", counts.leaves}, {"decoded_bricks", counts.decoded_bricks},
      {"average", is_average},   {"ranges", ranges},
      {"ramp", nullptr},         {"window", nullptr}};
  if (counts.ramp) json["ramp"] = {counts.ramp->low, counts.ramp->high};
  if (counts.window) {
    json["window"] = {{"center", counts.window->center}, {"width", counts.window->width}};
  }
  return json;
}

bool is_of_rays(const std::string& mode) {
  return mode != "cubes" && mode != "surface" && mode != "transparency";
}

nlohmann::ordered_json ray_counts_json(const RenderArguments& arguments,
                                       const RenderResult& result) {
  const RenderCounts& counts = result.counts;
  nlohmann::ordered_json json = {{"samples", counts.rays.samples},
                                 {"bricks_decoded", counts.decoded_bricks},
                                 {"frame_seconds", counts.rays.frame_seconds},
                                 {"first_seconds", result.first_seconds},
                                 {"window", nullptr},
                                 {"isovalue", nullptr}};
  if (counts.window) {
    json["window"] = {{"center", counts.window->center}, {"width", counts.window->width}};
  }
  if (arguments.isovalue) json["isovalue"] = *arguments.isovalue;
  return json;
}

nlohmann::ordered_json report_json(const RenderArguments& arguments, const RenderResult& result,
                                   const Context& context) {
  nlohmann::ordered_json json = {
      {"outputs", result.outputs}, {"mode", arguments.mode},
      {"level", result.level},     {"size", {result.width, result.height}},
      {"pixel_mm", nullptr},       {"toward", result.toward}};
  if (is_spacing_known(result.volume)) json["pixel_mm"] = result.pixel_mm;
  if (is_of_rays(arguments.mode)) {
    json.update(ray_counts_json(arguments, result));
  } else if (arguments.mode == "transparency") {
    json.update(line_counts_json(result.counts, arguments.is_average));
  } else {
    json["shade"] = result.shade == RenderShade::flat ? "flat" : "smooth";
    json.update(cube_counts_json(result.counts));
  }
  json["seconds"] = result.seconds;
  json["warnings"] = context.warnings;
  return json;
}

std::string counts_text(const std::string& mode, const RenderResult& result) {
  const RenderCounts& counts = result.counts;
  if (is_of_rays(mode)) {
    return fmt::format("level {}, {}, {} decoded", result.level,
                       counted_text(counts.rays.samples, "sample"),
                       counted_text(counts.decoded_bricks, "brick"));
  }
  const std::string leaves = counted_text(counts.leaves, "leaf", "leaves");
  if (mode == "cubes") return leaves;
  if (mode == "transparency") {
    const std::string text =
        leaves + ", " + counted_text(counts.decoded_bricks, "brick") + " decoded";
    if (!counts.window) return text;
    return text + fmt::format(", window {},{}", number_text(counts.window->center),
                              number_text(counts.window->width));
  }
  const std::int64_t removed = counts.leaves - counts.drawn;
  const double share =
      counts.leaves == 0 ? 0
                         : 100 * static_cast<double>(removed) / static_cast<double>(counts.leaves);
  return fmt::format("{} of {} leaves, {} hidden ones removed ({:.1f} %)", count_text(counts.drawn),
                     count_text(counts.leaves), count_text(removed), share);
}

std::string report_text(const RenderArguments& arguments, const RenderResult& result) {
  const std::vector<std::string>& paths = result.outputs;
  const std::string names =
      paths.size() == 1 ? paths.front() : fmt::format("{} to {}", paths.front(), paths.back());
  const std::string pixel =
      is_spacing_known(result.volume) ? fmt::format(" of {} mm", number_text(result.pixel_mm)) : "";
  return fmt::format("{}: {} x {} pixels{}, {}; drawn in {}\n", names, result.width, result.height,
                     pixel, counts_text(arguments.mode, result),
                     duration_text(result.seconds));
}

int run_render(const RenderArguments& arguments, Context& context) {
  const RenderResult result = run_task(render, options_of(arguments, context), context);
  if (context.json) print_json(report_json(arguments, result, context));
  else if (!context.quiet) print(report_text(arguments, result));
  return kExitDone;
}

void add_view_options(Verb verb, RenderArguments& arguments) {
  verb.add_option("--size", arguments.size, "Pixels: W, or WxH")
      ->type_name("W[xH]")
      ->capture_default_str();
  Option direction = verb.add_option("--direction", arguments.direction, "Where the viewer stands");
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
  verb.add_option("--fade", arguments.fade,
                  "How much darker the farthest is than the nearest;\n"
                  "default 0.5; for cubes and surface")
      ->type_name("F")
      ->check(number_within(0, 1));
  verb.add_flag("--no-scale-bar", arguments.no_scale_bar, "Leave the scale bar out");
  verb.add_flag("--no-sides", arguments.no_sides, "Leave the letters of the sides out");
  verb.add_flag("--no-legend", arguments.no_legend, "Leave the legend out");
}

}  // namespace

void add_render(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<RenderArguments>();
  Verb verb = add_verb(app, context, kRenderText,
                       [arguments, &context] { return run_render(*arguments, context); });
  verb.add_input(arguments->input);
  verb.add_output(arguments->output, "The .png file to write");
  std::vector<std::string> modes;
  for (const NamedMode& mode : kModes) modes.emplace_back(mode.name);
  verb.add_option("--mode", arguments->mode,
                  "What is drawn: cubes, surface, transparency, or by rays volume, mip, minip, "
                  "mean, iso")
      ->type_name("MODE")
      ->check(one_of(modes))
      ->capture_default_str();
  verb.add_option("--shade", arguments->shade,
                  "flat or smooth (default: flat cubes, smooth "
                  "surfaces)")
      ->type_name("SHADE")
      ->check(one_of({"flat", "smooth"}));
  verb.add_option("--range", arguments->ranges, "Values, or labels, to draw")
      ->type_name("LOW:HIGH[=COLOR]")
      ->allow_extra_args(false);
  verb.add_option("--tissue", arguments->tissues, "A range by name")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->check(one_of(tissue_names()));
  add_label_option(verb, arguments->labels, "Draw this label of a label map");
  verb.add_option("--level", arguments->level,
                  "Level of detail (default: 0; of rays what the picture can show)")
      ->type_name("K");
  verb.add_option("--transfer", arguments->transfer,
                  "volume, and the color of iso: bone, skin, vessels, lung, mr, lightsheet, or a "
                  "JSON file (default: skin for HU, else a ramp)")
      ->type_name("PRESET|FILE");
  verb.add_option("--isovalue", arguments->isovalue, "iso: the real value where its surface lies")
      ->type_name("VALUE");
  verb.add_option("--perspective", arguments->perspective,
                  "rays: as an eye sees it, at this angle from top to bottom")
      ->type_name("DEGREES")
      ->check(number_within(1, 170));
  verb.add_option("--cut", arguments->cuts, "Keep the voxels on one side: AXIS<N or AXIS>N")
      ->type_name("PLANE")
      ->allow_extra_args(false);
  const Option average = verb.add_flag(
      "--average", arguments->is_average,
      "transparency: what is in front hides what is behind in part, in place of the sum");
  verb.add_option("--window", arguments->window,
                  "from black to white: of transparency the sums, in real units times mm; of mip, "
                  "minip and mean real values (default: from the picture)")
      ->type_name("C,W")
      ->excludes(average);
  add_view_options(verb, *arguments);
}

}  // namespace octavo::cli
