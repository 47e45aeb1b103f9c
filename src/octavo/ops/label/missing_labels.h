// Which labels a volume has none of.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"

namespace octavo {

/// Those of some labels that no voxel of a level has. Bricks of one label are not decoded, nor
/// those whose range holds none that is still to be found. Uses the threads of the calling task
/// arena.
/// labels  ascending, each once
/// Requires a label map, a level that is there
/// Throws  what the reader throws; Error{cancelled}
/// Memory  a brick per thread
std::vector<std::int64_t> missing_labels(const FileReader& reader, int level,
                                         std::span<const std::int64_t> labels,
                                         const Progress& watcher);

}  // namespace octavo
