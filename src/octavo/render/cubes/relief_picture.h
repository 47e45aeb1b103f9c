// Masks as cubes whose faces are shaded as if the surface were smooth.
//
// A pixel is given to a face exactly as in the picture with three shades. Its normal is not that of
// the face but the gradient of a field, taken a little before the place where the ray
// of the pixel meets the face:
//
//     nearest faces -> per pixel: mask, axis, plane -> point before the face -> gradient -> light
//
// The points of a band of rows are sorted by cubes of 16^3 samples; in each the field is smoothed
// once, for as many points as lie there. The picture has four points per pixel.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/render/cubes/cube_picture.h"
#include "octavo/render/cubes/relief_field.h"

namespace octavo {

/// What draw_relief holds at once beside the picture, on `threads` threads.
std::uint64_t relief_memory_bytes(std::int64_t width, std::int64_t height, int threads);

/// Draws the leaves of masks that are seen, in three channels.
/// field  on the grid of the view
/// kept   what of the grid was cut out of the object; a face on its border is shaded as it is
/// Otherwise as draw_nearest_cubes. Throws what `field` throws.
/// Memory  relief_memory_bytes beside the picture
Picture draw_relief(std::span<const PaintedMask> masks, const View& view, const CubeStyle& style,
                    const ReliefField& field, const Box& kept);

}  // namespace octavo
