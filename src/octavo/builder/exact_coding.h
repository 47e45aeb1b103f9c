// The coding of floats that are kept bit by bit: in which steps their codes, and so the coarse
// levels, count.
//
// The scale is that of the number that the values are multiples of, or else a power of two that
// divides their noise into some steps. Fill values have no say in it: those that many voxels are,
// and few different ones far beyond the bulk of the others. Values beyond 2^31 steps clip in
// coarse levels: where many different ones lie so far away, steps are wider.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "octavo/builder/float_stack.h"
#include "octavo/core/sample_coding.h"

namespace octavo {

/// What is known of a float32 volume before its coding is chosen.
struct FloatSample {
  FloatStack planes;                ///< its first ones
  FloatStack rows;                  ///< of planes spread over the rest
  std::vector<float> first_values;  ///< of the planes: different, finite, ascending
  std::vector<float> values;        ///< the same of all planes that were looked at
};

/// hints  codings to try first, in their order
SampleCoding exact_coding_of(const FloatSample& sample, std::span<const SampleCoding> hints);

/// Wider steps for a volume of few different values, to be tried beside its usual coding: these
/// have few codes, and which float of its step a voxel is mostly follows from the voxels before it.
/// None for other volumes, or where the usual one has as few codes.
std::optional<SampleCoding> coding_of_few(const FloatSample& sample, const SampleCoding& usual);

/// The coding with its steps divided by the power of two that makes 32 of them or more between the
/// smallest and the largest value that codes reach: means of few values are then no roundings to
/// these. Each value that had a code of its own keeps one.
/// values  ascending, finite
SampleCoding with_steps_for_means(const SampleCoding& coding, std::span<const float> values);

/// Finite voxels whose codes are not the nearest to them, as these end at +-(2^31 - 2): level 0 has
/// them bit by bit, coarse levels as the last code.
struct ClippedVoxels {
  std::int64_t count = 0;
  float farthest = 0;  ///< the one of the largest magnitude
  double limit = 0;    ///< the magnitude at which coarse levels end

  bool operator==(const ClippedVoxels&) const = default;
};

/// Told of them before what was built is sealed. May throw: then nothing stands.
using ClippedListener = std::function<void(const ClippedVoxels&)>;

/// Adds those among `voxels` to `clipped`.
void count_clipped(const SampleCoding& coding, std::span<const float> voxels,
                   ClippedVoxels& clipped);

/// Adds those of later planes of the same volume.
void add_clipped(const ClippedVoxels& more, ClippedVoxels& clipped);

}  // namespace octavo
