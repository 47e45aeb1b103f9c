// Masks straight from the bricks of a file.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/core/progress.h"
#include "octavo/core/work_part.h"
#include "octavo/file/reader.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/mask_build.h"

namespace octavo {

/// The planes [first, end) of a part: those of whole cells of 64 planes.
struct PlanesOfPart {
  std::int64_t first = 0;
  std::int64_t end = 0;
};
PlanesOfPart planes_of_part(std::int64_t plane_count, const WorkPart& part);

/// The voxels of a level whose values lie in one of `windows`, in stored units. At level 0 bricks
/// that their minimum and maximum decide are not decoded. Uses the threads of the calling task
/// arena.
/// max_bytes  0: no limit; otherwise Error{limit_exceeded} when the mask grows beyond it
/// part       only the planes of this part are read (planes_of_part); the others are empty
/// Throws what the reader throws, Error{cancelled}; Error{invalid_argument} for a level that is not
///        there
/// Memory  that of the mask twice over, and a brick per thread
MaskTree mask_of_file(const FileReader& reader, int level, std::span<const ValueWindow> windows,
                      Progress& progress, std::uint64_t max_bytes = 0,
                      const WorkPart& part = {});

}  // namespace octavo
