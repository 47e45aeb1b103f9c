// octavo slice: pictures of planes, for people.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/cancel.h"
#include "common/failure.h"
#include "common/masks.h"
#include "common/options.h"
#include "common/salvage_option.h"
#include "common/task_run.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/file/storage/storage.h"
#include "octavo/io/source/place_known.h"
#include "octavo/render/slice/slice_picture.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/outputs.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "slice", "Draw a slice as a PNG picture.",
    "Pixels are square whatever the spacing. The window is CENTER,WIDTH in real units, a preset\n"
    "in HU (brain, stroke, bone, lung, mediastinum, abdomen, liver) or auto; labels have colors\n"
    "and no window. --axis all writes NAME-x.png, NAME-y.png and NAME-z.png.\n\n"
    "Examples:\n"
    "  octavo slice head.8vo -o head.png --window brain\n"
    "  octavo slice head.8vo --axis x --mm -12.5 --window 300,1500 -o side.png\n"
    "  octavo slice head.8vo --axis all --level 2 -o preview.png"};

struct Arguments {
  std::string input;
  std::string output;
  std::string axis = "z";
  std::string window = "auto";
  std::string mm;
  std::optional<std::int64_t> index;
  int level = 0;
  std::int64_t minimum_side = SlicePictureOptions{}.minimum_side;
  bool no_scale_bar = false;
  bool no_sides = false;
  SalvageArguments salvage;
};

struct DrawnSlice {
  std::string path;
  int axis = 2;
  std::int64_t index = 0;
  SlicePicture slice;
};

std::string preset_names() {
  std::string names;
  for (const WindowPreset& preset : window_presets()) names += fmt::format("{}, ", preset.name);
  return names + "auto";
}

std::optional<Window> parse_window(const std::string& text) {
  if (text == "auto") return std::nullopt;
  if (const auto preset = find_window_preset(text)) return preset;
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 2) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--window: '{}'; expected CENTER,WIDTH or one of {}", escaped(text),
                            preset_names()));
  }
  const Window window = {parse_number(parts[0], "--window"), parse_number(parts[1], "--window")};
  if (window.width > 0) return window;
  throw Error(ErrorKind::invalid_argument, "--window: the width must be positive");
}

/// The asked window; nothing for auto. Rejects one that the volume cannot be shown in.
std::optional<Window> asked_window(const Arguments& arguments, const VolumeDescription& volume) {
  const std::optional<Window> window = parse_window(arguments.window);
  if (window && volume.kind == VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument,
                "--window goes with grey values; this file holds labels, which have colors",
                arguments.input);
  }
  const std::string unit = unit_of(volume);
  if (find_window_preset(arguments.window) && !unit.empty() && unit != "HU") {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--window {}: the presets are in HU, and this volume is in {}; give "
                            "CENTER,WIDTH or auto",
                            arguments.window, unit),
                arguments.input);
  }
  return window;
}

/// The slice nearest to a position along an axis of the grid, in mm of its dominant body axis.
std::int64_t index_at_mm(const FileReader& reader, const Arguments& arguments, int axis) {
  const Geometry g = reader.levels().geometry(reader.description().geometry, arguments.level);
  const Size3& size = reader.levels().size(arguments.level);
  std::size_t row = 0;
  const auto step = [&](std::size_t r) {
    return g.direction[r * 3 + static_cast<std::size_t>(axis)];
  };
  for (std::size_t r = 1; r < 3; ++r) {
    if (std::abs(step(r)) > std::abs(step(row))) row = r;
  }
  // Along the line through the middle of the volume.
  Point3 middle{};
  for (int a = 0; a < 3; ++a) {
    middle[static_cast<std::size_t>(a)] = a == axis ? 0 : static_cast<double>(size[a] - 1) / 2;
  }
  const double asked = parse_number(arguments.mm, "--mm");
  const double spacing = g.spacing_mm[static_cast<std::size_t>(axis)];
  const double first = g.to_world(middle)[row];
  const double last = first + step(row) * spacing * static_cast<double>(size[axis] - 1);
  const double index = std::round((asked - first) / (step(row) * spacing));
  if (index >= 0 && index < static_cast<double>(size[axis]))
    return static_cast<std::int64_t>(index);
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--mm {}: no slice there; slices across {} run from {} to {} mm",
                          arguments.mm, "xyz"[axis], number_text(first), number_text(last)));
}

DrawnSlice draw(const FileReader& reader, const Arguments& arguments, int axis,
                const Context& context) {
  const VolumeDescription& d = reader.description();
  SlicePictureOptions options;
  options.axis = axis;
  options.level = arguments.level;
  options.indices = {
      arguments.index.value_or(reader.levels().size(arguments.level)[axis] / 2)};
  if (!arguments.mm.empty()) {
    require_known_spacing(d, arguments.input, "--mm", "--index");
    options.indices = {index_at_mm(reader, arguments, axis)};
  }
  options.window = asked_window(arguments, d);
  options.captions.has_scale_bar = !arguments.no_scale_bar;
  options.captions.has_sides = !arguments.no_sides;
  options.captions.is_spacing_known = is_spacing_known(d);
  options.captions.is_place_known = is_place_known(d);
  options.captions.unit = unit_of(d);
  options.minimum_side = arguments.minimum_side;
  DrawnSlice drawn{arguments.output, axis, options.indices.front(), {}};
  on_threads(context, [&] { drawn.slice = render_slice(reader, options); });
  return drawn;
}

void write_png(const DrawnSlice& drawn, bool overwrite) {
  const Bytes png = encode_png(drawn.slice.picture);
  PendingFile file(local_storage(), drawn.path);
  file.append(png);
  file.seal();
  file.publish(overwrite);
}

