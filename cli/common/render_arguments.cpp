#include "common/render_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "common/label_option.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/tasks/pictures/color_names.h"
#include "text/quantities.h"
#include "text/value_range_words.h"

namespace octavo::cli {

namespace {

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

bool is_file(const std::string& path) {
  std::error_code none;
  return std::filesystem::exists(path, none);
}

/// FILE[=COLOR[:OPACITY]]; what follows the last "=" is a part of the name where it is no color,
/// unless there is a file without it alone.
AskedMesh parse_mesh(const std::string& text) {
  const std::size_t at = text.rfind('=');
  if (at == std::string::npos) return {text, std::nullopt, 1};
  const std::vector<std::string> parts = split(text.substr(at + 1), ':');
  const auto color = find_color(parts.front());
  if (!color || parts.size() > 2) {
    if (is_file(text) || !is_file(text.substr(0, at))) return {text, std::nullopt, 1};
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--mesh: '{}'; expected COLOR[:OPACITY] behind the file, a color as "
                            "#rrggbb or one of {}",
                            escaped(text.substr(at + 1)), color_names()));
  }
  AskedMesh mesh{text.substr(0, at), color, 1};
  if (parts.size() == 2) mesh.opacity = parse_number(parts.back(), "--mesh");
  return mesh;
}

/// X,Y,Z[=NAME]
AskedMark parse_mark(const std::string& text) {
  const std::size_t at = text.find('=');
  AskedMark mark;
  mark.at_mm = parse_point(text.substr(0, at), "--mark");
  if (at != std::string::npos) mark.text = text.substr(at + 1);
  return mark;
}

[[noreturn]] void reject_label_look(const std::string& text) {
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--label-look: '{}'; expected LABEL=COLOR[:OPACITY], LABEL=none, "
                          "LABEL=same or LABEL=TRANSFER, an opacity of 0 to 1, LABEL a number, a "
                          "name or 'other'",
                          escaped(text)));
}

