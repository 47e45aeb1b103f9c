// Which brick of a grid a layer of a ray belongs to.
//
//     samples    +-------+---|---+-------+        the part of the ray between two samples that a
//     bricks     |    a      :      b             layer cuts is taken in the brick where it begins,
//     layer                    |                  so this layer is a's
//
// Invariants
//   The brick is the one in whose region rays take that part, bit for bit as span_of has it. What
//   lies outside the grid belongs to the brick that the nearest sample of the grid lies in.
// Consequences
//   Bricks shared out as octree nodes and crossed in order, each with its own layers, give what
//   rays give that cross all of them and all layers: nodes are parted by whole planes, which part
//   what lies outside as well.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_layers.h"
#include "octavo/render/rays/ray_regions.h"

namespace octavo {

class LayerBricks {
 public:
  /// frame    of mode volume, with its camera and the tables of bricks; must outlive this
  /// regions  that rays cross, or all that they are parts of
  LayerBricks(const RayFrame& frame, std::span<const RayRegion> regions);

  /// Of each layer of a tile, bricks numbered x fastest.
  /// first_pixel  of the tile, as first_pixel_of gives it
  std::vector<std::int32_t> of_tile(const TileLayers& layers,
                                    const std::array<float, 2>& first_pixel) const;

 private:
  const RayFrame& frame_;
  std::vector<RayRegion> wholes_;  // boxes that the regions are parts of
};

}  // namespace octavo
