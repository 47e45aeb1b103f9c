// How far two surfaces lie apart, proven.
#pragma once

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// A distance within which each of two surfaces is proven to lie of the other (certificate.h): no
/// larger than `known`, which must be such a distance, and a twentieth or so above the smallest.
/// margin  for rounding, added to what is proven
/// Uses the threads of the calling task arena. Throws Error{cancelled}
/// Memory  34 to 40 bytes per triangle, and 40 per point of the larger surface
double measured_deviation(const TriangleMesh& a, const TriangleMesh& b, double known,
                          double margin, const Progress& progress);

}  // namespace octavo
