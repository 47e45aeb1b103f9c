// octavo slice: pictures of planes, for people.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/options.h"
#include "common/salvage_option.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/pictures/slice.h"
#include "octavo/tasks/volume_facts.h"
#include "text/offered_words.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kSliceText = {
    "slice", "Draw slices and oblique sections as PNG pictures.",
    "Pixels are square whatever the spacing. The window is CENTER,WIDTH in real units, a preset\n"
    "in HU (brain, stroke, bone, lung, mediastinum, abdomen, liver) or auto; labels have colors\n"
    "and no window. --axis all writes NAME-x.png, NAME-y.png and NAME-z.png, each of the middle:\n"
    "--index and --mm go with one axis.\n\n"
    "--plane takes the section along any plane, in mm (LPS): X,Y,Z,NX,NY,NZ is a point and a\n"
    "normal, NX,NY,NZ a normal through the middle of the volume.\n"
    "--montage 4x3 draws 12 slices in one picture, --every 5 each fifth one; both together 12\n"
    "slices, 5 apart, around the middle or --index.\n\n"
    "--overlay draws another volume over the slices, where it lies in space: labels and masks as\n"
    "outline or wash, grey values as isolines or wash. It can be given several times; options of\n"
    "overlays are given once for all of them, or as often as overlays, in their order.\n"
    "--overlay-levels are the values of isolines, or the two ends of a wash, and given once those\n"
    "of all overlays of grey values; given for each overlay, none leaves one without. Isolines of\n"
    "a second overlay have one color.\n"
    "--label leaves all other labels out: of the file, or where it holds grey values of the label\n"
    "maps over it.\n\n"
    "Examples:\n"
    "  octavo slice head.8vo -o head.png --window brain\n"
    "  octavo slice head.8vo --axis x --mm -12.5 --window 300,1500 -o side.png\n"
    "  octavo slice head.8vo --axis all --level 2 -o preview.png\n"
    "  octavo slice head.8vo --plane 0,-0.5,1 -o tilted.png\n"
    "  octavo slice head.8vo --montage 4x3 --window brain -o sheet.png\n"
    "  octavo slice chest.8vo --overlay tumor.8vo --overlay-color red -o tumor.png\n"
    "  octavo slice ct.8vo --overlay organs.8vo --label liver --label spleen -o organs.png\n"
    "  octavo slice plan.8vo --overlay organs.8vo --overlay dose.8vo --overlay-levels 20,40,60 \\\n"
    "    -o dose.png"};

struct SliceArguments {
  SliceOptions options;
  std::string montage;
  std::optional<std::int64_t> every;
  std::vector<std::string> overlays;
  std::vector<OverlayKind> overlay_kinds;
  std::vector<std::vector<double>> overlay_levels;
  std::vector<Color> overlay_colors;
  std::vector<double> overlay_opacities;
};

void take_window(const std::string& text, const std::string& option, SliceOptions& options) {
  if (text == kAutomatic) return;
  if (find_window_preset(text)) {
    options.window_preset = text;
    return;
  }
  const std::string expected =
      fmt::format("CENTER,WIDTH or one of {}", fmt::join(window_words(), ", "));
  if (text.find(',') == std::string::npos) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("{}: '{}'; expected {}", option, escaped(text), expected));
  }
  const auto numbers = parse_numbers(text, option, 2, expected.c_str());
  options.window = Window{numbers[0], numbers[1]};
  if (options.window->width > 0) return;
  throw Error(ErrorKind::invalid_argument, option + ": the width must be positive");
}

AskedPlane parse_plane(const std::string& text, const std::string& option) {
  const bool has_point = split(text, ',').size() != 3;
  const auto n = parse_numbers(text, option, has_point ? 6 : 3, "X,Y,Z,NX,NY,NZ or NX,NY,NZ");
  if (!has_point) return {std::nullopt, {n[0], n[1], n[2]}};
  return {Point3{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
}

std::vector<int> parse_axes(const std::string& text) {
  if (text == "all") return {0, 1, 2};
  return {static_cast<int>(std::string("xyz").find(text))};
}

std::vector<double> parse_levels(const std::string& text, const std::string& option) {
  std::vector<double> levels;
  if (text == "none") return levels;
  for (const std::string& level : split(text, ',')) levels.push_back(parse_number(level, option));
  return levels;
}

OverlayKind parse_overlay_kind(const std::string& word) {
  return *value_of_word<OverlayKind>(word);
}

std::optional<AskedMontage> asked_montage(const SliceArguments& arguments) {
  if (arguments.montage.empty() && !arguments.every) return std::nullopt;
  AskedMontage montage;
  montage.every = arguments.every;
  if (arguments.montage.empty()) return montage;
  const std::vector<std::string> sides = split(arguments.montage, 'x');
  if (sides.size() != 2) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--montage: '{}'; expected COLUMNSxROWS, as in 4x3",
                            escaped(arguments.montage)));
  }
  montage.columns = parse_integer(sides[0], "--montage");
  montage.rows = parse_integer(sides[1], "--montage");
  return montage;
}

