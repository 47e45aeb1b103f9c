#include "octavo/tasks/volume_facts.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/io/source/value_unit.h"
#include "octavo/render/numbers.h"
#include "octavo/tasks/value_ranges.h"

namespace octavo {

namespace {

/// With the digits that tell a number from all other float32, by which a range finds it.
std::string float_digits(double value) {
  if (std::isnan(value)) return number_text(value);
  if (std::abs(value) > std::numeric_limits<float>::max()) return exact_text(value);
  // The sum makes -0 a 0.
  return fmt::format("{}", static_cast<float>(value) + 0.0f);
}

}  // namespace

std::string unit_of(const Metadata& metadata) { return escaped(shown_unit(metadata.unit())); }

std::string unit_of(const VolumeDescription& volume) { return unit_of(volume.metadata); }

void require_hu(const VolumeDescription& volume, const std::string& path, const std::string& what,
                const TaskContext& context, const std::string& field) {
  const std::string unit = unit_of(volume);
  const bool is_grey = volume.kind == VolumeKind::grey;
  if (is_grey && unit == "HU") return;
  if (is_grey && unit.empty()) {
    context.warn({fmt::format("{}: its unit is not known; for {} its values are taken as HU", path,
                              what),
                  field});
    return;
  }
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{} is in HU, and this volume {}", what,
                          is_grey ? "is in " + unit : "holds labels"),
              path)
      .with_field(field);
}

bool is_spacing_known(const VolumeDescription& volume) {
  return volume.metadata.is_spacing_known();
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

FloatRepair repair_of(const VolumeDescription& volume) {
  FloatRepair repair;
  const CodingNote coding = volume.metadata.facts().coding.value_or(CodingNote{});
  if (coding.nan) repair.nan = static_cast<float>(*coding.nan);
  if (coding.infinity) repair.infinity = static_cast<float>(*coding.infinity);
  return repair;
}

std::string real_text(const VolumeDescription& volume, double stored) {
  const double real = volume.rescale.to_real(stored);
  const bool is_whole = volume.rescale.is_identity() && is_integer(volume.type);
  std::string digits = is_whole ? exact_text(real) : float_digits(real);
  // Integers may be closer to one another than the real values that float32 has.
  if (is_integer(volume.type) && !is_whole && volume.rescale.slope != 0) {
    double read = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), read);
    if (!stored_window({read, read}, volume, false).contains(stored)) digits = exact_text(real);
  }
  return with_unit(digits, unit_of(volume));
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
