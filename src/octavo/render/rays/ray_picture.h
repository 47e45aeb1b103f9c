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
  /// Its color where voxels have looks, `surface` being that of those without one; or none.
  std::function<Color(std::uint16_t look, const Color& otherwise)> surface_of;
  Window window;                    ///< extreme and mean: of real values
  Rescale to_real;                  ///< from pooled values
  float sign = 1;                   ///< extreme: that of the frame
};

/// Pooled values of the rays of modes extreme and mean that met a sample.
std::vector<double> ray_values(const RayField& field, RayMode mode, float sign);

/// A picture of three channels over a background.
Picture ray_picture(const RayField& field, const RayLook& look);

}  // namespace octavo
