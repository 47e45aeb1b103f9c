// The scenes of render --mode cubes and --mode surface.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "common/masks.h"
#include "common/progress_line.h"
#include "common/render_scene.h"
#include "octavo/core/error.h"
#include "octavo/ops/label/label_masks.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/ops/mask/shell.h"
#include "octavo/render/cubes/cube_picture.h"
#include "octavo/render/label_color.h"
#include "octavo/tasks/value_ranges.h"
#include "text/quantities.h"
#include "text/value_range_words.h"

namespace octavo::cli {

namespace {

constexpr Color kIvory = {244, 232, 206};
constexpr std::size_t kMostLegendRows = 24;
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
struct Part {
  MaskTree tree;
  Color color{};
  std::string name;
};

class CubeScene final : public RenderScene {
 public:
  CubeScene(std::vector<Part> parts, const Box& whole, const RenderArguments& arguments,
            const Context& context)
      : parts_(std::move(parts)),
        context_(context),
        is_surface_(arguments.mode == "surface"),
        fade_(arguments.fade.value_or(kUsualFade)),
        shown_(whole) {}

  /// Keeps what lies in a box.
  void cut(const Box& kept) {
    on_threads(context_, [&] {
      for (Part& part : parts_) {
        part.tree = combine(part.tree, box_mask(part.tree.size(), kept), SetOperation::intersect);
      }
    });
  }

