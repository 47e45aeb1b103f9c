#include "octavo/tasks/volume_facts.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "octavo/core/error.h"
#include "octavo/core/text.h"

namespace octavo {

namespace {

using Json = nlohmann::ordered_json;

Json metadata_of(const VolumeDescription& volume) {
  Json metadata = Json::parse(volume.metadata_json, nullptr, false);
  return metadata.is_object() ? metadata : Json::object();
}

std::optional<double> number_in(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

bool flag_in(const Json& object, const char* name, bool otherwise) {
  const auto found = object.find(name);
  return found != object.end() && found->is_boolean() ? found->get<bool>() : otherwise;
}

std::string with_unit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}

}  // namespace

std::string unit_of(const VolumeDescription& volume) {
  const Json metadata = metadata_of(volume);
  const auto unit = metadata.find("unit");
  return unit != metadata.end() && unit->is_string() ? escaped(unit->get<std::string>()) : "";
}

bool is_spacing_known(const VolumeDescription& volume) {
  return flag_in(metadata_of(volume), "spacing_known", true);
}

void require_known_spacing(const VolumeDescription& volume, const std::string& path,
                           const std::string& what, const std::string& instead) {
  if (is_spacing_known(volume)) return;
  const std::string other = instead.empty() ? "" : ", " + instead + " does not";
  throw Error(ErrorKind::invalid_argument, what + " needs a known spacing" + other, path)
      .with_field("input.spacing_mm");
}

std::optional<double> voxel_mm3(const VolumeDescription& volume) {
  if (!is_spacing_known(volume)) return std::nullopt;
  const Point3& spacing = volume.geometry.spacing_mm;
  return spacing[0] * spacing[1] * spacing[2];
}

std::optional<double> mm3_of(std::uint64_t voxels, const VolumeDescription& volume) {
  const std::optional<double> of_one = voxel_mm3(volume);
  return of_one ? std::optional(static_cast<double>(voxels) * *of_one) : std::nullopt;
}

std::uint64_t raw_bytes_of(const VolumeDescription& volume) {
  return static_cast<std::uint64_t>(volume.size.voxel_count() * bytes_per_voxel(volume.type));
}

double source_max_error(const VolumeDescription& volume) {
  return number_in(metadata_of(volume), "source_max_error").value_or(0);
}

bool was_source_lossy(const VolumeDescription& volume) {
  return flag_in(metadata_of(volume), "lossy_source", false) || source_max_error(volume) > 0;
}

FloatRepair repair_of(const VolumeDescription& volume) {
  FloatRepair repair;
  const Json metadata = metadata_of(volume);
  const auto coding = metadata.find("coding");
  if (coding == metadata.end() || !coding->is_object()) return repair;
  if (const auto nan = number_in(*coding, "nan")) repair.nan = static_cast<float>(*nan);
  if (const auto inf = number_in(*coding, "inf")) repair.infinity = static_cast<float>(*inf);
  return repair;
}

std::string real_text(const VolumeDescription& volume, double stored) {
  return with_unit(number_text(volume.rescale.to_real(stored)), unit_of(volume));
}

std::string distance_text(const VolumeDescription& volume, double stored) {
  return with_unit(number_text(stored * std::abs(volume.rescale.slope)), unit_of(volume));
}

std::string volume_text(std::uint64_t voxels, const VolumeDescription& volume) {
  const std::string count = counted_text(static_cast<std::int64_t>(voxels), "voxel");
  const auto of_one = voxel_mm3(volume);
  if (!of_one) return count + " (spacing not known)";
  const double mm3 = static_cast<double>(voxels) * *of_one;
  if (mm3 >= 1000) return fmt::format("{}, {:.2f} cm3", count, mm3 / 1000);
  return fmt::format("{}, {} mm3", count, number_text(mm3));
}

}  // namespace octavo