/// LABEL=none, LABEL=COLOR[:OPACITY] or LABEL=TRANSFER
AskedLabelLook parse_label_look(const std::string& text) {
  const std::size_t at = text.rfind('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size()) reject_label_look(text);
  AskedLabelLook look;
  const std::string label = text.substr(0, at);
  if (label != "other") look.labels = parse_labels({label});
  const std::string value = text.substr(at + 1);
  if (value == "none") {
    look.is_hidden = true;
    return look;
  }
  const std::vector<std::string> parts = split(value, ':');
  look.color = find_color(parts.front());
  if (!look.color) {
    look.transfer = value;
    return look;
  }
  if (parts.size() > 2) reject_label_look(text);
  if (parts.size() == 2) look.opacity = parse_number(parts.back(), "--label-look");
  if (look.opacity && !(*look.opacity >= 0 && *look.opacity <= 1)) reject_label_look(text);
  return look;
}

/// Whether it is a box, not a side.
bool is_box(const std::string& cut) { return cut.find(':') != std::string::npos; }

AskedCut parse_cut(const std::string& text) {
  const std::size_t axis = text.empty() ? std::string::npos : std::string("xyz").find(text[0]);
  const bool is_plane =
      axis != std::string::npos && text.size() > 2 && (text[1] == '<' || text[1] == '>');
  if (!is_plane) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--cut: '{}'; expected AXIS<INDEX or AXIS>INDEX, as in 'x<120', or a "
                            "box X:X,Y:Y,Z:Z",
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
  verb.add_flag("--grow", arguments.is_growing,
                "turntable: picture i of N shows the first i / N of the planes along z");
  verb.add_option("--fps", arguments.fps, "Of an animation")
      ->type_name("N")
      ->check(whole_within(1, 100))
      ->capture_default_str();
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

void add_ray_options(Verb verb, RenderArguments& arguments) {
  verb.add_option("--mesh", arguments.meshes,
                  "rays: a surface of an STL, PLY or OBJ file in the same picture")
      ->type_name("FILE[=COLOR[:OPACITY]]")
      ->allow_extra_args(false);
  verb.add_option("--mark", arguments.marks, "rays: a ball at a place in mm, with a name")
      ->type_name("X,Y,Z[=NAME]")
      ->allow_extra_args(false);
  verb.add_option("--mask", arguments.mask, "rays: they see no voxel where this label map is 0")
      ->type_name("FILE");
  verb.add_option("--labels", arguments.label_map,
                  "volume and iso: a label map whose labels are seen in their colors; --label "
                  "chooses some")
      ->type_name("FILE");
  verb.add_option("--label-look", arguments.label_looks,
                  "How a label looks: COLOR[:OPACITY], none, or a transfer function, as 7=red:0.2, "
                  "liver=mr, other=none")
      ->type_name("LABEL=LOOK")
      ->allow_extra_args(false);
  verb.add_flag("--ambient-shade", arguments.has_ambient_shade,
                "volume and iso: less light comes to hollows");
  verb.add_flag("--shadows", arguments.has_shadows, "volume and iso: the lamp throws shadows");
  verb.add_option("--time-budget", arguments.time_budget_s,
                  "rays: coarse levels first, and the finest that is complete in so many seconds")
      ->type_name("SECONDS")
      ->check(above_zero());
  verb.add_flag("--progressive", arguments.is_progressive,
                "rays: write coarse pictures first, each in place of the one before");
  verb.add_flag("--adaptive", arguments.is_adaptive,
                "rays: one for 2 x 2 pixels, and all of them where these differ");
  verb.add_flag("--moving", arguments.is_moving,
                "volume: light of single cells, for pictures that move");
  verb.add_flag("--smooth-edges", arguments.has_smooth_edges,
                "rays: four for a pixel that differs much from its neighbors");
}

}  // namespace

RenderOptions render_options(const RenderArguments& arguments, const Context& context) {
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
  for (const std::string& text : arguments.cuts) {
    if (is_box(text)) options.removed.push_back(parse_box(text, "--cut"));
    else options.cuts.push_back(parse_cut(text));
  }
  options.view = asked_view(arguments);
  take_size(arguments.size, options);
  options.zoom = arguments.zoom;
  options.turntable = arguments.turntable;
  options.is_growing = arguments.is_growing;
  options.fps = arguments.fps;
  for (const std::string& text : arguments.meshes) options.meshes.push_back(parse_mesh(text));
  for (const std::string& text : arguments.marks) options.marks.push_back(parse_mark(text));
  options.mask = arguments.mask;
  options.label_map = arguments.label_map;
  for (const std::string& text : arguments.label_looks) {
    options.label_looks.push_back(parse_label_look(text));
  }
  options.has_ambient_shade = arguments.has_ambient_shade;
  options.has_shadows = arguments.has_shadows;
  options.time_budget_s = arguments.time_budget_s;
  options.is_progressive = arguments.is_progressive;
  options.is_adaptive = arguments.is_adaptive;
  options.is_moving = arguments.is_moving;
  options.has_smooth_edges = arguments.has_smooth_edges;
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

bool is_of_rays(const std::string& mode) {
  return mode != "cubes" && mode != "surface" && mode != "transparency";
}

void add_render_options(Verb verb, RenderArguments& arguments) {
  verb.add_input(arguments.input);
  verb.add_output(arguments.output, "The .png file to write, or .apng, .webp or .mp4");
  std::vector<std::string> modes;
  for (const NamedMode& mode : kModes) modes.emplace_back(mode.name);
  verb.add_option("--mode", arguments.mode,
                  "What is drawn: cubes, surface, transparency, or by rays volume, mip, minip, "
                  "mean, iso")
      ->type_name("MODE")
      ->check(one_of(modes))
      ->capture_default_str();
  verb.add_option("--shade", arguments.shade,
                  "flat or smooth (default: flat cubes, smooth "
                  "surfaces)")
      ->type_name("SHADE")
      ->check(one_of({"flat", "smooth"}));
  verb.add_option("--range", arguments.ranges, "Values, or labels, to draw")
      ->type_name("LOW:HIGH[=COLOR]")
      ->allow_extra_args(false);
  verb.add_option("--tissue", arguments.tissues, "A range by name")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->check(one_of(tissue_names()));
  add_label_option(verb, arguments.labels, "Draw this label of a label map");
  verb.add_option("--level", arguments.level,
                  "Level of detail (default: 0; of rays what the picture can show)")
      ->type_name("K");
  verb.add_option("--transfer", arguments.transfer,
                  "volume, and the color of iso: bone, skin, vessels, lung, mr, lightsheet, or a "
                  "JSON file (default: skin for HU, else fitted to the values)")
      ->type_name("PRESET|FILE");
  verb.add_option("--isovalue", arguments.isovalue, "iso: the real value where its surface lies")
      ->type_name("VALUE");
  verb.add_option("--perspective", arguments.perspective,
                  "rays: as an eye sees it, at this angle from top to bottom")
      ->type_name("DEGREES")
      ->check(number_within(1, 170));
  add_ray_options(verb, arguments);
  verb.add_option("--cut", arguments.cuts,
                  "Keep the voxels on one side, AXIS<N or AXIS>N, or cut out a box X:X,Y:Y,Z:Z")
      ->type_name("PLANE|BOX")
      ->allow_extra_args(false);
  const Option average = verb.add_flag(
      "--average", arguments.is_average,
      "transparency: what is in front hides what is behind in part, in place of the sum");
  verb.add_option("--window", arguments.window,
                  "from black to white: of transparency the sums, in real units times mm; of mip, "
                  "minip and mean real values (default: from the picture)")
      ->type_name("C,W")
      ->excludes(average);
  add_view_options(verb, arguments);
}

}  // namespace octavo::cli
