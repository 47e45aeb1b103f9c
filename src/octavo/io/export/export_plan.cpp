#include "octavo/io/export/export_plan.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "octavo/core/checked.h"
#include "octavo/core/place_known.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/source/value_unit.h"

namespace octavo {

namespace {

std::string box_text(const Box& box) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) text += ", ";
    text += std::to_string(box.lo[axis]) + ":" + std::to_string(box.hi[axis]);
  }
  return text;
}

Box chosen_box(const Levels& levels, const ExportOptions& options) {
  if (options.level < 0 || options.level >= levels.count()) {
    throw Error(ErrorKind::invalid_argument, "level " + std::to_string(options.level) +
                                                 "; this file has levels 0 to " +
                                                 std::to_string(levels.count() - 1));
  }
  const Box whole = box_of(levels.size(options.level));
  const Box box = options.box.value_or(whole);
  if (box.is_empty())
    throw Error(ErrorKind::invalid_argument, "box " + box_text(box) + " is empty");
  if (!whole.contains(box)) {
    throw Error(ErrorKind::invalid_argument, "box " + box_text(box) + " is not inside level " +
                                                 std::to_string(options.level) + ", which is " +
                                                 box_text(whole));
  }
  return box;
}

std::optional<std::int64_t> small_integer(double value) {
  constexpr double kLargest = 1 << 30;
  if (!(std::abs(value) <= kLargest) || value != std::nearbyint(value)) return {};
  return static_cast<std::int64_t>(value);
}

/// The integers that slope and intercept are, when they are integers and the slope is not 0.
std::optional<IntegerMap> integer_map(const Rescale& rescale) {
  const auto factor = small_integer(rescale.slope);
  const auto offset = small_integer(rescale.intercept);
  if (!factor || !offset || *factor == 0) return {};
  return IntegerMap{*factor, *offset};
}

bool fits(const ValueRange& range, VoxelType type) {
  const ValueRange limits = value_range(type);
  return range.min >= limits.min && range.max <= limits.max;
}

/// The stored type where the real values fit it, else the smallest of the common types that holds
/// them.
std::optional<VoxelType> integer_type_for(const ValueRange& range, VoxelType stored_type) {
  for (const VoxelType type :
       {stored_type, VoxelType::int16, VoxelType::uint16, VoxelType::int32, VoxelType::uint32}) {
    if (fits(range, type)) return type;
  }
  return {};
}

/// Turns the plan to real values where integers can hold them exactly; false when they cannot.
bool plan_real_integers(ExportPlan& plan, const ValueRange& stored) {
  if (!is_integer(plan.stored_type) || !fits(stored, plan.stored_type)) return false;
  const auto map = integer_map(plan.rescale);
  if (!map) return false;
  const std::int64_t a = stored.min * map->factor + map->offset;
  const std::int64_t b = stored.max * map->factor + map->offset;
  const auto type = integer_type_for({std::min(a, b), std::max(a, b)}, plan.stored_type);
  if (!type) return false;
  plan.type = *type;
  plan.map = *map;
  plan.rescale = Rescale{};
  return true;
}

/// Turns the plan to real values as float32.
void plan_real_floats(ExportPlan& plan) {
  if (plan.kind == VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument, "labels are names, which have no real values")
        .with_field("values");
  }
  plan.applied = plan.rescale;
  plan.type = VoxelType::float32;
  plan.rescale = Rescale{};
}

bool is_nifti(ExportFormat format) {
  return format == ExportFormat::nifti || format == ExportFormat::nifti_gz;
}

/// Chooses the type and the meaning of the numbers that are written.
void plan_values(ExportPlan& plan, ExportFormat format, ExportValues values,
                 const ValueRange& stored) {
  if (values == ExportValues::real) plan_real_floats(plan);
  const bool may_map = values == ExportValues::exact && format != ExportFormat::raw;
  plan.real_units = plan.rescale.is_identity() ||
                    (may_map && (plan_real_integers(plan, stored) || is_nifti(format)));
}

}  // namespace

std::uint64_t ExportPlan::plane_bytes() const {
  return checked_mul(static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y),
                     static_cast<std::uint64_t>(bytes_per_voxel(type)), "bytes of a plane");
}

std::uint64_t ExportPlan::voxel_bytes() const {
  return checked_mul(plane_bytes(), static_cast<std::uint64_t>(size.z), "bytes of the export");
}

ExportPlan plan_export(const FileReader& reader, ExportFormat format,
                       const ExportOptions& options) {
  const VolumeDescription& description = reader.description();
  ExportPlan plan;
  plan.kind = description.kind;
  plan.level = options.level;
  plan.box = chosen_box(reader.levels(), options);
  plan.size = plan.box.size();
  plan.geometry = cropped(reader.levels().geometry(description.geometry, plan.level), plan.box.lo);
  plan.stored_type = plan.type = description.type;
  plan.rescale = description.rescale;
  plan.spacing_known = description.metadata.is_spacing_known();
  plan.place_known = is_place_known(description);
  plan.overwrite = options.overwrite;
  plan.unit = shown_unit(description.metadata.unit());
  plan_values(plan, format, options.values, reader.range());
  return plan;
}

ExportLimits export_limits(const FileReader& reader, ExportFormat format,
                           const ExportOptions& options) {
  const ExportPlan plan = plan_export(reader, format, options);
  const bool is_nrrd = format == ExportFormat::nrrd;
  const bool is_meta =
      format == ExportFormat::meta_image || format == ExportFormat::meta_image_detached;
  ExportLimits limits;
  limits.claims_spacing =
      !plan.spacing_known && (is_nifti(format) || is_meta || (is_nrrd && plan.place_known));
  limits.claims_place = !plan.place_known && is_meta;
  limits.loses_box_start = !plan.place_known && is_nifti(format) && plan.box.lo != Index3{};
  limits.hides_rescale = !plan.real_units && options.values == ExportValues::exact &&
                         format != ExportFormat::raw;
  return limits;
}

void require_free(Storage& storage, const std::string& path, bool overwrite) {
  if (base_name_of(path).size() > kMaxNameBytes) {
    throw Error(ErrorKind::io, "its name is longer than 255 bytes", path);
  }
  const PathType type = storage.path_type(path);
  if (type == PathType::missing) return;
  if (type != PathType::file)
    throw Error(ErrorKind::io, "is not a file; choose another name", path);
  if (!overwrite) throw Error(ErrorKind::io, "exists already", path).with_field("overwrite");
}

}  // namespace octavo
