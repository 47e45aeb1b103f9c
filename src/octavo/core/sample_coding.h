// How the integers that bricks hold become the voxels of a float32 volume.
//
//     voxel = float(clamp(code * scale + offset))      every step in binary64, one rounding each
//
// A voxel that would be -0 is 0.
//
// The codecs, the levels of detail and the index work on codes; floats are made where voxels leave
// a file. No step is fused with another, so the same codes give the same bits on every machine.
//
// Where a coding is exact, codes are the nearest to the voxels: bricks hold beside them what makes
// the floats of level 0 come back bit by bit, NaN and infinities among them (codec/exact/). Coarse
// samples are those of the codes, or NaN where no finite voxel lies below.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/core/voxel_type.h"

namespace octavo {

struct SampleCoding {
  VoxelType type = VoxelType::int32;  ///< of the codes: an integer type
  double scale = 1;                   ///< positive
  double offset = 0;
  bool is_exact = false;              ///< codes are of type int32; max error 0

  /// As a bound in the index of an exact volume: the largest float; minus that: the smallest one.
  static constexpr std::int64_t kUnbounded = 0x7fffffff;

  bool operator==(const SampleCoding&) const = default;

  /// The voxel of a code; values beyond the range of a float become its largest ones.
  float voxel_of(std::int64_t code) const;
};

/// An integer code type (int32 where the coding is exact), a positive scale, both numbers finite.
bool is_valid(const SampleCoding& coding) noexcept;

/// Turns codes of coding.type into voxels. `codes` and `voxels` may start at the same address.
/// Requires a code of coding.type for each voxel.
void decode_samples(const SampleCoding& coding, const void* codes, std::span<float> voxels);

}  // namespace octavo
