// Between which steps the rays of a picture can meet anything at all.
//
//     boxes of cubes with something in them  ->  the blocks of 4 x 4 pixels that each covers
//     of a block                             ->  the first and the last step in any of its boxes
//
// A brick that is not in memory counts as a whole. What is full is one box, however many cubes it
// has.
//
// Invariants
//   Before `first` and behind `last` there is nothing, at no step and between no two.
// Consequences
//   Rays that begin and end there gather what they would gather otherwise. Bricks that come into
//   memory later make spans no wider.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/render/rays/ray_job.h"

namespace octavo {

inline constexpr std::size_t kTileSpans = kTileRays / kSpanRays;

class OccupiedSpans {
 public:
  /// frame  with camera and bricks; of modes volume and iso
  /// Memory  16 bytes a block, and 8 for each thread of the caller's arena
  OccupiedSpans(const RayFrame& frame, std::int64_t width, std::int64_t height);

  /// Those of a tile, in the order of its rays.
  const OccupiedSpan* of_tile(std::size_t number) const {
    return spans_.data() + number * kTileSpans;
  }
  /// Whether a ray of a tile can meet anything.
  bool is_any_in(std::size_t number) const;

 private:
  std::vector<OccupiedSpan> spans_;  // by tile
};

}  // namespace octavo
