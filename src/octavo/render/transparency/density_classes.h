// Values as density classes: the few kinds of voxel that a picture distinguishes.
//
// A class is either the density range that a value lies in, or a step of a ramp between two values.
// Cubes of one class are what is drawn, so noise inside a range costs nothing.
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

/// Gives every stored value its class. Immutable; serves any number of threads.
class DensityClasses {
 public:
  /// Class i + 1 for values of ranges[i], the first that has the value; 0 for all others.
  /// Throws Error{invalid_argument} above 65534 ranges.
  static DensityClasses of_ranges(const VolumeDescription& volume,
                                  std::span<const DensityRange> ranges);

  /// Classes 0 .. steps for values from `low` to `high`, stored units, rounded to the nearest;
  /// those beyond an end have its class. `high` may be the smaller one. Where they differ by
  /// `steps`, whole values differ by whole classes.
  /// Throws Error{invalid_argument} unless low != high, both finite, and 1 <= steps <= 65535.
  static DensityClasses ramp(const VolumeDescription& volume, double low, double high, int steps);

  /// The class of a stored voxel. NaN has class 0.
  std::uint16_t class_of(double stored) const;

  /// The class that all voxels between two have; nothing where it cannot be known from the two.
  std::optional<std::uint16_t> common_class(double minimum, double maximum) const;

  /// Classes there are: ranges + 1, or steps + 1.
  std::size_t count() const;

  /// The classes of `count` voxels of the volume's type.
  void map(const void* voxels, std::int64_t count, std::uint16_t* classes) const;

 private:
  DensityClasses() = default;
  void make_table();
  template <class T>
  void map_as(const void* voxels, std::int64_t count, std::uint16_t* classes) const;

  VoxelType type_ = VoxelType::uint8;
  Rescale rescale_;
  std::vector<DensityRange> ranges_;  // none: a ramp
  double low_ = 0;
  double high_ = 0;
  int steps_ = 0;
  std::vector<std::uint16_t> table_;  // of all values of a type of 8 or 16 bits
};

}  // namespace octavo
