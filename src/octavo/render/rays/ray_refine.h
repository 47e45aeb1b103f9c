// Pictures of fewer rays, and of more of them where one a pixel is not enough.
//
//     adaptive      one ray for 2 x 2 pixels; blocks of 4 x 4 pixels in and around which these
//                   differ are cast ray by ray, the others are interpolated
//     smooth edges  pixels that differ much from one of their neighbors are the mean of 2 x 2 rays
//
// Which blocks and pixels these are depends on colors alone, so the picture does not depend on
// threads, bricks or memory.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "octavo/render/picture.h"
#include "octavo/render/rays/ray_caster.h"
#include "octavo/render/rays/ray_picture.h"

namespace octavo {

struct RayRefinement {
  bool is_adaptive = false;
  bool has_smooth_edges = false;
};

/// The same frame with `factor` times as many pixels along each side; 2 or 1/2.
RayFrame frame_of_pixels(const RayFrame& frame, float factor);

/// Casts the rays of a frame.
using CastFrame =
    std::function<RayField(const RayFrame& frame, std::int64_t width, std::int64_t height)>;
/// How a field is seen; called for the first one alone.
using LookOfField = std::function<RayLook(const RayField& field)>;

/// Blocks of 4 x 4 pixels by tile, as RayFrame::chosen has them, whose rays differ.
/// quarter  the picture with half as many pixels along each side
std::vector<std::uint64_t> varying_blocks(const Picture& quarter, std::int64_t width,
                                          std::int64_t height);

/// A picture of three channels; none where the field of `cast` has no tiles.
/// frame  of width x height pixels
Picture refined_picture(const RayFrame& frame, std::int64_t width, std::int64_t height,
                        const RayRefinement& how, const CastFrame& cast,
                        const LookOfField& look_of);

}  // namespace octavo
