// Which way a slice is drawn. A slice is never turned by an angle: index axes become picture axes,
// in the order and direction that come nearest to the radiological convention.
#pragma once

#include <array>

#include "octavo/core/geometry.h"

namespace octavo {

/// How the two index axes of a slice lie in its picture.
///
///   across \ down   convention                                picture
///   axial           right of patient left, anterior up        +x right, +y down
///   coronal         right of patient left, superior up        +x right, -z down
///   sagittal        anterior left, superior up                +y right, -z down
struct SliceOrientation {
  int across = 0;             ///< index axis that runs along picture rows
  int down = 1;               ///< index axis that runs along picture columns
  bool flips_across = false;  ///< the index falls to the right
  bool flips_down = false;
};

/// The orientation of slices across index axis `axis`. Each index axis stands for the world axis it
/// is nearest to, all three for different ones.
SliceOrientation slice_orientation(const Geometry& geometry, int axis);

}  // namespace octavo
