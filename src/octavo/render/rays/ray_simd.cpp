// Rays on vectors, for every instruction set that Highway knows, chosen at run time.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "octavo/codec/simd_level.h"
#include "octavo/render/rays/ray_job.h"

#include "octavo/codec/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/render/rays/ray_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "octavo/render/rays/ray_packet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

std::int64_t follow_rays(const RayFrame& frame, RayTile& tile) {
  return follow_rays_portable(frame, tile);
}

#else

std::int64_t follow_rays(const RayFrame& frame, RayTile& tile) {
  return with_ray_mode(frame, [&](auto mode, auto is_wide) HWY_ATTR {
    constexpr RayMode kMode = decltype(mode)::value;
    constexpr bool kIsWide = decltype(is_wide)::value;
    // Extremes alone are found sooner where no code for cuts stands between the rest.
    if constexpr (kMode == RayMode::extreme) {
      if (frame.cuts == nullptr) return follow_packets<kMode, kIsWide, false>(frame, tile);
    }
    return follow_packets<kMode, kIsWide, true>(frame, tile);
  });
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo {

HWY_EXPORT(follow_rays);

namespace {

FollowRays ray_function_of(std::int64_t targets) {
  if (targets == 0) return follow_rays_portable;
  const SimdTargetsInUse in_use(targets);
  return HWY_DYNAMIC_DISPATCH(follow_rays);
}

}  // namespace

FollowRays follow_rays_function() {
  static const FollowRays function = ray_function_of(chosen_simd_targets());
  return function;
}

std::optional<FollowRays> follow_rays_function_of(std::string_view level) {
  if (level == "scalar") return follow_rays_portable;
  const std::int64_t targets = simd_targets_of(level);
  if (targets == 0) return std::nullopt;
  return ray_function_of(targets);
}

}  // namespace octavo
#endif
