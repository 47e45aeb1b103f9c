#include "octavo/io/dicom/dicom_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "octavo/core/unset_bytes.h"
#include "octavo/core/voxel_type.h"
#include "octavo/io/dicom/dicom_pixels.h"
#include "octavo/planes/between/plane_mixing.h"

namespace octavo {

namespace {

template <class T>
T voxel_at(std::span<const std::byte> voxels, std::int64_t index) {
  T value;
  std::memcpy(&value, voxels.data() + static_cast<std::size_t>(index) * sizeof(T), sizeof(T));
  return value;
}

template <class T>
void put_voxel(std::span<std::byte> voxels, std::int64_t index, T value) {
  std::memcpy(voxels.data() + static_cast<std::size_t>(index) * sizeof(T), &value, sizeof(T));
}

template <class T>
bool is_padding(const Mixing& mixing, T value) {
  return mixing.padding && static_cast<std::int64_t>(value) == *mixing.padding;
}

Mixing mixing_of(const DicomStack& stack) {
  return {stack.holds_labels, stack.padding};
}

/// Where a voxel of the canvas comes from along one axis: between `low` and `high`.
struct Tap {
  std::int64_t low = 0;
  std::int64_t high = 0;
  double weight_high = 0;
  bool is_inside = false;

  std::int64_t nearest() const { return weight_high < 0.5 ? low : high; }
};

/// Taps of all canvas voxels of an axis for a slice of `count` voxels moved by `shift`.
std::vector<Tap> taps_of(std::int64_t canvas, std::int64_t count, double shift) {
  const double up = std::ceil(shift);
  const double weight = up - shift;
  std::vector<Tap> taps(static_cast<std::size_t>(canvas));
  std::int64_t low = -static_cast<std::int64_t>(up);
  for (Tap& tap : taps) {
    // A voxel reaches half its side beyond its center.
    const double place = static_cast<double>(low) + weight;
    tap.is_inside = place >= -0.5 && place <= static_cast<double>(count) - 0.5;
    tap.low = std::clamp<std::int64_t>(low, 0, count - 1);
    tap.high = weight > 0 ? std::clamp<std::int64_t>(low + 1, 0, count - 1) : tap.low;
    tap.weight_high = weight;
    ++low;
  }
  return taps;
}

template <class T>
T sample(std::span<const std::byte> slice, std::int64_t columns, const Tap& x, const Tap& y,
         const Mixing& mixing) {
  const T nearest = voxel_at<T>(slice, y.nearest() * columns + x.nearest());
  if (mixing.takes_nearest || (x.weight_high == 0 && y.weight_high == 0)) return nearest;
  const std::array<T, 4> v = {voxel_at<T>(slice, y.low * columns + x.low),
                              voxel_at<T>(slice, y.low * columns + x.high),
                              voxel_at<T>(slice, y.high * columns + x.low),
                              voxel_at<T>(slice, y.high * columns + x.high)};
  for (const T value : v)
    if (is_padding(mixing, value)) return nearest;
  const auto mix = [](double a, double b, double weight_b) {
    return (1 - weight_b) * a + weight_b * b;
  };
  const double low = mix(static_cast<double>(v[0]), static_cast<double>(v[1]), x.weight_high);
  const double high = mix(static_cast<double>(v[2]), static_cast<double>(v[3]), x.weight_high);
  return nearest_value<T>(mix(low, high, y.weight_high));
}

template <class T>
void move_slice(const DicomStack& stack, std::size_t index, std::span<const std::byte> slice,
                std::span<std::byte> plane) {
  const TiltRemoval& tilt = *stack.tilt;
  const DicomLayout& layout = *stack.slices[index].layout;
  const Mixing mixing = mixing_of(stack);
  const std::vector<Tap> across = taps_of(tilt.columns, layout.columns, tilt.shift[index][0]);
  const std::vector<Tap> down = taps_of(tilt.rows, layout.rows, tilt.shift[index][1]);
  const T outside = nearest_value<T>(tilt.outside);
  std::int64_t at = 0;
  for (const Tap& y : down) {
    for (const Tap& x : across) {
      const bool is_inside = x.is_inside && y.is_inside;
      put_voxel<T>(plane, at++,
                   is_inside ? sample<T>(slice, layout.columns, x, y, mixing) : outside);
    }
  }
}

/// Slice `index` as it stands in the volume.
void read_placed(const DicomStack& stack, std::size_t index, std::span<std::byte> plane) {
  const DicomSlice& slice = stack.slices[index];
  if (!stack.tilt) {
    read_dicom_frame(slice, plane);
    return;
  }
  const VoxelType type = dicom_voxel_type(*slice.layout);
  UnsetBytes voxels(static_cast<std::size_t>(
      slice.layout->columns * slice.layout->rows * bytes_per_voxel(type)));
  read_dicom_frame(slice, voxels.bytes());
  with_voxel_type(type, [&](auto tag) {
    move_slice<typename decltype(tag)::type>(stack, index, voxels.bytes(), plane);
  });
}

}  // namespace

void read_stack_plane(const DicomStack& stack, std::int64_t z, std::span<std::byte> plane) {
  const PlaneOrigin& origin = stack.planes[static_cast<std::size_t>(z)];
  if (origin.is_background) {
    std::fill(plane.begin(), plane.end(), std::byte{0});
    return;
  }
  read_placed(stack, origin.below, plane);
  if (origin.weight_above == 0) return;
  UnsetBytes above(plane.size());
  read_placed(stack, origin.below + 1, above.bytes());
  const double weight = origin.weight_above;
  mix_planes(dicom_voxel_type(*stack.slices[origin.below].layout),
             {.planes = {plane, above.bytes()}, .weights = {1 - weight, weight}}, mixing_of(stack),
             plane);
}

}  // namespace octavo
