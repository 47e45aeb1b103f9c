// Points of a surface that lie at the place of another one.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// How many points have an equal one before them; 0 and -0 are equal.
/// Requires fewer than 2^32 points, and no NaN.
/// Uses the threads of the calling task arena. Memory  12 bytes per point; time linear in them
std::uint64_t coincident_points(std::span<const MeshPoint> points);

}  // namespace octavo
