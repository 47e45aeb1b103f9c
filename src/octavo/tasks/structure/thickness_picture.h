// Histograms of local thickness and separation, as a picture.
#pragma once

#include "octavo/ops/morphometry/local_thickness.h"
#include "octavo/render/picture.h"

namespace octavo {

/// Shares of the voxels by thickness, mm, a panel each; the mean is a line. A summary without
/// voxels gets no panel; without any the picture says so.
Picture thickness_picture(const ThicknessSummary& thickness, const ThicknessSummary& spacing);

}  // namespace octavo
