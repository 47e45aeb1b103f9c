// The points of a net moved towards smooth surfaces, each within half a voxel of its corner.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/mesh/nets/surface_net.h"

namespace octavo {

/// How far a point lies from its corner, in voxels along each axis.
using NetOffset = std::array<float, 3>;

/// Moves every point `steps` times towards the mean of the points beside it and back out again,
/// which smooths and keeps volumes; points on lines along which three labels or more meet, towards
/// the next points on these lines alone. Uses the threads of the calling task arena.
/// Memory  80 bytes per point
/// Source  G. Taubin, A Signal Processing Approach to Fair Surface Design, 1995
std::vector<NetOffset> smoothed_offsets(const SurfaceNet& net, int steps);

/// Of each label but 0 the longest way of a point of its surface from its corner.
/// offsets  empty: points have not moved
std::map<std::int64_t, double> longest_moves_mm(const SurfaceNet& net,
                                                const std::vector<NetOffset>& offsets,
                                                const Geometry& geometry);

}  // namespace octavo
