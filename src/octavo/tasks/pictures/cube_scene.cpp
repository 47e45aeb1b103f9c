// The scenes of modes cubes and surface.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/ops/label/label_masks.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/ops/mask/shell.h"
#include "octavo/render/cubes/cube_picture.h"
#include "octavo/render/cubes/relief_picture.h"
#include "octavo/render/label_color.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/pictures/render_scene.h"
#include "octavo/tasks/pictures/scene_light.h"

namespace octavo {

namespace {

constexpr Color kIvory = {244, 232, 206};
constexpr double kUsualFade = 0.5;

struct NamedColor {
  const char* name;
  Color color;
};

constexpr NamedColor kTissueColors[] = {{"air", {150, 190, 235}},    {"lung", {215, 165, 175}},
                                        {"fat", {240, 205, 110}},    {"soft", {205, 110, 90}},
                                        {"contrast", {220, 50, 50}}, {"bone", kIvory}};

Color tissue_color(const std::string& name) {
  for (const NamedColor& tissue : kTissueColors) {
    if (name == tissue.name) return tissue.color;
  }
  return kIvory;
}

/// A mask, its color and what the legend says of it.
struct ScenePart {
  MaskTree tree;
  Color color{};
  std::string name;
  ReliefRange range;  ///< of its stored values, where it is one of a grey volume
  std::uint64_t voxels = 0;
};

class CubeScene final : public RenderScene {
 public:
  CubeScene(std::shared_ptr<const FileReader> reader, std::vector<ScenePart> parts,
            const RenderOptions& options, const TaskContext& context)
      : reader_(std::move(reader)),
        parts_(std::move(parts)),
        options_(options),
        context_(context),
        is_smooth_(shade_of(options) == RenderShade::smooth),
        kept_(box_of(reader_->levels().size(options.level.value_or(0)))),
        shown_(kept_) {}

  bool is_empty() const {
    return std::all_of(parts_.begin(), parts_.end(),
                       [](const ScenePart& part) { return part.tree.voxel_count() == 0; });
  }

  /// Keeps what lies in a box.
  void cut(const Box& kept) {
    kept_ = kept;
    context_.on_threads([&] {
      for (ScenePart& part : parts_) {
        part.tree = combine(part.tree, box_mask(part.tree.size(), kept), SetOperation::intersect);
      }
    });
  }

  /// Cuts boxes out, in samples of the level.
  void remove(const std::vector<Box>& boxes) {
    context_.on_threads([&] {
      for (ScenePart& part : parts_) {
        for (const Box& box : boxes) {
          part.tree =
              combine(part.tree, box_mask(part.tree.size(), box), SetOperation::subtract);
        }
      }
    });
  }

  void grow_to(std::int64_t planes) override {
    // What ends by itself has no face there.
    kept_.hi.z = planes < shown_.hi.z ? planes : whole_end_;
    context_.on_threads([&] {
      for (std::size_t i = 0; i < parts_.size(); ++i) {
        MaskTree cut =
            combine(grown_[i], box_mask(grown_[i].size(), kept_), SetOperation::intersect);
        if (!whole_.empty()) whole_[i] = cut;
        parts_[i].tree =
            options_.mode == RenderMode::surface ? shell(cut) : std::move(cut);
      }
    });
  }

  /// Counts the leaves, and drops the hidden ones where only the surface is drawn.
  void finish() {
    const auto start = std::chrono::steady_clock::now();
    set_shown();
    counts_.masks = static_cast<std::int64_t>(parts_.size());
    for (ScenePart& part : parts_) {
      counts_.leaves += leaf_count(part.tree);
      part.voxels = part.tree.voxel_count();
    }
    whole_end_ = kept_.hi.z;
    if (options_.is_growing) {
      for (const ScenePart& part : parts_) grown_.push_back(part.tree);
    }
    counts_.drawn = counts_.leaves;
    if (options_.mode != RenderMode::surface) return;
    // A relief is that of whole masks.
    if (is_smooth_) {
      for (const ScenePart& part : parts_) whole_.push_back(part.tree);
    }
    context_.on_threads([&] {
      for (ScenePart& part : parts_) part.tree = shell(part.tree);
    });
    counts_.drawn = 0;
    for (const ScenePart& part : parts_) counts_.drawn += leaf_count(part.tree);
    counts_.shell_seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  Box shown() const override { return shown_; }

  Box fitted() const override {
    Box voxels;
    for (int axis = 0; axis < 3; ++axis) {
      const int halvings = reader_->levels().halving_count(options_.level.value_or(0), axis);
      voxels.lo[axis] = shown_.lo[axis] << halvings;
      voxels.hi[axis] = shown_.hi[axis] << halvings;
    }
    return intersection(voxels, kept_box(options_.cuts, *reader_, 0));
  }

  Picture draw(const View& view, const Color& background) override {
    const Picture picture = drawn_on(view, background);
    warn_of_nothing(picture, view, background);
    return picture;
  }

  std::vector<LegendRow> legend() const override {
    std::vector<LegendRow> rows;
    if (parts_.size() < 2) return rows;
    // The largest first: of many labels not all have room.
    std::vector<const ScenePart*> sorted;
    for (const ScenePart& part : parts_) sorted.push_back(&part);
    if (reader_->description().kind == VolumeKind::labels) {
      std::stable_sort(sorted.begin(), sorted.end(),
                       [](const auto* a, const auto* b) { return a->voxels > b->voxels; });
    }
    for (const ScenePart* part : sorted) rows.push_back({part->color, part->name});
    return rows;
  }

  RenderCounts counts() const override { return counts_; }

 private:
  /// What the masks fill; the whole level where they are empty.
  void set_shown() {
    Box filled;
    for (const ScenePart& part : parts_) filled = united(filled, bounding_box(part.tree));
    if (!filled.is_empty()) shown_ = filled;
  }

  Picture drawn_on(const View& view, const Color& background) const {
    std::vector<PaintedMask> masks;
    for (const ScenePart& part : parts_) masks.push_back({&part.tree, part.color});
    const CubeStyle style{background, options_.fade.value_or(kUsualFade), shown_,
                          true};
    Picture picture;
    context_.on_threads([&] {
      if (is_smooth_) {
        picture = draw_relief(masks, view, style, *relief(), kept_);
      } else if (options_.mode == RenderMode::surface) {
        picture = draw_nearest_cubes(masks, view, style);
      } else {
        picture = draw_cubes(masks, view, style);
      }
    });
    return picture;
  }

  static bool is_all_of(const Color& background, const Picture& picture) {
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      if (picture.pixels[i] != background[i % background.size()]) return false;
    }
    return true;
  }

