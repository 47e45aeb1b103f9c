// Samples of a brick to voxels, along the brick's own axes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "octavo/codec/grey/grey_brick.h"

namespace octavo::grey {

/// The voxel of a sample, within the brick's range.
struct VoxelScale {
  ValueRange range;
  std::int64_t base;
  CodeScale codes;

  VoxelScale(const SampleScale& scale, const ValueRange& voxels)
      : range(voxels), base(scale.base()), codes(scale.codes) {}
  std::int64_t operator()(std::int64_t sample) const {
    return std::clamp(codes.voxel_of(sample + base), range.min, range.max);
  }
};

/// Voxels of a row of samples.
template <class T, class Sample>
void write_out(const Sample* samples, std::int64_t count, const SampleScale& scale,
               const VoxelScale* clamping, T* out) {
  if (clamping != nullptr) {
    for (std::int64_t i = 0; i < count; ++i) out[i] = static_cast<T>((*clamping)(samples[i]));
  } else if (scale.codes.step > 1) {
    // Voxels are sums modulo their type.
    static_assert(sizeof(T) <= sizeof(std::uint32_t));
    const auto factor = static_cast<std::uint32_t>(scale.codes.step);
    const auto base = static_cast<std::uint32_t>(scale.codes.voxel_of(scale.base()));
    for (std::int64_t i = 0; i < count; ++i) {
      out[i] = static_cast<T>(static_cast<std::uint32_t>(samples[i]) * factor + base);
    }
  } else if constexpr (std::is_integral_v<T> && sizeof(T) <= sizeof(Sample)) {
    // Voxels are sums modulo their type.
    using Unsigned = std::make_unsigned_t<T>;
    const auto base = static_cast<Unsigned>(scale.base());
    for (std::int64_t i = 0; i < count; ++i) {
      out[i] = static_cast<T>(static_cast<Unsigned>(static_cast<Unsigned>(samples[i]) + base));
    }
  } else {
    const std::int64_t base = scale.base();
    for (std::int64_t i = 0; i < count; ++i) out[i] = static_cast<T>(samples[i] + base);
  }
}

/// A dense array of `size`, along the brick's own axes.
inline VoxelTarget dense_target(void* out, const Size3& size) {
  return {out, size.x, size.x * size.y};
}

/// The same array from a voxel on.
inline VoxelTarget target_from(const VoxelTarget& out, const Index3& at, VoxelType type) {
  const std::int64_t first = at.z * out.plane_stride + at.y * out.row_stride + at.x;
  VoxelTarget result = out;
  result.voxels = static_cast<std::byte*>(out.voxels) + first * bytes_per_voxel(type);
  return result;
}

/// Writes a tile of rows, a voxel of each side by side.
/// step  from the voxels of one place in the rows to those of the next
template <class T>
void write_turned(const T (&tile)[kTileRows][kBrickSide], std::int64_t width, int rows,
                  std::int64_t step, T* out) {
  if (rows == kTileRows) {
    // A number that compilers know
    for (std::int64_t x = 0; x < width; ++x, out += step) {
      for (int k = 0; k < kTileRows; ++k) out[k] = tile[k][x];
    }
    return;
  }
  for (std::int64_t x = 0; x < width; ++x, out += step) {
    for (int k = 0; k < rows; ++k) out[k] = tile[k][x];
  }
}

/// Writes the voxels of a brick's samples.
struct VoxelWriter {
  VoxelType type;
  ValueRange range;  ///< of the brick
  SampleScale scale;
  AxisOrder order;
  bool is_lossless;

  /// size  of the samples, along the codec's axes, of which row_of(y, z) gives rows
  template <class RowOf>
  void write(const Size3& size, RowOf&& row_of, const VoxelTarget& out) const {
    const VoxelScale voxel_of(scale, range);
    const VoxelScale* const clamping = is_lossless ? nullptr : &voxel_of;
    // Steps of the array along the codec's axes.
    const Size3 steps = in_order(Size3{1, out.row_stride, out.plane_stride}, order);
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      T* const voxels = static_cast<T*>(out.voxels);
      for_each_tile(size, steps, [&](std::int64_t y, std::int64_t z, int axis, int count) {
        T* const first = voxels + y * steps.y + z * steps.z;
        if (axis == 0) {
          write_out(row_of(y, z), size.x, scale, clamping, first);
          return;
        }
        T tile[kTileRows][kBrickSide];
        for (int k = 0; k < count; ++k) {
          write_out(row_of(y + (axis == 1 ? k : 0), z + (axis == 2 ? k : 0)), size.x, scale,
                    clamping, tile[k]);
        }
        write_turned(tile, size.x, count, steps.x, first);
      });
    });
  }

  /// box  of the samples, along the codec's axes
  template <class Sample>
  void write(const SampleGrid<Sample>& grid, const Box& box, const VoxelTarget& out) const {
    write(box.size(),
          [&](std::int64_t y, std::int64_t z) {
            return grid.row(y + box.lo.y, z + box.lo.z) + box.lo.x;
          },
          out);
  }

  template <class Sample>
  void write(const SampleGrid<Sample>& grid, const VoxelTarget& out) const {
    write(grid.size(), [&](std::int64_t y, std::int64_t z) { return grid.row(y, z); }, out);
  }
};

}  // namespace octavo::grey
