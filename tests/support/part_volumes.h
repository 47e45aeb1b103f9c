// The volumes that are built in parts: every kind, preset, error, shape and way between slices.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "support/goal_cases.h"
#include "support/small_parts.h"

namespace octavo::testing {

inline constexpr std::uint64_t kPartGroupBytes = 1 << 14;

inline SmallVolume with(SmallVolume volume, const std::function<void(SmallVolume&)>& change) {
  change(volume);
  return volume;
}

/// Small volumes of every kind, of several groups each where groups have kPartGroupBytes: of five,
/// in the full form of seven.
inline std::vector<SmallVolume> part_volumes() {
  const std::int64_t missing = is_full_form() ? 0 : 2 * 64;
  const Size3 size = {33, 20, 400 - missing};
  std::vector<SmallVolume> all;
  all.push_back(small_volume("fast int16, a sliver at the end", VoxelType::int16,
                             {33, 20, 386 - missing}));
  all.push_back(with(small_volume("small uint16", VoxelType::uint16, {20, 17, 330 - missing}),
                     [](auto& v) { v.options.preset = Preset::small; }));
  all.push_back(with(small_volume("small uint8, max error", VoxelType::uint8,
                                  {20, 17, 330 - missing}),
                     [](auto& v) {
                       v.options.preset = Preset::small;
                       v.options.max_error = 2;
                     }));
  all.push_back(with(small_volume("int32, max error", VoxelType::int32, size),
                     [](auto& v) { v.options.max_error = 3; }));
  all.push_back(with(small_volume("boxes", VoxelType::int8, size),
                     [](auto& v) { v.options.access = Access::boxes; }));
  all.push_back(with(small_volume("details left out, thumbnail", VoxelType::int16, size),
                     [](auto& v) {
                       v.options.keep_details = 2;
                       v.options.has_thumbnail = true;
                     }));
  all.push_back(small_volume("labels", VoxelType::uint16, size, VolumeKind::labels));
  all.push_back(small_volume("float32, exact", VoxelType::float32, size));
  // Between which coarse levels have steps, and of which they hold not all
  all.push_back(with(small_volume("float32, few values, one far", VoxelType::float32,
                                  {33, 20, 280}),
                     [](auto& v) {
                       auto* const values = reinterpret_cast<float*>(v.voxels.data());
                       const std::size_t count = v.voxels.size() / sizeof(float);
                       for (std::size_t i = 0; i < count; ++i) {
                         values[i] = 0.37F * std::floor(values[i] / 4);
                         if (i % 30011 == 7) values[i] = 1e30F;
                       }
                     }));
  all.push_back(with(small_volume("float32, max error", VoxelType::float32, size),
                     [](auto& v) { v.options.max_error = 0.2; }));
  all.push_back(small_volume("uniform groups", VoxelType::int16, size, VolumeKind::grey, 3, true));
  all.push_back(small_volume("uniform groups of floats", VoxelType::float32, size,
                             VolumeKind::grey, 3, true));
  all.push_back(with(small_volume("thick slices", VoxelType::int16, {64, 48, 150}), [](auto& v) {
    v.description.geometry.spacing_mm = {1, 1, 5};
  }));
  const auto between = [](PlaneInterpolation method, double step) {
    return [=](SmallVolume& v) {
      v.description.geometry.spacing_mm = {1, 1, step};
      v.isotropic = method;
    };
  };
  all.push_back(with(small_volume("isotropic, cubic", VoxelType::int16, {33, 20, 160}),
                     between(PlaneInterpolation::cubic, 2.4)));
  all.push_back(with(small_volume("isotropic, linear", VoxelType::uint8, {33, 20, 160}),
                     between(PlaneInterpolation::linear, 2)));
  all.push_back(with(small_volume("isotropic labels", VoxelType::uint8, {33, 20, 120},
                                  VolumeKind::labels),
                     between(PlaneInterpolation::shape, 2.5)));
  return all;
}

}  // namespace octavo::testing
