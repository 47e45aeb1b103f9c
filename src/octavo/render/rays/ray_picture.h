// From what rays have gathered to pixels.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/render/picture.h"
#include "octavo/render/rays/ray_caster.h"
#include "octavo/render/window.h"

namespace octavo {

struct RayLook {
  RayMode mode = RayMode::volume;
  Color background = kBlack;
  Color surface = {236, 222, 196};  ///< of an isosurface
  /// Its color where voxels have looks; `otherwise` is that of those without one. Or none.
  std::function<Color(std::uint16_t look, const Color& otherwise)> surface_of;
  Window window;                    ///< extreme and mean: of real values
  Rescale to_real;                  ///< from pooled values
  float sign = 1;                   ///< extreme: that of the frame
};

/// Pooled values of the rays of modes extreme and mean that met a sample.
std::vector<double> ray_values(const RayField& field, RayMode mode, float sign);

/// Calls visit(column, row, color) for each pixel of the tiles of a field, tile by tile; the rays
/// of 2 x 2 pixels follow each other.
void visit_ray_colors(
    const RayField& field, const RayLook& look,
    const std::function<void(std::int64_t, std::int64_t, const Color&)>& visit);

/// A picture of three channels over a background.
Picture ray_picture(const RayField& field, const RayLook& look);

}  // namespace octavo
