#include "octavo/tasks/salvage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/tasks/range_words.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxWarnings = 10;

/// The stored voxel nearest to a real value.
double stored_value(const FileReader& reader, double real) {
  const VolumeDescription& d = reader.description();
  if (d.rescale.slope == 0) {
    throw Error(ErrorKind::invalid_argument,
                "every voxel of this file stands for the same value; none can be filled in",
                reader.source().name());
  }
  const double stored = (real - d.rescale.intercept) / d.rescale.slope;
  if (!is_integer(d.type)) return stored;
  const double nearest = std::round(stored);
  const ValueRange range = value_range(d.type);
  const auto minimum = static_cast<double>(range.min);
  const auto maximum = static_cast<double>(range.max);
  if (nearest >= minimum && nearest <= maximum) return nearest;
  const double a = d.rescale.to_real(minimum);
  const double b = d.rescale.to_real(maximum);
  const std::string unit = unit_of(d);
  const OutsideWords words = outside_words(real, std::min(a, b), std::max(a, b));
  throw Error(ErrorKind::invalid_argument,
              fmt::format("cannot be filled with {}: its voxels can be {} to {}{}", words.value,
                          words.lowest, words.highest, unit.empty() ? "" : " " + unit),
              reader.source().name());
}

std::string fill_text(const SalvagedDamage& damage, const VolumeDescription& volume) {
  const bool is_one = damage.brick_count == 1;
  const std::string start =
      is_one ? "filled " : count_text(damage.brick_count) + " bricks filled ";
  const std::string value = real_text(volume, damage.value);
  switch (damage.fill) {
    case SalvageFill::coarser_level:
      return start +
             (is_one ? fmt::format("from level {}", damage.level) : "from coarser levels");
    case SalvageFill::brick_lowest:
      return start + (is_one ? "with its lowest value, " + value : "with their lowest values");
    case SalvageFill::volume_lowest:
      return start + "with the lowest value of the volume, " + value;
    case SalvageFill::value: break;
  }
  return start + "with " + value;
}

}  // namespace

std::shared_ptr<const FileReader> salvaging(std::shared_ptr<const FileReader> reader,
                                            const std::optional<SalvageFilling>& filling,
                                            const TaskContext& context) {
  if (!filling) return reader;
  SalvageOptions options;
  options.from_coarser = filling->is_from_coarser;
  if (filling->real_value) options.value = stored_value(*reader, *filling->real_value);
  if (context.is_strict) return reader;
  return std::make_shared<SalvageReader>(std::move(reader), options);
}

void read_salvaging(const std::optional<SalvageFilling>& filling, const TaskContext& context,
                    const std::function<void()>& read) {
  try {
    read();
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::corrupt) throw;
    if (!filling) throw error.with_field("salvage");
    throw context.is_strict ? error.with_field("is_strict") : error;
  }
}

std::optional<SalvageReport> salvage_report(const FileReader& reader) {
  const auto* salvage = dynamic_cast<const SalvageReader*>(&reader);
  return salvage == nullptr ? std::nullopt : std::optional(salvage->report());
}

void warn_of_salvaged(const FileReader& reader, const TaskContext& context) {
  const std::optional<SalvageReport> report = salvage_report(reader);
  if (!report) return;
  const std::string name = escaped(reader.source().name()) + ": ";
  const std::size_t told = std::min(report->damages.size(), kMaxWarnings);
  for (std::size_t i = 0; i < told; ++i) {
    const SalvagedDamage& damage = report->damages[i];
    context.warn(name + damage.detail + ": " + fill_text(damage, reader.description()));
  }
  const std::int64_t left = report->damage_count - static_cast<std::int64_t>(told);
  if (left == 0) return;
  context.warn(fmt::format("{}{} more damaged places; {} bricks were filled in all, verify names "
                           "each",
                           name, count_text(left), count_text(report->brick_count)));
}

}  // namespace octavo
