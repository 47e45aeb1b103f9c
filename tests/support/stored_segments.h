// Every stretch of bytes that a file holds for one brick at one level.
#pragma once

#include <vector>

#include "octavo/file/reader.h"

namespace octavo::testing {

struct StoredSegment {
  BrickEntry entry;  ///< of the brick
  int level = 0;
  BrickEntry::Segment segment;  ///< of its bytes; never empty
};

inline std::vector<StoredSegment> segments_of(const FileReader& reader) {
  std::vector<StoredSegment> segments;
  for (int tier = 0; tier < reader.levels().tier_count(); ++tier) {
    const Size3 grid = reader.levels().brick_grid(tier);
    for (std::int64_t i = 0; i < grid.voxel_count(); ++i) {
      const BrickEntry entry =
          reader.brick(tier, {i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)});
      for (std::size_t level = 0; level < entry.segments.size(); ++level) {
        if (entry.segments[level].length == 0) continue;
        segments.push_back({entry, Levels::first_level(tier) + static_cast<int>(level),
                            entry.segments[level]});
      }
    }
  }
  return segments;
}

}  // namespace octavo::testing
