// How much of the surroundings of each voxel is of the other class.
#pragma once

#include "octavo/ops/distance/distance_passes.h"
#include "octavo/ops/distance/site_lines.h"

namespace octavo {

/// Writes class and share of the voxels of planes [begin, end) to `sites`, [z][y][x]. Shares are
/// averages over 5 x 5 x 5 voxels, weighted by 6, 58, 128, 58, 6 along each axis; beyond the border
/// of the volume its outermost voxels go on.
/// Memory  9 bytes for each voxel of the planes and of two on both sides
void fill_shares(const InsideVoxels& voxels, std::int64_t begin, std::int64_t end,
                 NearestSite* sites);

/// How far the surface passes before a site, in voxels, for a share; below 0 behind it.
double surface_gap(std::uint8_t share);

}  // namespace octavo
