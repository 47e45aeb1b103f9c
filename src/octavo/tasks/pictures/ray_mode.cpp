#include "octavo/tasks/pictures/ray_mode.h"

namespace octavo {

RayMode ray_mode_of(RenderMode mode) {
  switch (mode) {
    case RenderMode::mip:
    case RenderMode::minip: return RayMode::extreme;
    case RenderMode::mean: return RayMode::mean;
    case RenderMode::iso: return RayMode::iso;
    default: return RayMode::volume;
  }
}

bool seeks_lowest(RenderMode mode, const Rescale& rescale) {
  return (rescale.slope < 0) != (mode == RenderMode::minip);
}

NanPlace nan_place(RenderMode mode, const Rescale& rescale) {
  if (mode == RenderMode::volume) return NanPlace::nothing;
  const bool is_extreme = ray_mode_of(mode) == RayMode::extreme;
  return is_extreme && seeks_lowest(mode, rescale) ? NanPlace::highest : NanPlace::lowest;
}

}  // namespace octavo
