// What modes of render ask of rays.
#pragma once

#include "octavo/core/volume.h"
#include "octavo/render/rays/ray_bricks.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/tasks/pictures/render.h"

namespace octavo {

/// How rays go. Requires a mode that casts rays
RayMode ray_mode_of(RenderMode mode);

/// Whether rays look for low stored values: of extremes the lowest, of the others those that are
/// low as real values fall with them.
bool seeks_lowest(RenderMode mode, const Rescale& rescale);

/// What NaN is: empty space where colors and opacities are seen, to extremes what hides no other
/// value, else the lowest value.
NanPlace nan_place(RenderMode mode, const Rescale& rescale);

}  // namespace octavo