/// Takes the value of an overlay's option, its own or the one for all, where there is one.
template <class T, class Value>
void take_of_overlay(const std::vector<T>& values, std::size_t number, Value& value) {
  if (!values.empty()) value = values[values.size() == 1 ? 0 : number];
}

void require_count(std::size_t count, const SliceArguments& arguments, const char* option) {
  const std::size_t overlays = arguments.overlays.size();
  if (count == 0 || (overlays > 0 && (count == 1 || count == overlays))) return;
  throw Error(ErrorKind::invalid_argument,
              overlays == 0 ? fmt::format("{} goes with --overlay", option)
                            : fmt::format("{}: {} for {} overlays; give it once, or for each",
                                          option, count, overlays));
}

std::vector<AskedOverlay> asked_overlays(const SliceArguments& arguments) {
  require_count(arguments.overlay_kinds.size(), arguments, "--overlay-as");
  require_count(arguments.overlay_levels.size(), arguments, "--overlay-levels");
  require_count(arguments.overlay_colors.size(), arguments, "--overlay-color");
  require_count(arguments.overlay_opacities.size(), arguments, "--overlay-opacity");
  std::vector<AskedOverlay> overlays;
  for (std::size_t i = 0; i < arguments.overlays.size(); ++i) {
    AskedOverlay& overlay = overlays.emplace_back();
    overlay.path = arguments.overlays[i];
    take_of_overlay(arguments.overlay_kinds, i, overlay.look.kind);
    if (arguments.overlay_levels.size() > 1) overlay.look.levels = arguments.overlay_levels[i];
    take_of_overlay(arguments.overlay_colors, i, overlay.look.color);
    take_of_overlay(arguments.overlay_opacities, i, overlay.look.opacity);
  }
  return overlays;
}

SliceOptions options_of(const SliceArguments& arguments) {
  SliceOptions options = arguments.options;
  options.montage = asked_montage(arguments);
  options.overlays = asked_overlays(arguments);
  if (arguments.overlay_levels.size() == 1) {
    options.overlay_levels = arguments.overlay_levels.front();
  }
  return options;
}

nlohmann::ordered_json slice_json(const DrawnSlice& slice, const SliceResult& result) {
  nlohmann::ordered_json object = {{"output", slice.path},
                                   {"axis", nullptr},
                                   {"index", nullptr},
                                   {"indices", slice.indices},
                                   {"plane", nullptr},
                                   {"level", result.level},
                                   {"width", slice.width},
                                   {"height", slice.height},
                                   {"pixel_mm", if_in_mm(result.volume, slice.pixel_mm)},
                                   {"place_mm", nullptr},
                                   {"window", window_json(slice.window)}};
  if (slice.axis) object["axis"] = std::string(1, "xyz"[*slice.axis]);
  if (slice.indices.size() == 1) object["index"] = slice.indices.front();
  if (slice.plane) {
    object["plane"] = {{"point_mm", slice.plane->point_mm}, {"normal", slice.plane->normal}};
  }
  if (slice.place && is_spacing_known(result.volume)) {
    object["place_mm"] = {{"first_pixel", slice.place->origin},
                          {"across", slice.place->across},
                          {"down", slice.place->down}};
  }
  return object;
}

/// "0.5 mm", or voxels of the level where nothing is known in mm.
std::string pixel_text(const DrawnSlice& slice, const SliceResult& result) {
  if (is_spacing_known(result.volume)) return number_text(slice.pixel_mm) + " mm";
  const Point3& spacing = result.geometry.spacing_mm;
  const double finest = *std::min_element(spacing.begin(), spacing.end());
  return number_text(slice.pixel_mm / finest) + (slice.pixel_mm == finest ? " voxel" : " voxels") +
         " (spacing not known)";
}

