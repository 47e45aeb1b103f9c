#include "common/render_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "common/volume_options.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/tasks/pictures/color_names.h"
#include "text/quantities.h"
#include "text/value_range_words.h"

namespace octavo::cli {

namespace {

void take_size(const std::string& text, const std::string& option, RenderOptions& options) {
  const std::vector<std::string> sides = split(text, 'x');
  if (sides.size() > 2) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("{}: '{}'; expected W or WxH pixels", option, escaped(text)));
  }
  options.width = parse_integer(sides.front(), option);
  options.height = parse_integer(sides.back(), option);
}

void take_direction(const std::string& text, const std::string& option, AskedView& view) {
  if (find_viewpoint(text)) {
    view.side = text;
  } else if (split(text, ',').size() == 3) {
    view.steps = parse_point(text, option);
  } else {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("{}: '{}'; expected front, back, left, right, top, bottom, joined as "
                            "in left-front, or X,Y,Z",
                            option, escaped(text)));
  }
}

[[noreturn]] void reject_look(const std::string& text) {
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--range: '{}'; expected LOW:HIGH[=COLOR[:OPACITY]], an opacity of 0 to "
                          "1, a color as #rrggbb or one of {}",
                          escaped(text), color_names()));
}

/// LOW:HIGH[=COLOR[:OPACITY]]
AskedLook parse_look(const std::string& text, const std::string& option) {
  const std::vector<std::string> halves = split(text, '=');
  if (halves.size() > 2) reject_look(text);
  AskedLook look;
  look.range = parse_range(halves.front(), option);
  if (halves.size() == 1) return look;
  const std::vector<std::string> parts = split(halves.back(), ':');
  look.color = find_color(parts.front());
  if (!look.color || parts.size() > 2) reject_look(text);
  if (parts.size() == 2) {
    look.opacity = parse_number(parts.back(), option);
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
AskedMesh parse_mesh(const std::string& text, const std::string& option) {
  const std::size_t at = text.rfind('=');
  if (at == std::string::npos) return {text, std::nullopt, 1};
  const std::vector<std::string> parts = split(text.substr(at + 1), ':');
  const auto color = find_color(parts.front());
  if (!color || parts.size() > 2) {
    if (is_file(text) || !is_file(text.substr(0, at))) return {text, std::nullopt, 1};
    throw Error(ErrorKind::invalid_argument,
                fmt::format("{}: '{}'; expected COLOR[:OPACITY] behind the file, a color as "
                            "#rrggbb or one of {}",
                            option, escaped(text.substr(at + 1)), color_names()));
  }
  AskedMesh mesh{text.substr(0, at), color, 1};
  if (parts.size() == 2) mesh.opacity = parse_number(parts.back(), option);
  return mesh;
}

/// X,Y,Z[=NAME]
AskedMark parse_mark(const std::string& text, const std::string& option) {
  const std::size_t at = text.find('=');
  AskedMark mark;
  mark.at_mm = parse_point(text.substr(0, at), option);
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
AskedLabelLook parse_label_look(const std::string& text, const std::string& option) {
  const std::size_t at = text.rfind('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size()) reject_label_look(text);
  AskedLabelLook look;
  const std::string label = text.substr(0, at);
  if (label != "other") take_label(look.labels, label, option);
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
  if (parts.size() == 2) look.opacity = parse_number(parts.back(), option);
  if (look.opacity && !(*look.opacity >= 0 && *look.opacity <= 1)) reject_label_look(text);
  return look;
}

/// Whether it is a box, not a side.
bool is_box(const std::string& cut) { return cut.find(':') != std::string::npos; }

AskedCut parse_cut(const std::string& text, const std::string& option) {
  const std::size_t axis = text.empty() ? std::string::npos : std::string("xyz").find(text[0]);
  const bool is_plane =
      axis != std::string::npos && text.size() > 2 && (text[1] == '<' || text[1] == '>');
  if (!is_plane) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("{}: '{}'; expected AXIS<INDEX or AXIS>INDEX, as in 'x<120', or a box "
                            "X:X,Y:Y,Z:Z",
                            option, escaped(text)));
  }
  return {static_cast<int>(axis), text[1] == '<', parse_integer(text.substr(2), option)};
}

Window parse_window(const std::string& text, const std::string& option) {
  const auto numbers = parse_numbers(text, option, 2, "CENTER,WIDTH, a width above 0");
  if (numbers[1] > 0) return {numbers[0], numbers[1]};
  throw Error(
      ErrorKind::invalid_argument,
      fmt::format("{}: '{}'; expected CENTER,WIDTH, a width above 0", option, escaped(text)));
}

void add_view_options(Verb verb, RenderOptions& options) {
  verb.add_text("--size W[xH]", "Pixels: W, or WxH",
                [&options](const std::string& text, const std::string& option) {
                  take_size(text, option, options);
                })
      .default_str("1024");
  Option direction = verb.add_text("--direction SIDE|X,Y,Z", "Where the viewer stands",
                                   [&options](const std::string& text, const std::string& option) {
                                     take_direction(text, option, options.view);
                                   })
                         .default_str(options.view.side);
  verb.add_option("--azimuth DEGREES", options.view.azimuth_degrees,
                  "The viewer's angle around the patient")
      .excludes(direction);
  verb.add_option("--elevation DEGREES", options.view.elevation_degrees,
                  "The viewer's angle above the level")
      .check(number_within(-90, 90))
      .excludes(direction);
  verb.add_option("--zoom FACTOR", options.zoom, "Enlarge around the middle of the picture")
      .check(above_zero())
      .capture_default_str();
  verb.add_option("--turntable N", options.turntable, "Pictures once around the patient")
      .check(whole_within(1, 999));
  verb.add_flag("--grow", options.is_growing,
                "turntable: picture i of N shows the first i / N of the planes along z");
  verb.add_option("--fps N", options.fps, "Of an animation")
      .check(whole_within(1, 100))
      .default_str("12");
  verb.add_parsed("--background COLOR", options.background, parse_color,
                  "Its color: a name, or #rrggbb")
      .default_str("black");
  verb.add_option("--fade F", options.fade,
                  "How much darker the farthest is than the nearest;\n"
                  "default 0.5; for cubes and surface")
      .check(number_within(0, 1));
  add_lettering_flags(verb, options, "of the sides");
}

void add_ray_options(Verb verb, RenderOptions& options) {
  verb.add_list("--mesh FILE[=COLOR[:OPACITY]]", options.meshes, parse_mesh,
                "rays: a surface of an STL, PLY or OBJ file in the same picture");
  verb.add_list("--mark X,Y,Z[=NAME]", options.marks, parse_mark,
                "rays: a ball at a place in mm, with a name");
  verb.add_option("--mask FILE", options.mask, "rays: they see no voxel where this label map is 0");
  verb.add_option("--labels FILE", options.label_map,
                  "volume and iso: a label map whose labels are seen in their colors; --label "
                  "chooses some");
  verb.add_list("--label-look LABEL=LOOK", options.label_looks, parse_label_look,
                "How a label looks: COLOR[:OPACITY], none, or a transfer function, as 7=red:0.2, "
                "liver=mr, other=none");
  verb.add_flag("--ambient-shade", options.has_ambient_shade,
                "volume and iso: less light comes to hollows");
  verb.add_flag("--shadows", options.has_shadows, "volume and iso: the lamp throws shadows");
  verb.add_option("--time-budget SECONDS", options.time_budget_s,
                  "rays: coarse levels first, and the finest that is complete in so many seconds")
      .check(above_zero());
  verb.add_flag("--progressive", options.is_progressive,
                "rays: write coarse pictures first, each in place of the one before");
  verb.add_flag("--adaptive", options.is_adaptive,
                "rays: one for 2 x 2 pixels, and all of them where these differ");
  verb.add_flag("--moving", options.is_moving,
                "volume: light of single cells, for pictures that move");
  verb.add_flag("--smooth-edges", options.has_smooth_edges,
                "rays: four for a pixel that differs much from its neighbors");
}

}  // namespace

void add_render_options(Verb verb, RenderOptions& options) {
  verb.add_input(options.input);
  verb.add_output(options.output, "The .png file to write, or .apng, .webp or .mp4");
  verb.add_word("--mode MODE", options.mode,
                "What is drawn: cubes, surface, transparency, or by rays volume, mip, minip, "
                "mean, iso");
  verb.add_word("--shade SHADE", options.shade,
                "flat or smooth (default: flat cubes, smooth surfaces)");
  verb.add_list("--range LOW:HIGH[=COLOR]", options.ranges, parse_look,
                "Values, or labels, to draw");
  add_tissues(verb, options.tissues);
  add_label_option(verb, options.labels, "Draw this label of a label map");
  verb.add_option("--level K", options.level,
                  "Level of detail (default: 0; of rays what the picture can show)");
  verb.add_option("--transfer PRESET|FILE", options.transfer,
                  "volume, and the color of iso: bone, skin, vessels, lung, mr, lightsheet, or a "
                  "JSON file (default: skin for HU, else fitted to the values)");
  verb.add_option("--isovalue VALUE", options.isovalue,
                  "iso: the real value where its surface lies");
  verb.add_option("--perspective DEGREES", options.angle_degrees,
                  "rays: as an eye sees it, at this angle from top to bottom")
      .check(number_within(1, 170));
  add_ray_options(verb, options);
  verb.add_texts("--cut PLANE|BOX",
                 "Keep the voxels on one side, AXIS<N or AXIS>N, or cut out a box X:X,Y:Y,Z:Z",
                 [&options](const std::string& text, const std::string& option) {
                   if (is_box(text)) options.removed.push_back(parse_box(text, option));
                   else options.cuts.push_back(parse_cut(text, option));
                 });
  const Option average = verb.add_flag(
      "--average", options.is_average,
      "transparency: what is in front hides what is behind in part, in place of the sum");
  verb.add_parsed("--window C,W", options.window, parse_window,
                  "from black to white: of transparency the sums, times mm, of real values above "
                  "the one in the report; of mip, minip and mean real values (default: "
                  "from the picture)")
      .excludes(average);
  add_view_options(verb, options);
}

bool is_of_rays(RenderMode mode) {
  return mode != RenderMode::cubes && mode != RenderMode::surface &&
         mode != RenderMode::transparency;
}

}  // namespace octavo::cli
