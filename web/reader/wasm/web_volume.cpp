#include "web_volume.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "octavo/core/json_text.h"
#include "octavo/core/label_color.h"
#include "octavo/core/place_known.h"
#include "octavo/file/box_plan.h"

namespace octavo::web {

namespace {

/// Index pages beyond that are read one by one: a first picture does not wait for all of them.
constexpr std::uint64_t kMaxTailBytes = std::uint64_t{256} << 10;

ReaderOptions options_of(std::uint64_t cache_bytes) {
  ReaderOptions options;
  options.cache_bytes = cache_bytes;
  options.max_tail_bytes = kMaxTailBytes;
  options.lead_bytes = 0;  // the page decides what comes along
  return options;
}

Numbers numbers_of(const ReadPlan& plan) {
  Numbers numbers{static_cast<double>(plan.needed_bytes), plan.is_complete ? 1.0 : 0.0,
                  static_cast<double>(plan.ranges.size())};
  for (const ByteRange& range : plan.ranges) {
    numbers.push_back(static_cast<double>(range.offset));
    numbers.push_back(static_cast<double>(range.length));
  }
  return numbers;
}

std::array<std::int64_t, 3> list_of(const Size3& size) { return {size.x, size.y, size.z}; }

JsonObject level_json(const FileReader& reader, int level) {
  const Levels& levels = reader.levels();
  const VolumeDescription& volume = reader.description();
  const Geometry geometry = levels.geometry(volume.geometry, level);
  const Size3 side = brick_side_at(levels, level);
  const Size3 grid = levels.brick_grid(Levels::tier_of(level));
  std::array<std::int64_t, 3> factor{};
  for (int axis = 0; axis < 3; ++axis) {
    factor[static_cast<std::size_t>(axis)] = std::int64_t{1} << levels.halving_count(level, axis);
  }
  return JsonObject()
      .set("level", level)
      .set("size", list_of(levels.size(level)))
      .set("spacingMm", geometry.spacing_mm)
      .set("originMm", geometry.origin_mm)
      .set("factor", factor)
      .set("brickSide", list_of(side))
      .set("brickGrid", list_of(grid))
      .set("byteLength", reader.level_summary(level).bytes);
}

std::vector<JsonObject> labels_json(const LabelNames& names) {
  std::vector<JsonObject> list;
  for (const auto& [label, name] : names.all()) {
    list.push_back(JsonObject()
                       .set("label", label)
                       .set("name", names.text_of(label))
                       .set("color", name.color.value_or(label_color(label))));
  }
  return list;
}

}  // namespace

WebVolume::WebVolume(std::uint64_t size, std::string name)
    : source_(std::make_shared<SparseSource>(size, std::move(name))) {}

Numbers WebVolume::plan_opening() const {
  return numbers_of(plan_of_opening(*source_, options_of(0)));
}

void WebVolume::open(std::uint64_t cache_bytes) {
  reader_ = FileReader::open(source_, options_of(cache_bytes));
  file_ = std::make_unique<OpenFile>(source_, options_of(0));
}

std::string WebVolume::description() const {
  const VolumeDescription& volume = reader_->description();
  std::vector<JsonObject> levels;
  for (int level = 0; level < reader_->levels().count(); ++level) {
    levels.push_back(level_json(*reader_, level));
  }
  std::array<char, 17> build_id{};
  std::snprintf(build_id.data(), build_id.size(), "%016llx",
                static_cast<unsigned long long>(reader_->build_id()));
  const ValueRange range = reader_->range();
  return JsonObject()
      .set("buildId", build_id.data())
      .set("formatVersion", reader_->format_version())
      .set("kind", volume.kind == VolumeKind::labels ? "labels" : "grey")
      .set("type", voxel_type_name(volume.type))
      .set("size", list_of(volume.size))
      .set("levels", levels)
      .set("spacingMm", volume.geometry.spacing_mm)
      .set("originMm", volume.geometry.origin_mm)
      .set("direction", volume.geometry.direction)
      .set("isSpacingKnown", volume.metadata.is_spacing_known())
      .set("isPlaceKnown", is_place_known(volume))
      .set("slope", volume.rescale.slope)
      .set("intercept", volume.rescale.intercept)
      .set("unit", volume.metadata.unit())
      .set("min", volume.voxel_of(range.min))
      .set("max", volume.voxel_of(range.max))
      .set("maxError", reader_->max_error())
      .set("detailLevel", reader_->detail_level())
      .set("labels", labels_json(volume.metadata.facts().labels))
      .text();
}

Numbers WebVolume::plan_pages(const Box& box, int level) const {
  ReadPlan plan;
  const int tier = Levels::tier_of(level);
  visit_cells(box, brick_side_at(file_->levels(), level), [&](const Index3& brick) {
    const std::size_t page = file_->page_of(tier, brick);
    if (!file_->has_page(tier, page)) plan.ranges.push_back(file_->page_range(tier, page));
    return true;
  });
  plan.ranges = joined(source_->missing(plan.ranges), kNoGaps);
  plan.needed_bytes = total_bytes(plan.ranges);
  return numbers_of(plan);
}

Numbers WebVolume::plan_box(const Box& box, int level) const {
  Numbers numbers = numbers_of(plan_of_boxes(*file_, {&box, 1}, level, kNoGaps, nullptr));
  const int tier = Levels::tier_of(level);
  std::int64_t count = 0;
  std::int64_t uniform_count = 0;
  visit_cells(box, brick_side_at(file_->levels(), level), [&](const Index3& brick) {
    ++count;
    const bool is_known = file_->has_page(tier, file_->page_of(tier, brick));
    if (is_known && file_->entry_at(tier, brick).is_uniform()) ++uniform_count;
    return true;
  });
  numbers.push_back(static_cast<double>(count));
  numbers.push_back(static_cast<double>(uniform_count));
  return numbers;
}

void WebVolume::brick_ranges(const Box& bricks, int level, double* min, double* max) const {
  const VolumeDescription& volume = file_->description();
  const int tier = Levels::tier_of(level);
  visit_cells(bricks, {1, 1, 1}, [&](const Index3& brick) {
    const ValueRange range = file_->entry_at(tier, brick).range;
    *min++ = volume.voxel_of(range.min);
    *max++ = volume.voxel_of(range.max);
    return true;
  });
}

Numbers WebVolume::missing(const ByteRange& range) const {
  ReadPlan plan;
  plan.ranges = source_->missing({&range, 1});
  plan.needed_bytes = total_bytes(plan.ranges);
  return numbers_of(plan);
}

Numbers WebVolume::plan_thumbnail() const {
  const PartEntry* const part = file_->find_part(kThumbnailTag);
  return part == nullptr ? missing({}) : missing({part->bytes.offset, part->bytes.length});
}

}  // namespace octavo::web
