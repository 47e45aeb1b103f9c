#include "octavo/planes/between/plane_mixing.h"

#include <cstring>

namespace octavo {

namespace {

constexpr std::size_t kTaps = 4;

template <class T>
T voxel_at(std::span<const std::byte> voxels, std::size_t index) {
  T value;
  std::memcpy(&value, voxels.data() + index * sizeof(T), sizeof(T));
  return value;
}

/// The planes that take part.
struct Taps {
  std::array<std::span<const std::byte>, kTaps> planes;
  std::array<double, kTaps> weights{};
  std::size_t count = 0;
  std::size_t heaviest = 0;
};

Taps taps_of(const PlaneWeights& mix) {
  Taps taps;
  for (std::size_t i = 0; i < kTaps; ++i) {
    if (mix.weights[i] == 0) continue;
    taps.planes[taps.count] = mix.planes[i];
    taps.weights[taps.count] = mix.weights[i];
    if (mix.weights[i] >= taps.weights[taps.heaviest]) taps.heaviest = taps.count;
    ++taps.count;
  }
  return taps;
}

template <class T>
void mix_voxels(const Taps& taps, double divisor, const Mixing& mixing, std::span<std::byte> out) {
  const std::size_t count = out.size() / sizeof(T);
  std::array<T, kTaps> values{};
  const auto is_no_measurement = [&](T value) {
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(value)) return true;
      return mixing.padding && value == static_cast<T>(*mixing.padding);
    } else {
      return mixing.padding && static_cast<std::int64_t>(value) == *mixing.padding;
    }
  };
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0;
    bool is_uniform = true;
    bool takes_nearest = mixing.takes_nearest;
    for (std::size_t k = 0; k < taps.count; ++k) {
      values[k] = voxel_at<T>(taps.planes[k], i);
      sum += taps.weights[k] * static_cast<double>(values[k]);
      is_uniform = is_uniform && values[k] == values[0];
      takes_nearest = takes_nearest || is_no_measurement(values[k]);
    }
    const T value = is_uniform || takes_nearest ? values[taps.heaviest]
                                                : nearest_value<T>(sum / divisor);
    std::memcpy(out.data() + i * sizeof(T), &value, sizeof(T));
  }
}

}  // namespace

void mix_planes(VoxelType type, const PlaneWeights& mix, const Mixing& mixing,
                std::span<std::byte> out) {
  const Taps taps = taps_of(mix);
  with_voxel_type(type, [&](auto tag) {
    mix_voxels<typename decltype(tag)::type>(taps, mix.divisor, mixing, out);
  });
}

}  // namespace octavo
