// The net of a label map, out of the bricks of a file, a layer of blocks at a time.
//
// Source  S. F. Frisken Gibson, Constrained Elastic Surface Nets, 1998
#pragma once

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/mesh/nets/surface_net.h"
#include "octavo/mesh/surface_frame.h"

namespace octavo {

/// Gives the net of a level to `sink`. Quads are turned so that they are seen counterclockwise from
/// outside in world space, also where the grid is mirrored. The order of all depends on the volume
/// alone. Bricks of one label are not decoded. Uses the threads of the calling task arena.
/// Throws  what reader and sink throw, Error{cancelled}; Error{limit_exceeded} for 2^32 points or
///         more; Error{invalid_argument} for a level that is not there, and for grey values
/// Memory  that of the net in two layers of 64 planes, 64 kB for each block of 64^3 voxels there
///         that it runs through, and 3 MB per thread; besides the reader's cache
void extract_net(const FileReader& reader, int level, NetSink& sink, Progress& progress);

}  // namespace octavo
