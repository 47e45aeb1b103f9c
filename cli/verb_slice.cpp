// octavo slice: pictures of planes, for people.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/label_option.h"
#include "common/options.h"
#include "common/salvage_option.h"
#include "common/task_run.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/pictures/slice.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kSliceText = {
    "slice", "Draw slices and oblique sections as PNG pictures.",
    "Pixels are square whatever the spacing. The window is CENTER,WIDTH in real units, a preset\n"
    "in HU (brain, stroke, bone, lung, mediastinum, abdomen, liver) or auto; labels have colors\n"
    "and no window. --axis all writes NAME-x.png, NAME-y.png and NAME-z.png.\n\n"
    "--plane takes the section along any plane, in mm (LPS): X,Y,Z,NX,NY,NZ is a point and a\n"
    "normal, NX,NY,NZ a normal through the middle of the volume.\n"
    "--montage 4x3 draws 12 slices in one picture, --every 5 each fifth one; both together 12\n"
    "slices, 5 apart, around the middle or --index.\n\n"
    "--overlay draws another volume over the slices, where it lies in space: labels and masks as\n"
    "outline or wash, grey values as isolines or wash. It can be given several times; options of\n"
    "overlays are given once for all of them, or as often as overlays, in their order.\n"
    "--overlay-levels are the values of isolines, or the two ends of a wash.\n"
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
    "  octavo slice plan.8vo --overlay dose.8vo --overlay-levels 20,40,60 -o dose.png"};

struct SliceArguments {
  std::string input;
  std::string output;
  std::string axis = "z";
  std::string window = "auto";
  std::string mm;
  std::string plane;
  std::string montage;
  std::optional<std::int64_t> every;
  std::optional<std::int64_t> index;
  int level = 0;
  std::int64_t minimum_side = SliceOptions{}.minimum_side;
  std::vector<std::string> overlays;
  std::vector<std::string> overlay_kinds;
  std::vector<std::string> overlay_levels;
  std::vector<std::string> overlay_colors;
  std::vector<double> overlay_opacities;
  std::vector<std::string> labels;
  bool no_scale_bar = false;
  bool no_sides = false;
  bool no_notes = false;
  bool no_legend = false;
  SalvageArguments salvage;
};

std::string preset_names() {
  std::string names;
  for (const WindowPreset& preset : window_presets()) names += fmt::format("{}, ", preset.name);
  return names + "auto";
}

void take_window(const std::string& text, SliceOptions& options) {
  if (text == "auto") return;
  if (find_window_preset(text)) {
    options.window_preset = text;
    return;
  }
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 2) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--window: '{}'; expected CENTER,WIDTH or one of {}", escaped(text),
                            preset_names()));
  }
  options.window = Window{parse_number(parts[0], "--window"), parse_number(parts[1], "--window")};
  if (options.window->width > 0) return;
  throw Error(ErrorKind::invalid_argument, "--window: the width must be positive");
}

