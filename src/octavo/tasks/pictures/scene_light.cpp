#include "octavo/tasks/pictures/scene_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace octavo {

namespace {

constexpr std::int64_t kMostShadeSamples = std::int64_t{1} << 20;
constexpr std::uint64_t kBytesPerShadeSample = 20;

/// The values of a whole level.
struct LightValues {
  std::vector<float> real;
  /// Of the finite values of the file, real ones.
  double low = 0;
  double high = 0;
  double of_nan = 0;

  /// As rays take it: what is not finite is the lowest or highest stored value, and NaN, where
  /// it is not empty, the lowest.
  double shown(std::size_t i) const {
    const double value = static_cast<double>(real[i]);
    return std::isnan(value) ? of_nan : std::clamp(value, low, high);
  }
};

LightValues light_values(const FileReader& reader, int level) {
  const Size3& size = reader.levels().size(level);
  const auto count = static_cast<std::size_t>(size.voxel_count());
  LightValues values;
  values.real.resize(count);
  const VolumeDescription& volume = reader.description();
  const Rescale& rescale = volume.rescale;
  with_voxel_type(volume.type, [&](auto id) {
    using T = typename decltype(id)::type;
    std::vector<T> stored(count);
    reader.read(box_of(size), level, stored.data());
    for (std::size_t i = 0; i < count; ++i) {
      values.real[i] = static_cast<float>(rescale.to_real(static_cast<double>(stored[i])));
    }
  });
  const auto [lowest, highest] =
      std::minmax({volume.voxel_of(volume.code_near(reader.range().min)),
                   volume.voxel_of(volume.code_near(reader.range().max))});
  values.of_nan = rescale.to_real(lowest);
  std::tie(values.low, values.high) = std::minmax({values.of_nan, rescale.to_real(highest)});
  return values;
}

/// Length of the gradient at a sample, by differences of those neighbors that are numbers: nothing
/// lies between an infinity, or NaN, and another sample.
double gradient_of(const std::vector<float>& values, const Size3& size, const Point3& spacing,
                   const Index3& at) {
  const std::array<std::int64_t, 3> strides{1, size.x, size.x * size.y};
  const std::int64_t here = (at.z * size.y + at.y) * size.x + at.x;
  const auto value = [&](std::int64_t i) {
    return static_cast<double>(values[static_cast<std::size_t>(i)]);
  };
  if (!std::isfinite(value(here))) return 0;
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const std::int64_t step = strides[i];
    const bool has_below = at[axis] > 0 && std::isfinite(value(here - step));
    const bool has_above = at[axis] + 1 < size[axis] && std::isfinite(value(here + step));
    const int apart = (has_below ? 1 : 0) + (has_above ? 1 : 0);
    if (apart == 0) continue;
    const double difference =
        value(has_above ? here + step : here) - value(has_below ? here - step : here);
    squared += std::pow(difference / (apart * spacing[i]), 2);
  }
  return std::sqrt(squared);
}

}  // namespace

Box box_at_level(const Box& box, const Levels& levels, int level) {
  Box at;
  for (int axis = 0; axis < 3; ++axis) {
    const int halvings = levels.halving_count(level, axis);
    const std::int64_t half = (std::int64_t{1} << halvings) / 2;
    at.lo[axis] = (box.lo[axis] + half) >> halvings;
    at.hi[axis] = (box.hi[axis] + half) >> halvings;
  }
  return intersection(at, box_of(levels.size(level)));
}

std::unique_ptr<RayShade> scene_light(const FileReader& reader, int level,
                                      const SceneMatter& matter, const TaskContext& context) {
  const Levels& levels = reader.levels();
  while (level + 1 < levels.count() && levels.size(level).voxel_count() > kMostShadeSamples) {
    ++level;
  }
  ExtinctionGrid grid;
  grid.size = levels.size(level);
  grid.geometry = levels.geometry(reader.description().geometry, level);
  context.require_memory(
      kBytesPerShadeSample * static_cast<std::uint64_t>(grid.size.voxel_count()),
      "the light in the volume");
  const LightValues values = light_values(reader, level);
  std::vector<std::uint16_t> looks(values.real.size(), 1);
  if (matter.looks) matter.looks(level)->read(box_of(grid.size), looks.data());

  // Extinctions of what is shown.
  const Box kept = box_at_level(matter.kept, levels, level);
  std::vector<Box> removed;
  for (const Box& box : matter.removed) removed.push_back(box_at_level(box, levels, level));
  grid.per_mm.resize(values.real.size());
  const Point3& spacing = grid.geometry.spacing_mm;
  const double side = *std::max_element(spacing.begin(), spacing.end());
  std::size_t i = 0;
  visit_cells(box_of(grid.size), {1, 1, 1}, [&](const Index3& at) {
    const bool is_shown =
        kept.contains(at) && std::none_of(removed.begin(), removed.end(),
                                          [&](const Box& box) { return box.contains(at); });
    const bool is_empty = matter.is_nan_empty && std::isnan(values.real[i]);
    if (is_shown && !is_empty) {
      const double gradient =
          matter.has_gradient ? gradient_of(values.real, grid.size, spacing, at) : 0;
      grid.per_mm[i] = static_cast<float>(
          matter.extinction({values.shown(i), gradient, side, looks[i]}));
    }
    ++i;
    return true;
  });
  std::unique_ptr<RayShade> light;
  context.on_threads(
      [&] { light = std::make_unique<RayShade>(std::move(grid), context.watcher()); });
  return light;
}

}  // namespace octavo
