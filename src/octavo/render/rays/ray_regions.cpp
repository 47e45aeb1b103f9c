#include "octavo/render/rays/ray_regions.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace octavo {

namespace {

/// A plane between regions.
struct RegionPlane {
  std::size_t axis = 0;
  float at = 0;
  std::size_t cut = 0;      // regions on both sides of it
  std::size_t balance = 0;  // of the smaller side
};

RegionPlane weighed(const std::vector<RayRegion>& regions, std::size_t axis, float at) {
  std::size_t below = 0;
  std::size_t above = 0;
  for (const RayRegion& region : regions) {
    if (region.low[axis] < at) ++below;
    if (region.high[axis] > at) ++above;
  }
  return {axis, at, below + above - regions.size(), std::min(below, above)};
}

/// The one that cuts the fewest regions, and then parts them the most evenly.
std::optional<RegionPlane> best_plane(const std::vector<RayRegion>& regions) {
  std::optional<RegionPlane> best;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<float> faces;
    for (const RayRegion& region : regions) {
      faces.push_back(region.low[axis]);
      faces.push_back(region.high[axis]);
    }
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    for (const float at : faces) {
      const RegionPlane plane = weighed(regions, axis, at);
      if (plane.balance == 0) continue;
      const bool is_better = !best || plane.cut < best->cut ||
                             (plane.cut == best->cut && plane.balance > best->balance);
      if (is_better) best = plane;
    }
  }
  return best;
}

bool is_low_side_first(const RayFrame& frame, const RegionPlane& plane) {
  if (frame.eye_pixels > 0) return frame.origin[plane.axis] < plane.at;
  return frame.direction[plane.axis] > 0;
}

void visit_in_order(std::vector<RayRegion> regions, const RayFrame& frame,
                    std::vector<RayRegion>& out) {
  const auto plane = regions.size() > 1 ? best_plane(regions) : std::nullopt;
  if (!plane) {
    out.insert(out.end(), regions.begin(), regions.end());
    return;
  }
  std::vector<RayRegion> low;
  std::vector<RayRegion> high;
  for (const RayRegion& region : regions) {
    if (region.low[plane->axis] < plane->at) {
      low.push_back(region);
      low.back().high[plane->axis] = std::min(region.high[plane->axis], plane->at);
    }
    if (region.high[plane->axis] > plane->at) {
      high.push_back(region);
      high.back().low[plane->axis] = std::max(region.low[plane->axis], plane->at);
    }
  }
  const bool is_low_first = is_low_side_first(frame, *plane);
  visit_in_order(std::move(is_low_first ? low : high), frame, out);
  visit_in_order(std::move(is_low_first ? high : low), frame, out);
}

}  // namespace

RayRegion region_of(const Box& voxels) {
  RayRegion region;
  for (int axis = 0; axis < 3; ++axis) {
    region.low[static_cast<std::size_t>(axis)] = static_cast<float>(voxels.lo[axis]) - 0.5f;
    region.high[static_cast<std::size_t>(axis)] = static_cast<float>(voxels.hi[axis]) - 0.5f;
  }
  region.whole_low = region.low;
  region.whole_high = region.high;
  return region;
}

RayRegion region_at_level(const Box& voxels, const Levels& levels, int level) {
  RayRegion region;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const int halvings = levels.halving_count(level, axis);
    region.low[i] = std::ldexp(static_cast<float>(voxels.lo[axis]), -halvings) - 0.5f;
    region.high[i] = std::ldexp(static_cast<float>(voxels.hi[axis]), -halvings) - 0.5f;
  }
  region.whole_low = region.low;
  region.whole_high = region.high;
  return region;
}

RayRegion region_within(const RayRegion& region, const RayRegion& outer) {
  RayRegion part = region;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part.low[axis] = std::max(region.low[axis], outer.low[axis]);
    part.high[axis] = std::min(region.high[axis], outer.high[axis]);
    part.whole_low[axis] = std::max(region.whole_low[axis], outer.low[axis]);
    part.whole_high[axis] = std::min(region.whole_high[axis], outer.high[axis]);
  }
  return part;
}

KeptVoxels::KeptVoxels(const Box& kept, std::span<const Box> removed, const Size3& size) {
  for (const Box& box : removed) {
    if (box.is_empty()) continue;
    RayCuts::Hole hole;
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const std::int64_t before = box.lo[axis] - 1;
      const std::int64_t behind = box.hi[axis];
      hole.before[i] = before >= 0 ? static_cast<float>(before) : -kRayDone;
      hole.behind[i] = behind < size[axis] ? static_cast<float>(behind) : kRayDone;
    }
    holes_.push_back(hole);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    cuts_.first[i] = static_cast<float>(kept.lo[axis]);
    cuts_.last[i] = static_cast<float>(kept.hi[axis] - 1);
  }
  cuts_.holes = holes_.data();
  cuts_.hole_count = holes_.size();
  is_all_ = kept == box_of(size) && holes_.empty();
}

std::vector<Box> without_boxes(const Box& whole, std::span<const Box> removed) {
  std::vector<Box> left = {whole};
  for (const Box& box : removed) {
    std::vector<Box> smaller;
    for (Box rest : left) {
      const Box hole = intersection(rest, box);
      if (hole.is_empty()) {
        smaller.push_back(rest);
        continue;
      }
      // What lies below and above the hole along one axis after the other.
      for (int axis = 2; axis >= 0; --axis) {
        Box below = rest;
        Box above = rest;
        below.hi[axis] = rest.lo[axis] = hole.lo[axis];
        above.lo[axis] = rest.hi[axis] = hole.hi[axis];
        if (!below.is_empty()) smaller.push_back(below);
        if (!above.is_empty()) smaller.push_back(above);
      }
    }
    left = std::move(smaller);
  }
  return left;
}

std::vector<RayRegion> front_to_back(std::vector<RayRegion> regions, const RayFrame& frame) {
  std::vector<RayRegion> ordered;
  visit_in_order(std::move(regions), frame, ordered);
  return ordered;
}

}  // namespace octavo
