// Every piece of every brick of a file.
#pragma once

#include <vector>

#include "octavo/file/reader.h"

namespace octavo::testing {

struct BrickPiece {
  BrickEntry entry;  ///< of the brick
  int level = 0;     ///< of its finest segment
  BrickEntry::StoredPiece piece;  ///< never empty
};

inline std::vector<BrickPiece> pieces_of(const FileReader& reader) {
  std::vector<BrickPiece> pieces;
  for (int tier = 0; tier < reader.levels().tier_count(); ++tier) {
    const Size3 grid = reader.levels().brick_grid(tier);
    for (std::int64_t i = 0; i < grid.voxel_count(); ++i) {
      const BrickEntry entry =
          reader.brick(tier, {i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)});
      for (std::size_t k = 0; k < entry.pieces.size(); ++k) {
        if (entry.pieces[k].length == 0) continue;
        pieces.push_back(
            {entry, Levels::first_level(tier) + static_cast<int>(k), entry.pieces[k]});
      }
    }
  }
  return pieces;
}

}  // namespace octavo::testing
