// What is missing to read boxes of a level, and how it is fetched.
#pragma once

#include <functional>
#include <span>

#include "octavo/core/box.h"
#include "octavo/file/open_file.h"
#include "octavo/file/read_plan.h"

namespace octavo {

/// Whether the voxels that a box shares with a brick are kept decoded.
/// part  in samples of the level that is read
using IsDecoded = std::function<bool(const BrickEntry& entry, const Box& part)>;

/// As FileReader::ranges_of, for several boxes; bricks that are kept decoded need nothing.
/// Requires boxes inside the level. Complexity O(bricks)
ReadPlan plan_of_boxes(const OpenFile& file, std::span<const Box> boxes, int level,
                       const JoinLimits& limits, const IsDecoded& is_decoded);

/// As FileReader::fetch, but for those bricks that are kept decoded.
bool fetch_boxes(const OpenFile& file, std::span<const Box> boxes, int level,
                 const IsDecoded& is_decoded);

/// As FileReader::for_fetched, but for those bricks that are kept decoded.
void for_fetched(const OpenFile& file, const Box& box, int level, const IsDecoded& is_decoded,
                 const std::function<void(const Box& part)>& read);

}  // namespace octavo
