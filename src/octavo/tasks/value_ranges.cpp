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

/// By how much the real value of a stored one may differ from what is meant: a header holds a slope
/// and an intercept as float32, or as decimals, and readers hand out real values as float32. Whole
/// numbers have no such rounding.
double scale_rounding(const Rescale& rescale, double stored) {
  constexpr double kFloatStep = std::numeric_limits<float>::epsilon();
  const auto rounded_part = [](double part, double whole) {
    return whole == std::trunc(whole) ? 0.0 : kFloatStep * std::abs(part);
  };
  const double parts = rounded_part(rescale.slope * stored, rescale.slope) +
                       rounded_part(rescale.intercept, rescale.intercept);
  return parts == 0 ? 0 : parts + kFloatStep / 2 * std::abs(rescale.to_real(stored));
}

/// The smallest stored integer of first .. last whose real value is at least `real`, for a positive
/// slope; last + 1 where there is none. One that falls short by a rounding counts, but never by
/// more than a quarter of a step.
double first_stored(const Rescale& rescale, double real, double first, double last) {
  const auto reaches = [&](double stored) {
    const double rounding = std::min(scale_rounding(rescale, stored), rescale.slope / 4);
    return rescale.to_real(stored) >= real - rounding;
  };
  const double quotient = std::ceil((real - rescale.intercept) / rescale.slope);
  double stored = std::clamp(quotient, first, last + 1);
  // The quotient may have been rounded past a whole number.
  while (stored > first && reaches(stored - 1)) --stored;
  while (stored <= last && !reaches(stored)) ++stored;
  return stored;
}

/// The float32 that is nearest to an end of a range; ends beyond all of them stay what they are.
double nearest_float(double end) {
  constexpr double kMax = std::numeric_limits<float>::max();
  return std::abs(end) > kMax ? end : static_cast<double>(static_cast<float>(end));
}

/// An end of a range of float32 values behind a scale, moved outwards by what rounding may hide.
/// rising  has a positive slope
double scaled_end(const Rescale& rising, double real, double outwards) {
  if (std::isinf(real)) return real;
  constexpr double kFloatStep = std::numeric_limits<float>::epsilon();
  const double stored = (real - rising.intercept) / rising.slope;
  return stored + outwards * (scale_rounding(rising, stored) / rising.slope +
                              kFloatStep * std::abs(stored));
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
  if (is_stored || rescale.is_identity()) {
    if (is_integer(volume.type)) return {range.lowest, range.highest};
    return {nearest_float(range.lowest), nearest_float(range.highest)};
  }
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
    return {scaled_end(rising, low, -1), scaled_end(rising, high, 1)};
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
