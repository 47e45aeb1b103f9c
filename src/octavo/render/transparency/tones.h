// Values as tones: the few kinds of voxel that a picture tells apart.
//
// A tone is either the density range that a value lies in, or a step of a ramp between two values.
// Cubes of one tone are what is drawn, so noise inside a range costs nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/render/picture.h"

namespace octavo {

/// Values from `lowest` to `highest`, both included, real units; an infinite end is open.
struct DensityRange {
  double lowest = 0;
  double highest = 0;
  Color color{255, 255, 255};
  double opacity = 0.05;  ///< of a layer as thick as the finest voxel spacing, 0 .. 1
};

/// Gives every stored value its tone. Immutable; serves any number of threads.
class ToneMap {
 public:
  /// Tone i + 1 for values of ranges[i], the first that has the value; 0 for all others.
  /// Throws Error{invalid_argument} above 65534 ranges.
  static ToneMap of_ranges(const VolumeDescription& volume, std::span<const DensityRange> ranges);

  /// Tones 0 .. steps for values from `low` to `high`, stored units, rounded to the nearest; those
  /// beyond an end have its tone. With high - low == steps whole values differ by whole tones.
  /// Throws Error{invalid_argument} unless low < high, both finite, and 1 <= steps <= 65535.
  static ToneMap ramp(const VolumeDescription& volume, double low, double high, int steps);

  /// The tone of a stored voxel. NaN has tone 0.
  std::uint16_t tone(double stored) const;

  /// The tone that all voxels between two have; nothing where it cannot be known from the two.
  std::optional<std::uint16_t> common_tone(double least, double greatest) const;

  /// Tones there are: ranges + 1, or steps + 1.
  std::size_t count() const;

  /// The tones of `count` voxels of the volume's type.
  void map(const void* voxels, std::int64_t count, std::uint16_t* tones) const;

 private:
  ToneMap() = default;
  void make_table();
  template <class T>
  void map_as(const void* voxels, std::int64_t count, std::uint16_t* tones) const;

  VoxelType type_ = VoxelType::uint8;
  Rescale rescale_;
  std::vector<DensityRange> ranges_;  // none: a ramp
  double low_ = 0;
  double high_ = 0;
  int steps_ = 0;
  std::vector<std::uint16_t> table_;  // of all values of a type of 8 or 16 bits
};

}  // namespace octavo
