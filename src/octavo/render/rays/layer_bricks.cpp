#include "octavo/render/rays/layer_bricks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "octavo/render/rays/ray_line.h"

namespace octavo {

namespace {

/// Where a ray comes into one of several boxes.
std::vector<float> box_entries(const RayLine& ray, std::span<const RayRegion> boxes) {
  std::vector<float> entries;
  for (const RayRegion& box : boxes) {
    float enter = ray.start;
    float leave = std::numeric_limits<float>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float low = (box.low[axis] - ray.origin[axis]) * ray.inverse[axis];
      const float high = (box.high[axis] - ray.origin[axis]) * ray.inverse[axis];
      enter = std::max(enter, std::min(low, high));
      leave = std::min(leave, std::max(low, high));
    }
    if (enter <= leave) entries.push_back(enter);
  }
  return entries;
}

/// Where the part of a ray begins that lies around k: at a sample, or where it comes into a box.
float part_begin(float k, std::span<const float> entries) {
  float begin = std::floor(k);
  for (const float entry : entries) {
    if (entry <= k) begin = std::max(begin, entry);
  }
  return begin;
}

/// The brick along one axis in whose faces k lies.
std::int32_t brick_along(const BrickTables& bricks, const RayLine& ray, std::size_t axis,
                         float k) {
  const std::int32_t last = bricks.grid[axis] - 1;
  const bool rises = ray.step[axis] > 0;
  const auto has_passed = [&](std::int32_t face) {
    const auto place = static_cast<float>(face << bricks.shift);
    return k >= (place - ray.origin[axis]) * ray.inverse[axis];
  };
  const float place = ray.origin[axis] + k * ray.step[axis];
  const float most = static_cast<float>(last) * static_cast<float>(1 << bricks.shift);
  std::int32_t brick =
      static_cast<std::int32_t>(std::clamp(place, 0.0f, most)) >> bricks.shift;
  // Faces are where the ray crosses them, whatever its place was rounded to.
  while (brick > 0 && has_passed(brick) != rises) --brick;
  while (brick < last && has_passed(brick + 1) == rises) ++brick;
  return brick;
}

}  // namespace

LayerBricks::LayerBricks(const RayFrame& frame, std::span<const RayRegion> regions)
    : frame_(frame) {
  for (const RayRegion& region : regions) {
    const RayRegion whole{region.whole_low, region.whole_high, region.whole_low,
                          region.whole_high};
    if (std::find(wholes_.begin(), wholes_.end(), whole) == wholes_.end()) {
      wholes_.push_back(whole);
    }
  }
}

std::vector<std::int32_t> LayerBricks::of_tile(const TileLayers& layers,
                                               const std::array<float, 2>& first_pixel) const {
  std::vector<std::int32_t> bricks(layers.layers.size());
  for (std::size_t i = 0; i < kTileRays && !layers.is_empty(); ++i) {
    if (layers.begins[i] == layers.begins[i + 1]) continue;
    const RayLine ray = with_inverse(ray_at(frame_, first_pixel[0] + kTileOrder.column[i],
                                            first_pixel[1] + kTileOrder.row[i]));
    const std::vector<float> entries = box_entries(ray, wholes_);
    for (std::uint32_t at = layers.begins[i]; at < layers.begins[i + 1]; ++at) {
      const float begin = part_begin(layers.layers[at].k, entries);
      std::int32_t number = 0;
      for (const std::size_t axis : {2u, 1u, 0u}) {
        number = number * frame_.bricks.grid[axis] +
                 brick_along(frame_.bricks, ray, axis, begin);
      }
      bricks[at] = number;
    }
  }
  return bricks;
}

}  // namespace octavo