nlohmann::ordered_json slice_json(const DrawnSlice& drawn, int level,
                                  const VolumeDescription& volume) {
  const SlicePicture& s = drawn.slice;
  nlohmann::ordered_json object = {{"output", drawn.path},
                                   {"axis", std::string(1, "xyz"[drawn.axis])},
                                   {"index", drawn.index},
                                   {"level", level},
                                   {"width", s.picture.width},
                                   {"height", s.picture.height},
                                   {"pixel_mm", if_in_mm(volume, s.pixel_mm)},
                                   {"window", nullptr}};
  if (volume.kind == VolumeKind::grey) {
    object["window"] = {{"center", s.window.center}, {"width", s.window.width}};
  }
  return object;
}

/// "0.5 mm", or voxels of the level where nothing is known in mm.
std::string pixel_text(const DrawnSlice& drawn, int level, const FileReader& reader) {
  const VolumeDescription& d = reader.description();
  const double side = drawn.slice.pixel_mm;
  if (is_spacing_known(d)) return number_text(side) + " mm";
  const Point3 spacing = reader.levels().geometry(d.geometry, level).spacing_mm;
  const double finest = *std::min_element(spacing.begin(), spacing.end());
  return number_text(side / finest) + (side == finest ? " voxel" : " voxels") +
         " (spacing not known)";
}

std::string slice_text(const DrawnSlice& drawn, int level, const FileReader& reader) {
  const SlicePicture& s = drawn.slice;
  std::string text =
      fmt::format("{}: {} x {} pixels of {}, slice {} = {} of level {}", drawn.path,
                  s.picture.width, s.picture.height, pixel_text(drawn, level, reader),
                  "xyz"[drawn.axis], drawn.index, level);
  if (reader.description().kind == VolumeKind::labels) return text + "\n";
  const std::string unit = unit_of(reader.description());
  return text + fmt::format(", window {} to {}{}\n",
                            number_text(s.window.center - s.window.width / 2),
                            number_text(s.window.center + s.window.width / 2),
                            unit.empty() ? "" : " " + unit);
}

std::vector<int> chosen_axes(const Arguments& arguments) {
  if (arguments.axis == "all") return {0, 1, 2};
  return {static_cast<int>(std::string("xyz").find(arguments.axis))};
}

int run_slice(const Arguments& arguments, Context& context) {
  const std::vector<int> axes = chosen_axes(arguments);
  if (!arguments.output.ends_with(".png")) {
    throw Error(ErrorKind::invalid_argument, "a slice is written as .png", arguments.output);
  }
  if (axes.size() > 1 && (arguments.index || !arguments.mm.empty())) {
    throw Error(ErrorKind::invalid_argument, "--index and --mm go with one --axis, not with all");
  }
  const TaskRun run(context);
  const std::optional<SalvageFilling> filling = salvage_filling(arguments.salvage);
  const auto reader =
      salvaging(open_volume(arguments.input, run.context()), filling, run.context());
  check_level(reader->levels(), arguments.level);
  std::vector<Arguments> pictures;
  for (const int axis : axes) {
    Arguments& one = pictures.emplace_back(arguments);
    if (axes.size() > 1) {
      one.output.insert(one.output.size() - 4, fmt::format("-{}", "xyz"[axis]));
    }
    require_free({one.output, context.force});
  }
  // All are drawn before the first is written: damage leaves nothing behind.
  std::vector<DrawnSlice> drawn;
  read_salvaging(filling, run.context(), [&] {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      drawn.push_back(draw(*reader, pictures[i], axes[i], context));
    }
  });
  nlohmann::ordered_json slices = nlohmann::ordered_json::array();
  // Until all are written, a signal must not leave temporary files behind.
  for (const DrawnSlice& one : drawn) {
    if (is_cancel_requested()) throw Error(ErrorKind::cancelled, "stopped while writing", one.path);
    write_png(one, context.force);
    if (context.json) {
      slices.push_back(slice_json(one, arguments.level, reader->description()));
    } else if (!context.quiet) {
      print(slice_text(one, arguments.level, *reader));
    }
  }
  warn_of_salvaged(*reader, run.context());
  if (context.json) {
    print_json({{"slices", slices}, {"salvaged", salvaged_json(salvage_report(*reader))}});
  }
  return kExitDone;
}

}  // namespace

void add_slice(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_slice(*arguments, context); });
  verb.add_option("file", arguments->input, "An .8vo file or a URL of one")
      ->type_name("FILE")
      ->required();
  verb.add_option("-o,--output", arguments->output, "The .png file to write")
      ->type_name("FILE")
      ->required();
  verb.add_option("--axis", arguments->axis, "The axis the slice lies across: x, y, z or all")
      ->type_name("AXIS")
      ->check(one_of({"x", "y", "z", "all"}))
      ->capture_default_str();
  Option index = verb.add_option("--index", arguments->index,
                                       "Slice number on the level (default: the middle)");
  index->type_name("N");
  verb.add_option("--mm", arguments->mm, "Slice position in mm (LPS)")
      ->type_name("MM")
      ->excludes(index);
  verb.add_option("--level", arguments->level, "Level of detail")
      ->type_name("K")
      ->capture_default_str();
  verb.add_option("--window", arguments->window, "CENTER,WIDTH, a preset or auto")
      ->type_name("WINDOW")
      ->capture_default_str();
  verb.add_option("--size", arguments->minimum_side,
                  "Enlarge pictures smaller than this many pixels")
      ->type_name("N")
      ->check(whole_within(1, 8192))
      ->capture_default_str();
  verb.add_flag("--no-scale-bar", arguments->no_scale_bar, "Leave the scale bar out");
  verb.add_flag("--no-sides", arguments->no_sides, "Leave the letters R L A P S I out");
  add_salvage_option(verb, arguments->salvage);
}

}  // namespace octavo::cli
