#include "text/volume_json.h"

#include <cmath>

#include "octavo/core/error.h"
#include "text/identity_words.h"
#include "text/quantities.h"

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

std::optional<double> number_in(const nlohmann::ordered_json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

/// The voxel that a number of the index stands for.
nlohmann::ordered_json voxel_json(const VolumeDescription& d, std::int64_t code) {
  if (is_integer(d.type)) return code;
  return d.voxel_of(code);
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

nlohmann::ordered_json if_in_mm(const VolumeDescription& volume,
                                const nlohmann::ordered_json& value_mm) {
  return is_spacing_known(metadata_of(volume)) ? value_mm : nlohmann::ordered_json(nullptr);
}

const char* kind_name(VolumeKind kind) { return kind == VolumeKind::labels ? "labels" : "grey"; }

std::string real_text(const VolumeDescription& description, const std::string& unit,
                      double stored) {
  const std::string number = number_text(description.rescale.to_real(stored));
  return unit.empty() ? number : number + " " + unit;
}

std::string distance_text(const VolumeDescription& description, const std::string& unit,
                          double stored) {
  const std::string number = number_text(stored * std::abs(description.rescale.slope));
  return unit.empty() ? number : number + " " + unit;
}

nlohmann::ordered_json coding_json(const std::optional<SampleCoding>& coding) {
  if (!coding) return nullptr;
  return {{"type", voxel_type_name(coding->type)},
          {"scale", coding->scale},
          {"offset", coding->offset}};
}

double source_max_error(const nlohmann::ordered_json& metadata) {
  return number_in(metadata, "source_max_error").value_or(0);
}

bool was_source_lossy(const nlohmann::ordered_json& metadata) {
  const auto mark = metadata.find("lossy_source");
  const bool is_marked = mark != metadata.end() && mark->is_boolean() && mark->get<bool>();
  return is_marked || source_max_error(metadata) > 0;
}

FloatRepair repair_of(const nlohmann::ordered_json& metadata) {
  FloatRepair repair;
  const auto coding = metadata.find("coding");
  if (coding == metadata.end() || !coding->is_object()) return repair;
  if (const auto nan = number_in(*coding, "nan")) repair.nan = static_cast<float>(*nan);
  if (const auto inf = number_in(*coding, "inf")) repair.infinity = static_cast<float>(*inf);
  return repair;
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
  const double slope = std::abs(d.rescale.slope);
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
          {"achieved_error", reader.achieved_error()},
          {"max_error_real", reader.max_error() * slope},
          {"achieved_error_real", reader.achieved_error() * slope},
          {"lossless", reader.max_error() == 0},
          {"source_lossy", was_source_lossy(metadata)},
          {"coding", coding_json(d.coding)},
          {"min", voxel_json(d, range.min)},
          {"max", voxel_json(d, range.max)},
          {"identity", identity_state(metadata)},
          {"metadata", metadata}};
}

}  // namespace octavo::cli