AskedPlane parse_plane(const std::string& text) {
  std::vector<double> numbers;
  for (const std::string& part : split(text, ',')) {
    numbers.push_back(parse_number(part, "--plane"));
  }
  if (numbers.size() == 3) return {std::nullopt, {numbers[0], numbers[1], numbers[2]}};
  if (numbers.size() == 6) {
    return {Point3{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
  }
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--plane: '{}'; expected X,Y,Z,NX,NY,NZ or NX,NY,NZ", escaped(text)));
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

/// The value of an overlay's option: its own, the one for all, or nothing.
template <class T>
const T* of_overlay(const std::vector<T>& values, std::size_t number) {
  if (values.empty()) return nullptr;
  return &values[values.size() == 1 ? 0 : number];
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
    if (const std::string* kind = of_overlay(arguments.overlay_kinds, i)) {
      overlay.look.kind = *kind == "outline" ? OverlayKind::outline
                          : *kind == "wash"  ? OverlayKind::wash
                                             : OverlayKind::isolines;
    }
    if (const std::string* levels = of_overlay(arguments.overlay_levels, i)) {
      for (const std::string& level : split(*levels, ',')) {
        overlay.look.levels.push_back(parse_number(level, "--overlay-levels"));
      }
    }
    if (const std::string* color = of_overlay(arguments.overlay_colors, i)) {
      overlay.look.color = find_color(*color);
      if (!overlay.look.color) {
        throw Error(ErrorKind::invalid_argument,
                    fmt::format("--overlay-color: '{}'; expected #rrggbb or one of {}",
                                escaped(*color), color_names()));
      }
    }
    if (const double* opacity = of_overlay(arguments.overlay_opacities, i)) {
      overlay.look.opacity = *opacity;
    }
  }
  return overlays;
}

SliceOptions options_of(const SliceArguments& arguments, const Context& context) {
  SliceOptions options;
  options.input = arguments.input;
  options.output = {arguments.output, context.force};
  options.axes = {0, 1, 2};
  if (arguments.axis != "all") {
    options.axes = {static_cast<int>(std::string("xyz").find(arguments.axis))};
  }
  options.level = arguments.level;
  options.index = arguments.index;
  if (!arguments.mm.empty()) options.position_mm = parse_number(arguments.mm, "--mm");
  if (!arguments.plane.empty()) options.plane = parse_plane(arguments.plane);
  options.montage = asked_montage(arguments);
  take_window(arguments.window, options);
  options.minimum_side = arguments.minimum_side;
  options.overlays = asked_overlays(arguments);
  options.labels = parse_labels(arguments.labels);
  options.has_scale_bar = !arguments.no_scale_bar;
  options.has_sides = !arguments.no_sides;
  options.has_notes = !arguments.no_notes;
  options.has_legend = !arguments.no_legend;
  options.salvage = salvage_filling(arguments.salvage);
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
                                   {"window", nullptr}};
  if (slice.axis) object["axis"] = std::string(1, "xyz"[*slice.axis]);
  if (slice.indices.size() == 1) object["index"] = slice.indices.front();
  if (slice.plane) {
    object["plane"] = {{"point_mm", slice.plane->point_mm}, {"normal", slice.plane->normal}};
  }
  if (slice.window) {
    object["window"] = {{"center", slice.window->center}, {"width", slice.window->width}};
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
      fmt::format("{}: {} x {} pixels of {}, {} of level {}", slice.path, slice.width, slice.height,
                  pixel_text(slice, result), position_text(slice), result.level);
  if (!slice.window) return text + "\n";
  const std::string unit = unit_of(result.volume);
  return text + fmt::format(", window {},{}{}\n", number_text(slice.window->center),
                            number_text(slice.window->width),
                            unit.empty() ? "" : " " + unit);
}

int run_slice(const SliceArguments& arguments, Context& context) {
  const SliceResult result = run_task(slice, options_of(arguments, context), context);
  nlohmann::ordered_json slices = nlohmann::ordered_json::array();
  for (const DrawnSlice& one : result.pictures) {
    if (context.json) slices.push_back(slice_json(one, result));
    else if (!context.quiet) print(slice_text(one, result));
  }
  if (context.json) {
    print_json({{"slices", slices},
                {"salvaged", salvaged_json(result.salvaged)},
                {"warnings", context.warnings}});
  }
  return kExitDone;
}

void add_overlay_options(Verb verb, SliceArguments& arguments) {
  verb.add_option("--overlay", arguments.overlays, "A mask, labels or grey values to draw above")
      ->type_name("FILE")
      ->allow_extra_args(false);
  verb.add_option("--overlay-as", arguments.overlay_kinds,
                  "outline, wash or isolines (default: outline of labels, isolines of grey values)")
      ->type_name("KIND")
      ->allow_extra_args(false)
      ->check(one_of({"outline", "wash", "isolines"}));
  verb.add_option("--overlay-levels", arguments.overlay_levels,
                  "Values of isolines, or ends of a wash (default: round ones)")
      ->type_name("V,V,...")
      ->allow_extra_args(false);
  verb.add_option("--overlay-color", arguments.overlay_colors, "A name, or #rrggbb")
      ->type_name("COLOR")
      ->allow_extra_args(false);
  verb.add_option("--overlay-opacity", arguments.overlay_opacities,
                  "0 to 1 (default: 1, of a wash 0.4)")
      ->type_name("F")
      ->allow_extra_args(false)
      ->check(number_within(0, 1));
}

void add_place_options(Verb verb, SliceArguments& arguments) {
  Option axis =
      verb.add_option("--axis", arguments.axis, "The axis the slice lies across: x, y, z or all");
  axis->type_name("AXIS")
      ->check(one_of({"x", "y", "z", "all"}))
      ->capture_default_str();
  Option index = verb.add_option("--index", arguments.index,
                                 "Slice number on the level (default: the middle)");
  index->type_name("N");
  Option mm = verb.add_option("--mm", arguments.mm, "Slice position in mm (LPS)");
  mm->type_name("MM")->excludes(index);
  Option montage = verb.add_option("--montage", arguments.montage, "Slices in one picture");
  montage->type_name("CxR");
  Option every = verb.add_option("--every", arguments.every, "Each N-th slice in one picture");
  every->type_name("N")->check(whole_within(1));
  verb.add_option("--plane", arguments.plane, "An oblique plane in mm (LPS)")
      ->type_name("POINT,NORMAL")
      ->excludes(axis)
      ->excludes(index)
      ->excludes(mm)
      ->excludes(montage)
      ->excludes(every);
  verb.add_option("--level", arguments.level, "Level of detail")
      ->type_name("K")
      ->capture_default_str();
}

}  // namespace

void add_slice(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<SliceArguments>();
  Verb verb = add_verb(app, context, kSliceText,
                       [arguments, &context] { return run_slice(*arguments, context); });
  verb.add_input(arguments->input);
  verb.add_output(arguments->output, "The .png file to write");
  add_place_options(verb, *arguments);
  verb.add_option("--window", arguments->window, "CENTER,WIDTH, a preset or auto")
      ->type_name("WINDOW")
      ->capture_default_str();
  verb.add_option("--size", arguments->minimum_side,
                  "Enlarge pictures smaller than this many pixels")
      ->type_name("N")
      ->check(whole_within(1, 8192))
      ->capture_default_str();
  add_label_option(verb, arguments->labels, "Draw this label alone");
  add_overlay_options(verb, *arguments);
  verb.add_flag("--no-scale-bar", arguments->no_scale_bar, "Leave the scale bar out");
  verb.add_flag("--no-sides", arguments->no_sides, "Leave the letters R L A P S I out");
  verb.add_flag("--no-notes", arguments->no_notes, "Leave position, window and spacing out");
  verb.add_flag("--no-legend", arguments->no_legend, "Leave the legend out");
  add_salvage_option(verb, arguments->salvage);
}

}  // namespace octavo::cli