std::string position_text(const DrawnSlice& slice) {
  if (slice.plane) {
    return fmt::format("section through {} mm, normal {}", point_text(slice.plane->point_mm, ", "),
                       point_text(slice.plane->normal, ", "));
  }
  const char axis = "xyz"[slice.axis.value_or(2)];
  if (slice.indices.size() == 1) return fmt::format("slice {} = {}", axis, slice.indices.front());
  return fmt::format("{} slices {} = {} to {}", slice.indices.size(), axis, slice.indices.front(),
                     slice.indices.back());
}

std::string slice_text(const DrawnSlice& slice, const SliceResult& result) {
  std::string text =
      fmt::format("{}: {} x {} pixels of {}, {} of level {}", shown_path(slice.path),
                  slice.width, slice.height, pixel_text(slice, result), position_text(slice),
                  result.level);
  if (!slice.window) return text + "\n";
  const std::string unit = unit_of(result.volume);
  return text + fmt::format(", window {},{}{}\n", number_text(slice.window->center),
                            number_text(slice.window->width),
                            unit.empty() ? "" : " " + unit);
}

int run_slice(const SliceArguments& arguments, Context& context) {
  const SliceResult result = run_task(slice, options_of(arguments), context);
  std::string text;
  for (const DrawnSlice& one : result.pictures) text += slice_text(one, result);
  const auto one_json = [&](const DrawnSlice& one) { return slice_json(one, result); };
  print_result(context,
               {{"slices", json_list(result.pictures, one_json)},
                {"salvaged", salvaged_json(result.salvaged)}},
               text);
  return kExitDone;
}

void add_overlay_options(Verb verb, SliceArguments& arguments) {
  verb.add_list("--overlay FILE", arguments.overlays,
                "A mask, labels or grey values to draw above");
  verb.add_list("--overlay-as KIND", arguments.overlay_kinds, parse_overlay_kind,
                "outline, wash or isolines (default: outline of labels, isolines of grey values)")
      .check(one_word_of(all_words<OverlayKind>()));
  verb.add_list("--overlay-levels V,V,...", arguments.overlay_levels, parse_levels,
                "Values of isolines, or ends of a wash (default: round ones); or none");
  verb.add_list("--overlay-color COLOR", arguments.overlay_colors, parse_color,
                "A name, or #rrggbb");
  verb.add_list("--overlay-opacity F", arguments.overlay_opacities,
                "0 to 1 (default: 1, of a wash 0.4)")
      .check(number_within(0, 1));
}

void add_place_options(Verb verb, SliceArguments& arguments) {
  SliceOptions& options = arguments.options;
  Option axis = verb.add_parsed("--axis AXIS", options.axes, parse_axes,
                                "The axis the slice lies across: x, y, z or all")
                    .check(one_of({"x", "y", "z", "all"}))
                    .default_str("z");
  Option index =
      verb.add_option("--index N", options.index,
                      "Slice number on the level (default: the middle); not with --axis all");
  Option mm =
      verb.add_parsed("--mm MM", options.position_mm, parse_number,
                      "Slice position in mm (LPS); not with --axis all")
          .excludes(index);
  Option montage = verb.add_option("--montage CxR", arguments.montage, "Slices in one picture");
  Option every = verb.add_option("--every N", arguments.every, "Each N-th slice in one picture")
                     .check(whole_within(1));
  Option plane = verb.add_parsed("--plane POINT,NORMAL", options.plane, parse_plane,
                                 "An oblique plane in mm (LPS)");
  for (const Option& other : {axis, index, mm, montage, every}) plane.excludes(other);
  add_level(verb, options.level);
}

}  // namespace

void add_slice(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kSliceText, run_slice);
  SliceOptions& options = arguments.options;
  verb.add_input(options.input);
  verb.add_output(options.output, "The .png file to write");
  add_place_options(verb, arguments);
  verb.add_text("--window WINDOW", "CENTER,WIDTH, a preset or auto",
                [&made = options](const std::string& text, const std::string& option) {
                  take_window(text, option, made);
                })
      .default_str(std::string(kAutomatic));
  verb.add_option("--size N", options.minimum_side,
                  "Enlarge pictures smaller than this many pixels")
      .check(whole_within(1, 8192))
      .capture_default_str();
  add_label_option(verb, options.labels, "Draw this label alone");
  add_overlay_options(verb, arguments);
  add_lettering_flags(verb, options, "R L A P S I");
  verb.add_off_flag("--no-notes", options.has_notes, "Leave position, window and spacing out");
  add_salvage_option(verb, options.salvage);
}

}  // namespace octavo::cli
