// A surface with few triangles by merging cells of an octree (cell_merging.h), proven as that of
// decimation.h is.
//
// Where a triangle is not proven, or crosses another, the cells of its corners are divided again:
// the next round does not merge them, from the third on nothing in them. Since the full surface
// passes, this ends.
#pragma once

#include "octavo/mesh/decimation.h"

namespace octavo {

/// As decimate. Memory about 600 bytes per point of the full surface.
Decimated decimate_by_cells(const TriangleMesh& full, const DecimationOptions& options,
                            Progress& progress);

}  // namespace octavo
