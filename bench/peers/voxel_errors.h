// How far decoded voxels are from their source.
#pragma once

#include <cstdint>

#include "bench/common/raw_volume.h"

namespace octavo::bench {

struct VoxelErrors {
  std::int64_t max_error = 0;      ///< largest |decoded - source|, voxel units
  double mean_square = 0;          ///< of decoded - source, voxel units squared
};

/// Requires two volumes of one integer type and one size.
VoxelErrors errors_of(const RawVolume& source, const RawVolume& decoded);

/// Peak signal-to-noise ratio in dB; the peak is the span of the source's values. Infinite without
/// errors.
double psnr_db(const RawVolume& source, const VoxelErrors& errors);

}  // namespace octavo::bench
