// Rays through a volume, tile by tile and from brick to brick.
//
//     each tile      follow its rays until each is done or waits for a brick that is not in memory
//     all together   load bricks that rays wait for, the nearest first; again, until none waits
//
// Where they cross several regions they do so with one after the other.
//
// A brick that no ray comes to is never read: not what is empty, not what lies behind what is
// opaque.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/render/rays/large_pages.h"
#include "octavo/render/rays/ray_bricks.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_layers.h"
#include "octavo/render/rays/ray_regions.h"

namespace octavo {

using RayTiles = std::vector<RayTile, KeptAllocator<RayTile>>;

/// What the rays of a picture have gathered.
struct RayField {
  std::int64_t width = 0;
  std::int64_t height = 0;
  RayTiles tiles;  ///< row by row, as far as they have rays that are cast
  std::vector<std::size_t> numbers;  ///< of the tiles in the picture; none: all are there
  /// Of the frame's meshes, by tile; none without meshes, or where the frame has layers itself.
  std::vector<TileLayers> layers;
  /// Taken. Rays that go together in vectors take samples that some of them would skip and leave
  /// others out, so that the count depends on the instruction set, as what rays gather does not.
  std::int64_t samples = 0;
  double cast_seconds = 0;     ///< following rays
  std::int64_t loaded_elsewhere = 0;  ///< bricks of other ranks

  std::size_t number_of(std::size_t tile) const { return numbers.empty() ? tile : numbers[tile]; }
  std::int64_t tile_columns() const { return tiles_along(width); }

  /// Calls visit(column, row, tile, ray) for each pixel, tile by tile.
  template <class Visit>
  void for_each_pixel(Visit&& visit) const;
};

/// Column and row of the middle of the first pixel of a tile, from the middle of the picture.
std::array<float, 2> first_pixel_of(std::size_t tile, std::int64_t width, std::int64_t height);

/// Bytes of a field.
std::uint64_t ray_field_bytes(std::int64_t width, std::int64_t height);

/// Casts the rays of one picture on the threads of the caller's arena.
/// frame   with camera, mode, table and meshes; the tables of bricks are those of `bricks`
/// follow  one of follow_rays_function
/// Throws  Error{cancelled}, and what reading bricks and RayMeshes throw
/// Memory  ray_field_bytes, besides bricks and what meshes take
RayField cast_rays(RayBricks& bricks, RayFrame frame, std::int64_t width, std::int64_t height,
                   FollowRays follow, const Progress& watcher);

/// The same through regions in place of the frame's box.
/// regions  in the order of front_to_back; none: rays meet nothing but layers
RayField cast_rays(RayBricks& bricks, RayFrame frame, std::span<const RayRegion> regions,
                   std::int64_t width, std::int64_t height, FollowRays follow,
                   const Progress& watcher);

template <class Visit>
void RayField::for_each_pixel(Visit&& visit) const {
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const auto number = static_cast<std::int64_t>(number_of(t));
    const std::int64_t left = number % tile_columns() * kRayTileSide;
    const std::int64_t top = number / tile_columns() * kRayTileSide;
    for (std::size_t i = 0; i < kTileRays; ++i) {
      const std::int64_t column = left + static_cast<std::int64_t>(kTileOrder.column[i]);
      const std::int64_t row = top + static_cast<std::int64_t>(kTileOrder.row[i]);
      if (column < width && row < height) visit(column, row, tiles[t], i);
    }
  }
}

}  // namespace octavo
