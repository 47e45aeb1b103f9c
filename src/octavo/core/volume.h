// What is known of a volume besides its voxels.
#pragma once

#include <cstdint>
#include <optional>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/metadata.h"
#include "octavo/core/sample_coding.h"
#include "octavo/core/voxel_type.h"

namespace octavo {

/// The values are those of the file format.
enum class VolumeKind : std::uint8_t {
  grey = 1,    ///< measured intensities: coarse samples are rounded means
  labels = 2,  ///< names of regions: coarse samples are most frequent labels
};

/// real value = slope * stored value + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  bool operator==(const Rescale&) const = default;
  double to_real(double stored) const { return slope * stored + intercept; }
  bool is_identity() const { return slope == 1 && intercept == 0; }
};

/// True when the slope is not 0 and the real values of all voxels of `type` are finite.
bool is_valid(const Rescale& rescale, VoxelType type) noexcept;

struct VolumeDescription {
  VolumeKind kind = VolumeKind::grey;
  VoxelType type = VoxelType::uint8;
  Size3 size;
  Geometry geometry;
  Rescale rescale;
  Metadata metadata;  ///< where the voxels are from and what was done to them
  /// Of a float32 volume in a file: how its bricks hold it. What other sources give is a hint.
  std::optional<SampleCoding> coding;
  /// Of a source: a stored value that is no measurement. Files do not hold it.
  std::optional<std::int64_t> padding;

  /// The type of the numbers in the index, and in bricks.
  VoxelType coded_type() const { return coding ? coding->type : type; }
  /// The type of what codecs take and give: float32 where its coding is exact, else that of the
  /// numbers in bricks.
  VoxelType codec_type() const { return coding && coding->is_exact ? type : coded_type(); }
  /// What ends of ranges in the index lie within.
  ValueRange coded_range() const {
    if (coding && coding->is_exact) return {-SampleCoding::kUnbounded, SampleCoding::kUnbounded};
    return value_range(coded_type());
  }
  /// Whether an end of a range in the index is none: of exact floats one may lie beyond all codes,
  /// nobody knows how far.
  bool is_unbounded(std::int64_t end) const {
    return coding && coding->is_exact &&
           (end == SampleCoding::kUnbounded || end == -SampleCoding::kUnbounded);
  }
  /// The number of voxels that is nearest to an end of a range: what coarse samples take those
  /// beyond it for.
  std::int64_t code_near(std::int64_t end) const {
    return is_unbounded(end) ? end - end / SampleCoding::kUnbounded : end;
  }
  /// The voxel that a number in bricks and index stands for.
  double voxel_of(std::int64_t code) const {
    return coding ? static_cast<double>(coding->voxel_of(code)) : static_cast<double>(code);
  }
};

/// Bytes of one plane of size.x * size.y voxels. Requires a size within the limits of levels.h.
std::uint64_t plane_bytes(const VolumeDescription& description);

}  // namespace octavo
