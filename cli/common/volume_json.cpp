#include "common/volume_json.h"

#include "common/quantities.h"

namespace octavo::cli {

namespace {

nlohmann::ordered_json level_json(const FileReader& reader, int level) {
  const Levels& levels = reader.levels();
  const Size3& size = levels.size(level);
  const LevelSummary summary = reader.level_summary(level);
  return {{"level", level},
          {"size", {size.x, size.y, size.z}},
          {"spacing_mm", levels.geometry(reader.description().geometry, level).spacing_mm},
          {"bricks", summary.bricks},
          {"uniform_bricks", summary.uniform_bricks},
          {"bytes", summary.bytes}};
}

}  // namespace

nlohmann::ordered_json metadata_of(const VolumeDescription& description) {
  auto metadata = nlohmann::ordered_json::parse(description.metadata_json, nullptr, false);
  if (!metadata.is_object()) metadata = {{"unreadable", description.metadata_json}};
  return metadata;
}

std::string unit_of(const nlohmann::ordered_json& metadata) {
  const auto unit = metadata.find("unit");
  return unit != metadata.end() && unit->is_string() ? escaped(unit->get<std::string>()) : "";
}

bool is_spacing_known(const nlohmann::ordered_json& metadata) {
  const auto known = metadata.find("spacing_known");
  return known == metadata.end() || !known->is_boolean() || known->get<bool>();
}

bool is_unplaced(const VolumeDescription& description, const nlohmann::ordered_json& metadata) {
  const auto known = metadata.find("place_known");
  if (known != metadata.end() && known->is_boolean()) return !known->get<bool>();
  return description.geometry.origin_mm == Point3{} &&
         description.geometry.direction == Geometry{}.direction && !metadata.contains("dicom");
}

const char* kind_name(VolumeKind kind) { return kind == VolumeKind::labels ? "labels" : "grey"; }

std::uint64_t raw_bytes_of(const VolumeDescription& description) {
  return static_cast<std::uint64_t>(description.size.voxel_count() *
                                    bytes_per_voxel(description.type));
}

std::string real_text(const VolumeDescription& description, const std::string& unit,
                      double stored) {
  const std::string number = number_text(description.rescale.to_real(stored));
  return unit.empty() ? number : number + " " + unit;
}

nlohmann::ordered_json file_json(const FileReader& reader) {
  const VolumeDescription& d = reader.description();
  const std::uint64_t raw_bytes = raw_bytes_of(d);
  const auto file_bytes = static_cast<double>(reader.file_bytes());
  const ValueRange range = reader.range();
  nlohmann::ordered_json levels = nlohmann::ordered_json::array();
  for (int level = 0; level < reader.levels().count(); ++level) {
    levels.push_back(level_json(reader, level));
  }
  const nlohmann::ordered_json metadata = metadata_of(d);
  return {{"file", reader.source().name()},
          {"format_version", reader.format_version()},
          {"kind", kind_name(d.kind)},
          {"type", voxel_type_name(d.type)},
          {"size", {d.size.x, d.size.y, d.size.z}},
          {"spacing_mm", d.geometry.spacing_mm},
          {"spacing_known", is_spacing_known(metadata)},
          {"origin_mm", d.geometry.origin_mm},
          {"direction", d.geometry.direction},
          {"rescale", {{"slope", d.rescale.slope}, {"intercept", d.rescale.intercept}}},
          {"levels", levels},
          {"file_bytes", reader.file_bytes()},
          {"raw_bytes", raw_bytes},
          {"ratio", static_cast<double>(raw_bytes) / file_bytes},
          {"bits_per_voxel", file_bytes * 8 / static_cast<double>(d.size.voxel_count())},
          {"max_error", reader.max_error()},
          {"min", range.min},
          {"max", range.max},
          {"metadata", metadata}};
}

}  // namespace octavo::cli
