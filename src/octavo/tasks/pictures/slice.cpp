#include "octavo/tasks/pictures/slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/place_known.h"
#include "octavo/core/text.h"
#include "octavo/render/color_scale.h"
#include "octavo/render/slice/montage.h"
#include "octavo/tasks/files/finite_voxels.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/range_words.h"
#include "octavo/tasks/volume_facts.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

namespace {

constexpr std::uint64_t kBytesPerPixel = 26;

[[noreturn]] void reject_slice(const std::string& what, const char* field) {
  throw Error(ErrorKind::invalid_argument, what).with_field(field);
}

/// Options that contradict each other, whatever the volume.
void check_slice(const SliceOptions& options) {
  if (!options.on_picture) require_png(options.output.path);
  const bool has_position = options.index || options.position_mm;
  if (options.axes.empty()) reject_slice("no axis is asked for", "axes");
  for (const int axis : options.axes) {
    if (axis >= 0 && axis < 3) continue;
    reject_slice("a slice lies across axis 0, 1 or 2, not " + std::to_string(axis), "axes");
  }
  if (options.index && options.position_mm) {
    reject_slice("a slice has a number or a position, not both", "index");
  }
  if (options.axes.size() > 1 && has_position) {
    reject_slice("a number or a position goes with one axis, not with several", "axes");
  }
  if (options.plane && (has_position || options.montage || options.axes.size() > 1)) {
    reject_slice("an oblique plane goes without a number, a position, a montage and several axes",
                 "plane");
  }
  if (options.window && !options.window_preset.empty()) {
    reject_slice("a window has numbers or a name, not both", "window");
  }
  if (!options.montage) return;
  const AskedMontage& montage = *options.montage;
  if (montage.columns.has_value() != montage.rows.has_value() ||
      (!montage.columns && !montage.every)) {
    reject_slice("a montage needs its columns and rows, or a step between slices", "montage");
  }
  if (has_position && !(montage.columns && montage.every)) {
    reject_slice("a position goes with a montage whose columns, rows and step are all given",
                 "montage");
  }
}

/// The asked window; nothing for an automatic one. Rejects one that the volume cannot be shown in.
std::optional<Window> asked_window(const SliceOptions& options, const VolumeDescription& volume,
                                   const TaskContext& context) {
  const bool is_asked = options.window || !options.window_preset.empty();
  if (is_asked && volume.kind == VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument,
                "a window goes with grey values; this file holds labels, which have colors",
                options.input)
        .with_field("window");
  }
  if (options.window_preset.empty()) return options.window;
  const auto preset = find_window_preset(options.window_preset);
  if (!preset)
    reject_slice("no window is called " + escaped(options.window_preset), "window_preset");
  require_hu(volume, options.input, "the window " + options.window_preset, context,
             "window_preset");
  return preset;
}

/// The slice nearest to a position along an axis of the grid, in mm of its dominant body axis.
std::int64_t index_at_mm(const FileReader& reader, const SliceOptions& options, int axis) {
  const Geometry g = reader.levels().geometry(reader.description().geometry, options.level);
  const Size3& size = reader.levels().size(options.level);
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
  const double spacing = g.spacing_mm[static_cast<std::size_t>(axis)];
  const double first = g.to_world(middle)[row];
  const double last = first + step(row) * spacing * static_cast<double>(size[axis] - 1);
  const double index = std::round((*options.position_mm - first) / (step(row) * spacing));
  if (index >= 0 && index < static_cast<double>(size[axis])) {
    return static_cast<std::int64_t>(index);
  }
  OutsideWords words =
      outside_words(*options.position_mm, std::min(first, last), std::max(first, last));
  if (last < first) std::swap(words.lowest, words.highest);
  throw Error(ErrorKind::invalid_argument,
              fmt::format("no slice lies at {} mm; slices across {} run from {} to {} mm",
                          words.value, "xyz"[axis], words.lowest, words.highest))
      .with_field("position_mm");
}

CutPlane plane_of(const AskedPlane& asked, const FileReader& reader) {
  if (asked.point_mm) return {*asked.point_mm, asked.normal};
  const VolumeDescription& volume = reader.description();
  Point3 middle{};
  for (int a = 0; a < 3; ++a) {
    middle[static_cast<std::size_t>(a)] = static_cast<double>(volume.size[a] - 1) / 2;
  }
  return {volume.geometry.to_world(middle), asked.normal};
}

