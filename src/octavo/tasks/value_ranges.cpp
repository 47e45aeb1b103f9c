#include "octavo/tasks/value_ranges.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "octavo/core/text.h"
#include "octavo/tasks/volume_facts.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Tissue {
  const char* name;
  double lowest;
  double highest;
};

constexpr std::array<Tissue, 6> kTissues = {{{"air", -kInfinity, -900},
                                             {"lung", -900, -500},
                                             {"fat", -190, -30},
                                             {"soft", -30, 225},
                                             {"contrast", 130, 600},
                                             {"bone", 226, kInfinity}}};

/// The smallest stored integer of first .. last whose real value is at least `real`, for a positive
/// slope; last + 1 where there is none.
double first_stored(const Rescale& rescale, double real, double first, double last) {
  const double quotient = std::ceil((real - rescale.intercept) / rescale.slope);
  double stored = std::clamp(quotient, first, last + 1);
  // The quotient may have been rounded past a whole number.
  while (stored > first && rescale.to_real(stored - 1) >= real) --stored;
  while (stored <= last && rescale.to_real(stored) < real) ++stored;
  return stored;
}

}  // namespace

std::vector<std::string> tissue_names() {
  std::vector<std::string> names;
  for (const Tissue& tissue : kTissues) names.emplace_back(tissue.name);
  return names;
}

AskedRange tissue_range(const std::string& name) {
  for (const Tissue& tissue : kTissues) {
    if (name == tissue.name) return {tissue.lowest, tissue.highest};
  }
  throw Error(ErrorKind::invalid_argument, "no tissue is called " + escaped(name));
}

void check_tissues(const std::vector<std::string>& names, const VolumeDescription& volume,
                   const std::string& path, const TaskContext& context) {
  if (names.empty()) return;
  for (const std::string& name : names) tissue_range(name);
  require_hu(volume, path, "the tissue " + names.front(), context, "tissues");
}

ValueWindow stored_window(const AskedRange& range, const VolumeDescription& volume,
                          bool is_stored) {
  const Rescale& rescale = volume.rescale;
  if (is_stored || rescale.is_identity()) return {range.lowest, range.highest};
  if (rescale.slope == 0) {
    throw Error(ErrorKind::invalid_argument,
                "the volume's rescale slope is 0: all its voxels have one real value, which no "
                "range tells apart");
  }
  // A falling scale is a rising one of mirrored ends.
  const bool is_falling = rescale.slope < 0;
  const double low = is_falling ? -range.highest : range.lowest;
  const double high = is_falling ? -range.lowest : range.highest;
  const Rescale rising{std::abs(rescale.slope),
                       is_falling ? -rescale.intercept : rescale.intercept};
  if (!is_integer(volume.type)) {
    return {(low - rising.intercept) / rising.slope, (high - rising.intercept) / rising.slope};
  }
  // The largest stored value at or below `high` is the negative of the smallest at or above it
  // in a mirrored scale.
  const Rescale mirrored{rising.slope, -rising.intercept};
  const ValueRange values = value_range(volume.type);
  const auto minimum = static_cast<double>(values.min);
  const auto maximum = static_cast<double>(values.max);
  return {first_stored(rising, low, minimum, maximum),
          -first_stored(mirrored, -high, -maximum, -minimum)};
}

}  // namespace octavo
