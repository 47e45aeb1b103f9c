#include "octavo/render/transparency/density_classes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxClasses = 65536;

template <class T>
constexpr bool has_table = sizeof(T) <= 2;

}  // namespace

DensityClasses DensityClasses::of_ranges(const VolumeDescription& volume,
                                         std::span<const DensityRange> ranges) {
  if (ranges.size() + 1 >= kMaxClasses) {
    throw Error(ErrorKind::invalid_argument, "more than 65534 density ranges");
  }
  DensityClasses map;
  map.type_ = volume.type;
  map.rescale_ = volume.rescale;
  map.ranges_.assign(ranges.begin(), ranges.end());
  map.make_table();
  return map;
}

DensityClasses DensityClasses::ramp(const VolumeDescription& volume, double low, double high,
                                    int steps) {
  const bool is_sound = std::isfinite(low) && std::isfinite(high) && low != high;
  if (!is_sound || steps < 1 || static_cast<std::size_t>(steps) >= kMaxClasses) {
    throw Error(ErrorKind::invalid_argument, "a ramp needs two ends and 1 to 65535 steps");
  }
  DensityClasses map;
  map.type_ = volume.type;
  map.low_ = low;
  map.high_ = high;
  map.steps_ = steps;
  map.make_table();
  return map;
}

std::size_t DensityClasses::count() const {
  return steps_ > 0 ? static_cast<std::size_t>(steps_) + 1 : ranges_.size() + 1;
}

std::uint16_t DensityClasses::class_of(double stored) const {
  if (steps_ > 0) {
    const double share = (stored - low_) / (high_ - low_);
    if (!(share > 0)) return 0;
    return static_cast<std::uint16_t>(std::lround(std::min(share, 1.0) * steps_));
  }
  const double real = rescale_.to_real(stored);
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    if (real >= ranges_[i].lowest && real <= ranges_[i].highest) {
      return static_cast<std::uint16_t>(i + 1);
    }
  }
  return 0;
}

std::optional<std::uint16_t> DensityClasses::common_class(double minimum, double maximum) const {
  if (std::isnan(minimum) || std::isnan(maximum)) return std::nullopt;
  if (steps_ > 0 || minimum == maximum) {
    const std::uint16_t one = class_of(minimum);
    return one == class_of(maximum) ? std::optional(one) : std::nullopt;
  }
  const auto [low, high] = std::minmax({rescale_.to_real(minimum), rescale_.to_real(maximum)});
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const DensityRange& range = ranges_[i];
    if (range.lowest <= low && high <= range.highest) return static_cast<std::uint16_t>(i + 1);
    if (range.lowest <= high && low <= range.highest) return std::nullopt;
  }
  return 0;
}

void DensityClasses::make_table() {
  if (bytes_per_voxel(type_) > 2) return;
  const ValueRange values = value_range(type_);
  for (std::int64_t value = values.min; value <= values.max; ++value) {
    table_.push_back(class_of(static_cast<double>(value)));
  }
}

template <class T>
void DensityClasses::map_as(const void* voxels, std::int64_t count, std::uint16_t* classes) const {
  const auto* const bytes = static_cast<const std::byte*>(voxels);
  for (std::int64_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, bytes + static_cast<std::size_t>(i) * sizeof value, sizeof value);
    if constexpr (has_table<T>) {
      classes[i] = table_[static_cast<std::size_t>(value - std::numeric_limits<T>::min())];
    } else {
      classes[i] = class_of(static_cast<double>(value));
    }
  }
}

void DensityClasses::map(const void* voxels, std::int64_t count, std::uint16_t* classes) const {
  with_voxel_type(type_,
                  [&](auto id) { map_as<typename decltype(id)::type>(voxels, count, classes); });
}

}  // namespace octavo