/// The labels to draw of the label maps above a grey volume. A name counts where it is known; one
/// that none of them knows is an error.
void choose_labels(std::vector<Overlay>& overlays, const SliceOptions& options) {
  const auto is_labels = [](const Overlay& overlay) {
    return overlay.reader->description().kind == VolumeKind::labels;
  };
  if (std::none_of(overlays.begin(), overlays.end(), is_labels)) {
    throw Error(ErrorKind::invalid_argument,
                "holds grey values, and no label map is drawn over them", options.input)
        .with_field("labels.kind");
  }
  std::vector<std::string> unknown = options.labels.names;
  for (std::size_t i = 0; i < overlays.size(); ++i) {
    if (!is_labels(overlays[i])) continue;
    const LabelNames names = overlays[i].reader->description().metadata.facts().labels;
    AskedLabels known = {options.labels.numbers, {}};
    for (const auto& [label, entry] : names.all()) {
      const std::vector<std::string>& asked = options.labels.names;
      if (std::find(asked.begin(), asked.end(), entry.name) == asked.end()) continue;
      known.names.push_back(entry.name);
      std::erase(unknown, entry.name);
    }
    overlays[i].kept = labels_of(known, names, options.overlays[i].path);
  }
  const auto first = std::find_if(overlays.begin(), overlays.end(), is_labels);
  labels_of({{}, unknown}, {},
            options.overlays[static_cast<std::size_t>(first - overlays.begin())].path);
}

/// Lines of the first overlay of grey values have a color for each value; those of another have one
/// of its own, and all are named.
void tell_isolines_apart(std::vector<Overlay>& overlays) {
  std::vector<Overlay*> lines;
  for (Overlay& overlay : overlays) {
    if (*overlay.look.kind == OverlayKind::isolines) lines.push_back(&overlay);
  }
  if (lines.size() < 2) return;
  for (Overlay* const one : lines) {
    one->is_named = true;
    if (one != lines.front() && !one->look.color) one->look.color = overlay_color(one->number);
  }
}

/// The volumes above the slices, and what is to be said of them.
std::vector<Overlay> opened_overlays(const SliceOptions& options, const FileReader& reader,
                                     const TaskContext& context) {
  std::vector<Overlay> overlays;
  bool has_grey = false;
  for (const AskedOverlay& asked : options.overlays) {
    Overlay overlay;
    overlay.reader = open_volume(asked.path, context);
    const VolumeDescription& volume = overlay.reader->description();
    overlay.look = asked.look;
    if (volume.kind == VolumeKind::grey) {
      has_grey = true;
      if (overlay.look.levels.empty()) overlay.look.levels = options.overlay_levels;
    }
    overlay.labels = volume.metadata.facts().labels;
    overlay.name = std::filesystem::path(asked.path).stem().string();
    overlay.unit = unit_of(volume);
    overlay.number = overlays.size();
    warn_of_unknown_spacing(reader.description(), options.input, volume, asked.path, context);
    try {
      overlays.push_back(decided(std::move(overlay)));
    } catch (const Error& error) {
      throw error.with_path(asked.path);
    }
  }
  if (!has_grey && !options.overlay_levels.empty()) {
    reject_slice("levels are of grey values, and no overlay holds any", "overlays.levels");
  }
  tell_isolines_apart(overlays);
  return overlays;
}

/// One picture, from its options to its pixels.
struct Drawing {
  std::string path;
  SlicePictureOptions options;
  SlicePicture picture;
};

std::vector<std::int64_t> montage_indices(const SliceOptions& options, const FileReader& reader,
                                          int axis, std::int64_t middle) {
  const AskedMontage& montage = *options.montage;
  const std::int64_t end = reader.levels().size(options.level)[axis];
  const std::int64_t step = montage.every.value_or(1);
  if (!montage.columns) {
    return spaced_slices(end, step >= 1 ? (end - 1) / step + 1 : 1, step, end / 2);
  }
  if (*montage.columns < 1 || *montage.rows < 1 || *montage.columns > end || *montage.rows > end) {
    reject_slice(fmt::format("{} x {} slices of {}", *montage.columns, *montage.rows, end),
                 "montage.size");
  }
  const std::int64_t count = *montage.columns * *montage.rows;
  return montage.every ? spaced_slices(end, count, step, middle) : spread_slices(end, count);
}

/// The slices of one axis, or the plane.
void choose_sections(SlicePictureOptions& look, const SliceOptions& options,
                     const FileReader& reader, int axis) {
  if (options.plane) {
    look.plane = plane_of(*options.plane, reader);
    return;
  }
  const Size3& size = reader.levels().size(options.level);
  look.axis = axis;
  std::int64_t index = options.index.value_or(size[axis] / 2);
  if (options.position_mm) index = index_at_mm(reader, options, axis);
  look.indices = {index};
  if (!options.montage) return;
  look.indices = montage_indices(options, reader, axis, index);
  const PlaneSection cell = axis_section(
      reader.levels().geometry(reader.description().geometry, options.level), size, axis, 0, 1);
  look.columns = options.montage->columns.value_or(
      montage_columns(static_cast<std::int64_t>(look.indices.size()), cell.width, cell.height));
}