  /// Of cubes that are there, once for all pictures of a series.
  void warn_of_nothing(const Picture& picture, const View& view, const Color& background) {
    if (is_nothing_told_ || counts_.leaves == 0 || !is_all_of(background, picture)) return;
    is_nothing_told_ = true;
    // Cubes in the color of the background are seen on another one.
    Color other = background;
    for (std::uint8_t& channel : other) channel = static_cast<std::uint8_t>(channel ^ 128);
    const bool is_seen = !is_all_of(other, drawn_on(view, other));
    context_.warn(options_.input +
                  (is_seen ? ": the voxels have the color of the background; nothing shows"
                           : ": no voxel is seen; the picture is empty"));
  }

  std::unique_ptr<ReliefField> relief() const {
    if (reader_->description().kind == VolumeKind::grey) {
      std::vector<ReliefRange> ranges;
      for (const ScenePart& part : parts_) ranges.push_back(part.range);
      return grey_relief(*reader_, options_.level.value_or(0), std::move(ranges));
    }
    std::vector<const MaskTree*> masks;
    for (const MaskTree& tree : whole_) masks.push_back(&tree);
    if (masks.empty()) {
      for (const ScenePart& part : parts_) masks.push_back(&part.tree);
    }
    return mask_relief(masks);
  }

