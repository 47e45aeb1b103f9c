// Polygons that rays meet: a list of layers for each ray, in order, and how rays go on behind one.
//
//     ray     --- samples ---> | layer | --- samples ---> | layer | --- samples --->
//
// Invariants
//   The opacity of a layer is what it takes of what reaches it on average over the pixel: layers
//   composited one after the other give what 16 places in the pixel give on average, whatever lies
//   between them.
//   Where a layer cuts the part of a ray between two samples, one part ends at it and the other
//   begins there.
// Consequences
//   Edges are smooth, and triangles that share one leave no seam. A surface that runs through fog
//   at an angle has no steps in it.
//
// Source  thesis 4.4, 5; the layers of a pixel: Carpenter, The A-buffer (1984)
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/render/rays/ray_job.h"

namespace octavo {

struct RayLayer {
  float k = 0;              ///< where it lies along the ray, in steps; may be below 0
  float opacity = 0;
  std::uint32_t color = 0;  ///< in light, 0xbbggrr
};

/// The layers of the rays of a tile.
struct TileLayers {
  std::vector<std::uint32_t> begins;  ///< by ray, and the end of the last; empty: no ray has any
  std::vector<RayLayer> layers;       ///< ray after ray, the nearest first

  bool is_empty() const { return layers.empty(); }
};

/// What is left of `behind`, colors of 0 .. 1, with the layers of a ray that lie before k in front
/// of it.
std::array<double, 3> seen_through(const TileLayers& layers, std::size_t ray, double k,
                                   const std::array<double, 3>& behind);

/// Follows the rays of a tile through its layers, of modes volume and iso; of other modes as if
/// there were none. Rays that wait for a brick go on with the next call.
/// stops  one for the tile, the same with each call
std::int64_t follow_through_layers(const RayFrame& frame, RayTile& tile, const TileLayers& layers,
                                   RayStops& stops, FollowRays follow);

}  // namespace octavo
