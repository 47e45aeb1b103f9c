// A picture of rays by all ranks of a job: each casts those through octree nodes of its own, and
// the parts are composited in the order of the octants.
//
//     ranks            nodes in order, runs of own ones      -> tiles of colors and opacities
//     tiles / ranks    each composites a share of the tiles -> rank 0
//
// A rank reads only bricks that its own nodes need, and meets the meshes that lie in them. The
// picture is that of one machine, but for roundings and for rays that would have ended in front of
// another rank's nodes.
//
// Source  thesis 5; sort-last compositing: Molnar et al., A sorting classification of parallel
//         rendering (1994)
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "octavo/dist/communicator.h"
#include "octavo/render/rays/ray_caster.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Casts the rays of a picture. regions  in the order of front_to_back
using CastField =
    std::function<RayField(RayBricks& bricks, const RayFrame& frame,
                           std::span<const RayRegion> regions, std::int64_t width,
                           std::int64_t height)>;

/// Collective: what cast_rays gives, at rank 0; at the others a field without tiles.
/// Uses the threads of the caller's arena. Throws as cast_rays and Communicator
/// Memory  at each rank a field, and 16 bytes per pixel for each run of nodes that it sees
RayField cast_by_ranks(RayBricks& bricks, const RayFrame& frame,
                       std::span<const RayRegion> regions, std::int64_t width,
                       std::int64_t height, Communicator& ranks, const TaskContext& context);

}  // namespace octavo
