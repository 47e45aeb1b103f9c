// Decimation far beyond the size of a voxel, in steps.
//
// Over a large deviation edges collapse so far that many places cannot be proven, and parts end as
// they were: a larger deviation would leave more triangles. So it is reached in steps that each
// begin with the surface of the one before. What lies within a of a surface that lies within b of
// the full one lies within a + b of that.
#pragma once

#include <cstdint>

#include "octavo/mesh/decimation.h"

namespace octavo {

/// The deviation of the first step: half the shortest side of a voxel.
double first_step_mm(const Geometry& geometry);

/// decimate of what is left of a surface of `full_count` triangles.
Decimated decimate_further(const TriangleMesh& base, std::uint64_t full_count, double deviation_mm,
                           const Geometry& geometry, Progress& progress);

/// As decimate, without locked points.
Decimated decimate_in_steps(const TriangleMesh& full, const DecimationOptions& options,
                            Progress& progress);

/// The further steps of a surface of `full_count` triangles that is proven within a deviation
/// already.
Decimated decimate_in_further_steps(Decimated reduced, double proven_mm, std::uint64_t full_count,
                                    const DecimationOptions& options, Progress& progress);

}  // namespace octavo