std::vector<Drawing> planned(const SliceOptions& options, const FileReader& reader,
                             const TaskContext& context) {
  const VolumeDescription& volume = reader.description();
  if (options.position_mm || options.plane) {
    require_known_spacing(volume, options.input,
                          options.plane ? "a plane in mm" : "a position in mm",
                          options.plane ? "" : "the number of a slice");
  }
  SlicePictureOptions look;
  look.level = options.level;
  look.window = asked_window(options, volume, context);
  look.minimum_side = options.minimum_side;
  look.labels = volume.metadata.facts().labels;
  look.captions = {options.has_scale_bar, options.has_sides,        options.has_notes,
                   options.has_legend,    is_spacing_known(volume), is_place_known(volume),
                   unit_of(volume)};
  look.overlays = opened_overlays(options, reader, context);
  if (!options.labels.is_empty()) {
    if (volume.kind == VolumeKind::grey) choose_labels(look.overlays, options);
    else look.kept_labels = labels_of(options.labels, look.labels, options.input);
  }
  std::vector<Drawing> drawings;
  for (const int axis : options.axes) {
    Drawing& drawing = drawings.emplace_back();
    drawing.path = options.output.path;
    if (options.axes.size() > 1 && !options.on_picture) {
      drawing.path.insert(drawing.path.size() - 4, fmt::format("-{}", "xyz"[axis]));
    }
    if (!options.on_picture) {
      require_free({drawing.path, options.output.overwrite});
      require_no_input(drawing.path, {options.input});
    }
    drawing.options = look;
    choose_sections(drawing.options, options, reader, axis);
    const auto pixels = static_cast<std::uint64_t>(slice_pixels(reader, drawing.options));
    context.require_memory(pixels * kBytesPerPixel, "the picture");
  }
  return drawings;
}

DrawnSlice told(const Drawing& drawing, VolumeKind kind) {
  DrawnSlice slice;
  slice.path = drawing.path;
  if (!drawing.options.plane) slice.axis = drawing.options.axis;
  slice.plane = drawing.options.plane;
  slice.place = drawing.picture.place;
  slice.indices = drawing.picture.indices;
  slice.width = drawing.picture.picture.width;
  slice.height = drawing.picture.picture.height;
  slice.pixel_mm = drawing.picture.pixel_mm;
  if (kind == VolumeKind::grey) slice.window = drawing.picture.window;
  return slice;
}

/// An overlay that lies elsewhere is most likely not what was meant.
void warn_of_unmet_overlays(const SliceOptions& options, const std::vector<Drawing>& drawings,
                            const TaskContext& context) {
  for (std::size_t i = 0; i < options.overlays.size(); ++i) {
    const bool is_met = std::any_of(drawings.begin(), drawings.end(), [&](const Drawing& one) {
      return one.picture.overlay_pixels[i] > 0;
    });
    if (is_met) continue;
    context.warn(fmt::format("{}: lies beside what is drawn of {}", options.overlays[i].path,
                             options.input));
  }
}

/// So are labels that lie in other slices.
void warn_of_unmet_labels(const SliceOptions& options, const std::vector<Drawing>& drawings,
                          const TaskContext& context) {
  if (options.labels.is_empty()) return;
  const bool is_met = std::any_of(drawings.begin(), drawings.end(), [](const Drawing& one) {
    return one.picture.label_pixels > 0;
  });
  if (!is_met) context.warn(options.input + ": none of the labels asked for lies in what is drawn");
}

/// Nothing can be seen of a volume that holds no number.
void warn_of_nothing(const SliceOptions& options, const FileReader& reader,
                     const TaskContext& context) {
  if (reader.description().kind == VolumeKind::labels || has_finite_voxels(reader)) return;
  context.warn(options.input + ": every voxel is NaN or infinite; nothing of it is drawn");
}

}  // namespace

SliceResult slice(const SliceOptions& options, const TaskContext& context) {
  check_slice(options);
  const auto reader = salvaging(open_volume(options.input, context), options.salvage, context);
  require_level(reader->levels(), options.level);
  std::vector<Drawing> drawings = planned(options, *reader, context);

  // Draw all before the first is written: damage leaves nothing behind.
  read_salvaging(options.salvage, context, [&] {
    for (Drawing& drawing : drawings) {
      if (context.watcher().is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      context.on_threads([&] { drawing.picture = render_slice(*reader, drawing.options); });
    }
  });
  warn_of_unmet_overlays(options, drawings, context);
  warn_of_unmet_labels(options, drawings, context);
  warn_of_nothing(options, *reader, context);

  SliceResult result;
  result.volume = reader->description();
  result.geometry = reader->levels().geometry(result.volume.geometry, options.level);
  result.level = options.level;
  PictureFiles files(context, options.on_picture);
  for (const Drawing& drawing : drawings) {
    files.add(drawing.path, drawing.picture.picture);
    result.pictures.push_back(told(drawing, result.volume.kind));
  }
  files.publish(options.output.overwrite);
  warn_of_salvaged(*reader, context);
  result.salvaged = salvage_report(*reader);
  return result;
}

}  // namespace octavo