  /// Counts the leaves, and drops the hidden ones where only the surface is drawn.
  void finish() {
    const auto start = std::chrono::steady_clock::now();
    set_shown();
    for (const Part& part : parts_) leaves_ += leaf_count(part.tree);
    drawn_ = leaves_;
    if (!is_surface_) return;
    on_threads(context_, [&] {
      for (Part& part : parts_) part.tree = shell(part.tree);
    });
    drawn_ = 0;
    for (const Part& part : parts_) drawn_ += leaf_count(part.tree);
    shell_seconds_ =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  Box shown() const override { return shown_; }

  Picture draw(const View& view, const Color& background) const override {
    std::vector<PaintedMask> masks;
    for (const Part& part : parts_) masks.push_back({&part.tree, part.color});
    Picture picture;
    const auto draw = is_surface_ ? draw_nearest_cubes : draw_cubes;
    on_threads(context_, [&] { picture = draw(masks, view, {background, fade_, shown_}); });
    return picture;
  }

  std::vector<LegendRow> legend() const override {
    std::vector<LegendRow> rows;
    if (parts_.size() < 2 || parts_.size() > kMostLegendRows) return rows;
    for (const Part& part : parts_) rows.push_back({part.color, part.name});
    return rows;
  }

  nlohmann::ordered_json counts_json() const override {
    nlohmann::ordered_json counts = {{"masks", parts_.size()},
                                     {"leaves", leaves_},
                                     {"drawn", drawn_},
                                     {"removed", leaves_ - drawn_}};
    if (is_surface_) counts["shell_seconds"] = shell_seconds_;
    return counts;
  }

  std::string counts_text() const override {
    if (!is_surface_) return counted_text(leaves_, "leaf", "leaves");
    const std::int64_t removed = leaves_ - drawn_;
    const double share =
        leaves_ == 0 ? 0 : 100 * static_cast<double>(removed) / static_cast<double>(leaves_);
    return fmt::format("{} of {} leaves, {} hidden ones removed ({:.1f} %)", count_text(drawn_),
                       count_text(leaves_), count_text(removed), share);
  }

 private:
  /// What the masks fill; the whole level where they are empty.
  void set_shown() {
    Box filled;
    for (const Part& part : parts_) filled = united(filled, bounding_box(part.tree));
    if (!filled.is_empty()) shown_ = filled;
  }

  std::vector<Part> parts_;
  const Context& context_;
  bool is_surface_;
  double fade_;
  Box shown_;
  std::int64_t leaves_ = 0;
  std::int64_t drawn_ = 0;
  double shell_seconds_ = 0;
};

std::vector<Part> label_parts(const FileReader& reader, const RenderArguments& arguments,
                              const Context& context) {
  std::vector<ValueWindow> windows;
  for (const std::string& text : arguments.ranges) {
    windows.push_back(stored_window(parse_range(text, "--range"), reader.description(), false));
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (windows.empty()) windows.push_back({-kInfinity, kInfinity});
  std::vector<LabelMask> masks;
  ProgressLine progress(context);
  const ProgressScope scope(progress, "labels", reader.levels().size(arguments.level).z, "planes");
  on_threads(context, [&] {
    masks = masks_of_labels(reader, arguments.level, windows, progress, context.max_memory_bytes);
  });
  std::vector<Part> parts;
  const bool is_mask = masks.size() == 1 && masks.front().label == 1;
  for (LabelMask& mask : masks) {
    parts.push_back({std::move(mask.tree), is_mask ? kIvory : label_color(mask.label),
                     std::to_string(mask.label)});
  }
  return parts;
}

std::vector<Part> range_parts(const FileReader& reader, const RenderArguments& arguments,
                              const Context& context) {
  const VolumeDescription& volume = reader.description();
  std::vector<Part> parts;
  const auto add = [&](const AskedRange& range, const Color& color, const std::string& name) {
    const ValueWindow window = stored_window(range, volume, false);
    MaskTree tree = read_mask(reader, arguments.level, {window}, context);
    on_threads(context, [&] {
      for (const Part& part : parts) tree = combine(tree, part.tree, SetOperation::subtract);
    });
    parts.push_back({std::move(tree), color, name});
  };
  const bool is_one = arguments.ranges.size() + arguments.tissues.size() == 1;
  for (const std::string& name : arguments.tissues) {
    add(tissue_range(name, volume, arguments.input), tissue_color(name), name);
  }
  std::int64_t number = 0;
  for (const std::string& text : arguments.ranges) {
    add(parse_range(text, "--range"), is_one ? kIvory : label_color(++number), text);
  }
  return parts;
}

}  // namespace

std::unique_ptr<RenderScene> make_cube_scene(const std::shared_ptr<const FileReader>& reader,
                                             const RenderArguments& arguments, Context& context) {
  const VolumeDescription& volume = reader->description();
  for (const std::string& text : arguments.ranges) parse_range(text, "--range");
  for (const std::string& name : arguments.tissues) tissue_range(name, volume, arguments.input);
  const bool is_labels = volume.kind == VolumeKind::labels;
  if (!is_labels && arguments.ranges.empty() && arguments.tissues.empty()) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("holds grey values; --mode {} draws those in a range: give --range "
                            "LOW:HIGH or --tissue NAME",
                            arguments.mode),
                arguments.input);
  }
  const Box whole = box_of(reader->levels().size(arguments.level));
  const Box kept = kept_box(arguments.cuts, *reader, arguments.level);
  std::vector<Part> parts = is_labels ? label_parts(*reader, arguments, context)
                                      : range_parts(*reader, arguments, context);
  auto scene = std::make_unique<CubeScene>(std::move(parts), whole, arguments, context);
  if (kept != whole) scene->cut(kept);
  scene->finish();
  if (scene->counts_json()["leaves"] == 0) {
    context.warn(arguments.input + (arguments.cuts.empty()
                                        ? ": no voxel is drawn; the picture is empty"
                                        : ": the cuts leave no voxel; the picture is empty"));
  }
  return scene;
}

Box kept_box(const std::vector<std::string>& cuts, const FileReader& reader, int level) {
  const Levels& levels = reader.levels();
  Box kept = box_of(levels.size(level));
  for (const std::string& text : cuts) {
    const std::size_t axis = text.empty() ? std::string::npos : std::string("xyz").find(text[0]);
    const bool is_plane =
        axis != std::string::npos && text.size() > 2 && (text[1] == '<' || text[1] == '>');
    if (!is_plane) {
      throw Error(ErrorKind::invalid_argument,
                  fmt::format("--cut: '{}'; expected AXIS<INDEX or AXIS>INDEX, as in 'x<120'",
                              escaped(text)));
    }
    const std::int64_t index = parse_integer(text.substr(2), "--cut");
    const auto a = static_cast<int>(axis);
    const std::int64_t voxels = levels.size(0)[a];
    if (index < 0 || index >= voxels) {
      throw Error(ErrorKind::invalid_argument, fmt::format("--cut: '{}'; {} runs from 0 to {}",
                                                           escaped(text), text[0], voxels - 1));
    }
    const int halvings = levels.halving_count(level, a);
    if (text[1] == '<') {
      const std::int64_t end = ((index - 1) >> halvings) + 1;
      kept.hi[a] = std::min(kept.hi[a], index == 0 ? 0 : end);
    } else {
      kept.lo[a] = std::max(kept.lo[a], (index + 1) >> halvings);
    }
  }
  if (!kept.is_empty()) return kept;
  throw Error(ErrorKind::invalid_argument, "--cut: the planes leave no voxel of the volume");
}

}  // namespace octavo::cli
