// Finds the integers behind float voxels: a scale and an offset such that every voxel is exactly
// float(integer * scale + offset).
//
// Volumes of type float32 mostly hold integers that some program multiplied: the steps between
// their values tell by what. A scale is accepted only when it gives back the bits of every value
// that was seen; among the scales that do, one that a person or a file header would have written
// is taken (few digits, 1/n, a float32), since values yet to come follow that one.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/sample_coding.h"

namespace octavo {

/// Codes are whole numbers of this magnitude at most.
inline constexpr double kLargestCode = std::numeric_limits<std::int32_t>::max();

/// The different values among many floats, up to a number of them.
class DistinctValues {
 public:
  static constexpr std::size_t kMost = std::size_t{1} << 18;

  DistinctValues();
  /// Takes note of finite values; -0 counts as 0, other values that are not finite are passed over.
  void add(std::span<const float> values);
  std::size_t count() const { return count_; }
  /// In ascending order. More than kMost are not kept.
  std::vector<float> sorted() const;

 private:
  std::vector<std::uint32_t> slots_;  // bits of a value; those of a NaN where none is
  std::size_t count_ = 0;
};

/// The code of a voxel, when it gives back the bits of the voxel.
std::optional<std::int64_t> exact_code(const SampleCoding& coding, float voxel);

/// A coding with codes of type int32 that holds every one of `values` exactly, -0 counted as 0.
/// values  sorted, different, finite
/// hints   tried first, in their order
/// Returns nothing when the values have no common step, or one so fine that 32 bits do not hold
///         them
std::optional<SampleCoding> find_coding(std::span<const float> values,
                                        std::span<const SampleCoding> hints);

}  // namespace octavo
