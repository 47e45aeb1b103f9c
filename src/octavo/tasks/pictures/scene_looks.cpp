#include "octavo/tasks/pictures/scene_looks.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/ops/label/missing_labels.h"
#include "octavo/render/label_color.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/pictures/transfer_file.h"

namespace octavo {

namespace {

constexpr std::int64_t kHighestLabel = 65534;
constexpr double kUsualLabelOpacity = 0.25;
constexpr std::int64_t kMostLegendSamples = std::int64_t{1} << 21;
constexpr std::uint32_t kOwnColor = 0xff000000;

std::uint32_t packed_color(const Color& color) {
  return kOwnColor | static_cast<std::uint32_t>(color[2]) << 16 |
         static_cast<std::uint32_t>(color[1]) << 8 | color[0];
}

std::vector<std::uint32_t> labels_in(const FileReader& reader, const Box& box, int level) {
  std::vector<std::uint32_t> labels(static_cast<std::size_t>(box.size().voxel_count()));
  with_voxel_type(reader.description().type, [&](auto id) {
    using T = typename decltype(id)::type;
    std::vector<T> stored(labels.size());
    reader.read(box, level, stored.data());
    for (std::size_t i = 0; i < labels.size(); ++i) {
      labels[i] = static_cast<std::uint32_t>(stored[i]);
    }
  });
  return labels;
}

/// A share of the memory limit for what a label map keeps of its file.
std::shared_ptr<const FileReader> open_beside(const std::string& path, const LabelUse& use,
                                              const TaskContext& context) {
  TaskContext smaller = context;
  smaller.max_memory_bytes /= kLookShare / 2;  // half of which is the reader's
  return open_labels(path, smaller, use);
}

/// The same opacity and color for all values.
TransferFunction plain_function(const Color& color, double opacity) {
  return {{{0, color, opacity}}, std::nullopt, false, std::nullopt};
}

}  // namespace

SceneLabels::SceneLabels(const std::string& path, const FileReader& grey,
                         const std::string& grey_name, int level, const LabelUse& use,
                         const TaskContext& context)
    : reader_(open_beside(path, use, context)), size_(grey.levels().size(level)) {
  require_same_grid(grey.description(), grey_name, reader_->description(), path);
  const Levels& levels = reader_->levels();
  const auto is_fine_enough = [&](int at) {
    for (int axis = 0; axis < 3; ++axis) {
      if (levels.halving_count(at, axis) > grey.levels().halving_count(level, axis)) return false;
    }
    return true;
  };
  while (level_ + 1 < levels.count() && is_fine_enough(level_ + 1)) ++level_;
  for (int axis = 0; axis < 3; ++axis) {
    shift_[axis] =
        grey.levels().halving_count(level, axis) - levels.halving_count(level_, axis);
  }
}

void SceneLabels::read(const Box& box, std::vector<std::uint32_t>& out) const {
  if (shift_ == Size3{0, 0, 0}) {
    out = labels_in(*reader_, box, level_);
    return;
  }
  const Size3& have = reader_->levels().size(level_);
  Box finer;
  for (int axis = 0; axis < 3; ++axis) {
    finer.lo[axis] = box.lo[axis] << shift_[axis];
    finer.hi[axis] = std::min(box.hi[axis] << shift_[axis], have[axis]);
  }
  const std::vector<std::uint32_t> labels = labels_in(*reader_, finer, level_);
  const Size3 size = finer.size();
  const auto place = [&](int axis, std::int64_t at) {
    const std::int64_t middle = (at << shift_[axis]) + ((std::int64_t{1} << shift_[axis]) >> 1);
    return std::min(middle, have[axis] - 1) - finer.lo[axis];
  };
  out.clear();
  visit_cells(box, {1, 1, 1}, [&](const Index3& at) {
    const std::int64_t from =
        (place(2, at.z) * size.y + place(1, at.y)) * size.x + place(0, at.x);
    out.push_back(labels[static_cast<std::size_t>(from)]);
    return true;
  });
}

void SceneLabels::visit_ranges(
    const Box& box, const std::function<void(std::int64_t, std::int64_t)>& visit) const {
  const Levels& levels = reader_->levels();
  Box finer;
  for (int axis = 0; axis < 3; ++axis) {
    finer.lo[axis] = box.lo[axis] << shift_[axis];
    finer.hi[axis] =
        std::min(box.hi[axis] << shift_[axis], levels.size(level_)[axis]);
  }
  visit_cells(finer, brick_side_at(levels, level_), [&](const Index3& brick) {
    const ValueRange range = reader_->brick(Levels::tier_of(level_), brick).range;
    visit(range.min, range.max);
    return true;
  });
}

SceneLooks::SceneLooks(const RenderOptions& options, const FileReader& grey, int level,
                       const TaskContext& context) {
  if (!options.mask.empty()) {
    mask_ = std::make_unique<SceneLabels>(options.mask, grey, options.input, level, kAsMask,
                                          context);
  }
  if (options.label_map.empty()) {
    sets_ = {0, 1};
    begins_ = {-1, 0};
    colors_ = {0, 0};
    return;
  }
  labels_ = std::make_unique<SceneLabels>(options.label_map, grey, options.input, level, kAsLabels,
                                            context);
  set_looks(options);
}

void SceneLooks::set_looks(const RenderOptions& options) {
  const FileReader& reader = labels_->reader();
  const std::int64_t highest = reader.range().max;
  if (highest > kHighestLabel) {
    throw Error(ErrorKind::limit_exceeded,
                "has labels up to " + std::to_string(highest) + ", rays know those up to " +
                    std::to_string(kHighestLabel),
                options.label_map);
  }
  const auto count = static_cast<std::size_t>(highest) + 2;
  sets_.assign(count, 0);
  begins_.assign(count, -1);
  colors_.assign(count, 0);

  // What is asked for, by label.
  const LabelNames& names = reader.description().metadata.facts().labels;
  AskedLabelLook others;
  others.transfer = kSameTransfer;
  std::map<std::int64_t, AskedLabelLook> asked;
  for (const std::int64_t label : labels_of(options.labels, names, options.label_map)) {
    asked[label] = {};
  }
  const bool is_chosen = !asked.empty();
  for (const AskedLabelLook& look : options.label_looks) {
    if (look.labels.is_empty()) {
      others = look;
      continue;
    }
    for (const std::int64_t label : labels_of(look.labels, names, options.label_map)) {
      asked[label] = look;
    }
  }

  set(0, resolved(others, 0));
  for (std::int64_t label = 1; label <= highest; ++label) {
    const auto at = asked.find(label);
    const AskedLabelLook usual;
    set(label, resolved(at != asked.end() ? at->second : is_chosen ? others : usual, label));
  }
}

void SceneLooks::warn_of_missing(const RenderOptions& options, const TaskContext& context) const {
  if (!labels_) return;
  const FileReader& reader = labels_->reader();
  const LabelNames& names = reader.description().metadata.facts().labels;
  std::set<std::int64_t> asked;
  const auto add = [&](const AskedLabels& labels) {
    for (const std::int64_t label : labels_of(labels, names, options.label_map)) {
      asked.insert(label);
    }
  };
  add(options.labels);
  for (const AskedLabelLook& look : options.label_looks) {
    if (!look.labels.is_empty()) add(look.labels);
  }
  if (asked.empty()) return;
  const std::vector<std::int64_t> labels(asked.begin(), asked.end());
  std::vector<std::int64_t> missing;
  context.on_threads([&] { missing = missing_labels(reader, 0, labels, context.watcher()); });
  for (const std::int64_t label : missing) {
    context.warn(options.label_map + ": no voxel has " + label_words(names, label));
  }
}

SceneLooks::Resolved SceneLooks::resolved(const AskedLabelLook& asked, std::int64_t label) {
  if (asked.is_hidden) return {-1, 0};
  if (asked.transfer == kSameTransfer) return {};
  if (!asked.transfer.empty()) {
    TransferFunction function = read_transfer(asked.transfer);
    if (function.gradient) {
      throw Error(ErrorKind::invalid_argument,
                  "the look of a label has no gradient: that of the volume counts for all",
                  asked.transfer)
          .with_field("label_looks");
    }
    return {function_number(function), 0};
  }
  const LabelNames& names = labels_->reader().description().metadata.facts().labels;
  const Color color = asked.color.value_or(label_color(names, label));
  const TransferFunction function =
      plain_function(kBlack, asked.opacity.value_or(kUsualLabelOpacity));
  return {function_number(function), packed_color(color)};
}

std::int32_t SceneLooks::function_number(const TransferFunction& function) {
  const auto at = std::find(functions_.begin(), functions_.end(), function);
  if (at != functions_.end()) return static_cast<std::int32_t>(at - functions_.begin()) + 1;
  if (functions_.size() + 1 == kMostLookFunctions) {
    throw Error(ErrorKind::limit_exceeded,
                "labels have more than " + std::to_string(kMostLookFunctions - 1) +
                    " different opacities and transfer functions")
        .with_field("label_looks");
  }
  functions_.push_back(function);
  return static_cast<std::int32_t>(functions_.size());
}

void SceneLooks::set(std::int64_t label, const Resolved& look) {
  const auto at = static_cast<std::size_t>(label + 1);
  colors_[at] = look.color;
  if (look.function < 0) return;
  sets_[at] = LookSet{1} << look.function;
  begins_[at] = TransferTable::begin_of(static_cast<std::size_t>(look.function));
}

LookSet SceneLooks::within(const Box& box) const {
  if (mask_) {
    bool is_any = false;
    mask_->visit_ranges(box, [&](std::int64_t, std::int64_t highest) {
      is_any = is_any || highest > 0;
    });
    if (!is_any) return 0;
  }
  if (!labels_) return 1;
  LookSet all = 0;
  labels_->visit_ranges(box, [&](std::int64_t lowest, std::int64_t highest) {
    for (std::int64_t label = lowest; label <= highest; ++label) {
      all |= sets_[static_cast<std::size_t>(label + 1)];
    }
  });
  return all;
}

void SceneLooks::read(const Box& box, std::uint16_t* out) const {
  const auto count = static_cast<std::size_t>(box.size().voxel_count());
  std::vector<std::uint32_t> labels;
  std::fill_n(out, count, std::uint16_t{1});
  if (labels_) {
    labels_->read(box, labels);
    for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<std::uint16_t>(labels[i] + 1);
  }
  if (!mask_) return;
  mask_->read(box, labels);
  for (std::size_t i = 0; i < count; ++i) {
    if (labels[i] == 0) out[i] = 0;
  }
}

int SceneLooks::function_of(std::uint16_t look) const {
  const std::int32_t begin = begins_[look];
  return begin < 0 ? -1 : begin / TransferTable::begin_of(1);
}

Color SceneLooks::color_of(std::uint16_t look, const Color& otherwise) const {
  const std::uint32_t own = colors_[look];
  if (own == 0) return otherwise;
  return {static_cast<std::uint8_t>(own), static_cast<std::uint8_t>(own >> 8),
          static_cast<std::uint8_t>(own >> 16)};
}

std::vector<LegendRow> SceneLooks::legend() const {
  if (!labels_) return {};
  const FileReader& reader = labels_->reader();
  const Levels& levels = reader.levels();
  int level = 0;
  while (levels.size(level).voxel_count() > kMostLegendSamples) ++level;
  std::vector<std::int64_t> counts(sets_.size());
  for (const std::uint32_t label : labels_in(reader, box_of(levels.size(level)), level)) {
    ++counts[label + 1];
  }
  std::vector<std::size_t> seen;
  for (std::size_t look = 1; look < sets_.size(); ++look) {
    if (counts[look] > 0 && sets_[look] != 0 && colors_[look] != 0) seen.push_back(look);
  }
  std::stable_sort(seen.begin(), seen.end(),
                   [&](std::size_t a, std::size_t b) { return counts[a] > counts[b]; });
  const LabelNames& names = reader.description().metadata.facts().labels;
  std::vector<LegendRow> rows;
  for (const std::size_t look : seen) {
    rows.push_back({color_of(static_cast<std::uint16_t>(look), kBlack),
                    label_text(names, static_cast<std::int64_t>(look) - 1)});
  }
  return rows;
}

}  // namespace octavo
