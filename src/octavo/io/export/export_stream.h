// Brick layer by brick layer out of a file, as the bytes a target wants.
#pragma once

#include "octavo/io/export/export_target.h"

namespace octavo {

/// Reads the plan's box in layers of whole bricks, decoding on `threads` threads (0: all cores),
/// and hands the planes to `target`.
/// Throws Error{cancelled}; Error{corrupt} when a voxel lies outside the range the file declares;
///        what reader and target throw
/// Memory that of one layer
void stream_planes(const FileReader& reader, const ExportPlan& plan, int threads,
                   ExportTarget& target, Progress& progress);

}  // namespace octavo