  std::shared_ptr<const FileReader> reader_;
  std::vector<ScenePart> parts_;
  std::vector<MaskTree> whole_;  // with the hidden leaves, where those are dropped
  std::vector<MaskTree> grown_;  // before they are cut to what has grown
  const RenderOptions& options_;
  const TaskContext& context_;
  bool is_smooth_;
  Box kept_;
  Box shown_;
  std::int64_t whole_end_ = 0;  // of what is kept, along z
  RenderCounts counts_;
  bool is_nothing_told_ = false;
};

std::vector<ScenePart> label_parts(const FileReader& reader, const RenderOptions& options,
                              const TaskContext& context) {
  std::vector<ValueWindow> windows;
  for (const AskedLook& look : options.ranges) {
    windows.push_back(stored_window(look.range, reader.description(), false));
  }
  const LabelNames& names = reader.description().metadata.facts().labels;
  const std::vector<std::int64_t> asked = labels_of(options.labels, names, options.input);
  for (const std::int64_t label : asked) {
    windows.push_back({static_cast<double>(label), static_cast<double>(label)});
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (windows.empty()) windows.push_back({-kInfinity, kInfinity});
  std::vector<LabelMask> masks;
  Progress& progress = context.watcher();
  const int level = options.level.value_or(0);
  const ProgressScope scope(progress, "labels", reader.levels().size(level).z, "planes");
  context.on_threads([&] {
    masks = masks_of_labels(reader, level, windows, progress, context.max_memory_bytes);
  });
  for (const std::int64_t label : asked) {
    const bool is_there = std::any_of(masks.begin(), masks.end(),
                                      [&](const LabelMask& mask) { return mask.label == label; });
    if (!is_there) context.warn(options.input + ": no voxel has " + label_words(names, label));
  }
  const bool is_mask = masks.size() == 1 && masks.front().label == 1 && names.is_empty();
  const auto color_of = [&](std::int64_t label) {
    for (std::size_t i = 0; i < options.ranges.size(); ++i) {
      const std::optional<Color>& color = options.ranges[i].color;
      if (color && windows[i].contains(static_cast<double>(label))) return *color;
    }
    return is_mask ? kIvory : label_color(names, label);
  };
  std::vector<ScenePart> parts;
  for (LabelMask& mask : masks) {
    parts.push_back({.tree = std::move(mask.tree),
                     .color = color_of(mask.label),
                     .name = label_text(names, mask.label),
                     .range = {}});
  }
  return parts;
}

std::vector<ScenePart> range_parts(const FileReader& reader, const RenderOptions& options,
                              const TaskContext& context) {
  const VolumeDescription& volume = reader.description();
  std::vector<ScenePart> parts;
  const auto add = [&](const AskedRange& range, const Color& color, const std::string& name) {
    const ValueWindow window = stored_window(range, volume, false);
    MaskTree tree = read_mask(reader, options.level.value_or(0), {&window, 1}, context);
    context.on_threads([&] {
      for (const ScenePart& part : parts) tree = combine(tree, part.tree, SetOperation::subtract);
    });
    parts.push_back({.tree = std::move(tree),
                     .color = color,
                     .name = name,
                     .range = {window.lowest, window.highest}});
  };
  const bool is_one = options.ranges.size() + options.tissues.size() == 1;
  for (const std::string& name : options.tissues) {
    add(tissue_range(name), tissue_color(name), name);
  }
  std::int64_t number = 0;
  for (const AskedLook& look : options.ranges) {
    const Color usual = is_one ? kIvory : label_color(++number);
    add(look.range, look.color.value_or(usual), look_text(look, volume));
  }
  return parts;
}

}  // namespace

void require_cube_scene(const FileReader& reader, const RenderOptions& options) {
  const VolumeDescription& volume = reader.description();
  const bool is_labels = volume.kind == VolumeKind::labels;
  if (!is_labels && !options.labels.is_empty()) {
    throw Error(ErrorKind::invalid_argument, "holds grey values, not labels", options.input)
        .with_field("labels.range");
  }
  if (!is_labels && options.ranges.empty() && options.tissues.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "holds grey values; cubes are drawn of those in a range", options.input)
        .with_field("ranges");
  }
  labels_of(options.labels, volume.metadata.facts().labels, options.input);
  kept_box(options.cuts, reader, options.level.value_or(0));
  removed_boxes(options, reader);
}

std::unique_ptr<RenderScene> make_cube_scene(const std::shared_ptr<const FileReader>& reader,
                                             const RenderOptions& options,
                                             const TaskContext& context) {
  require_cube_scene(*reader, options);
  const bool is_labels = reader->description().kind == VolumeKind::labels;
  const Box whole = box_of(reader->levels().size(options.level.value_or(0)));
  const Box kept = kept_box(options.cuts, *reader, options.level.value_or(0));
  std::vector<ScenePart> parts =
      is_labels ? label_parts(*reader, options, context) : range_parts(*reader, options, context);
  auto scene = std::make_unique<CubeScene>(reader, std::move(parts), options, context);
  const bool held_voxels = !scene->is_empty();
  if (kept != whole) scene->cut(kept);
  scene->remove(removed_boxes(options, *reader));
  scene->finish();
  if (scene->counts().leaves == 0) {
    context.warn(options.input + (held_voxels
                                      ? ": the cuts leave no voxel; the picture is empty"
                                      : ": no voxel is drawn; the picture is empty"));
  }
  return scene;
}

std::vector<Box> removed_boxes(const RenderOptions& options, const FileReader& reader) {
  const Levels& levels = reader.levels();
  std::vector<Box> removed;
  for (const AskedBox& asked : options.removed) {
    const Box box = box_within(asked, levels.size(0));
    removed.push_back(box_at_level(box, levels, options.level.value_or(0)));
  }
  return removed;
}

Box kept_box(const std::vector<AskedCut>& cuts, const FileReader& reader, int level) {
  const Levels& levels = reader.levels();
  Box kept = box_of(levels.size(level));
  for (const AskedCut& cut : cuts) {
    const std::int64_t voxels = cut.axis >= 0 && cut.axis < 3 ? levels.size(0)[cut.axis] : 0;
    if (cut.index < 0 || cut.index >= voxels) {
      throw Error(ErrorKind::invalid_argument,
                  voxels == 0 ? "a cut lies across axis 0, 1 or 2"
                              : fmt::format("a cut at {} = {}; it runs from 0 to {}",
                                            "xyz"[cut.axis], cut.index, voxels - 1))
          .with_field("cuts");
    }
    const int halvings = levels.halving_count(level, cut.axis);
    if (cut.keeps_below) {
      const std::int64_t end = ((cut.index - 1) >> halvings) + 1;
      kept.hi[cut.axis] = std::min(kept.hi[cut.axis], cut.index == 0 ? 0 : end);
    } else {
      kept.lo[cut.axis] = std::max(kept.lo[cut.axis], (cut.index + 1) >> halvings);
    }
  }
  if (!kept.is_empty()) return kept;
  throw Error(ErrorKind::invalid_argument, "the cuts leave no voxel of the volume")
      .with_field("cuts");
}

}  // namespace octavo
