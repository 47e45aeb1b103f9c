// Rays one by one: what the functions on vectors compute, step for step.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "octavo/render/rays/mesh_shadow.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_line.h"

namespace octavo {

namespace {

template <bool kIsWide>
float sample_at(const BrickTables& bricks, std::int32_t at) {
  if constexpr (kIsWide) return static_cast<const float*>(bricks.samples)[at];
  else return static_cast<float>(static_cast<const std::int16_t*>(bricks.samples)[at]);
}

float ray_mixed(float a, float b, float share) { return a + (b - a) * share; }

/// What stands around a place: the sample before it along each axis and the shares of the next.
struct SampleCorner {
  std::int32_t at = 0;
  RayPlace share{};
};

template <bool kIsWide>
float row_value(const BrickTables& b, std::int32_t at, float share) {
  return ray_mixed(sample_at<kIsWide>(b, at), sample_at<kIsWide>(b, at + 1), share);
}

template <bool kIsWide>
float value_at(const BrickTables& b, const SampleCorner& c) {
  const auto row = [&](std::int32_t at) { return row_value<kIsWide>(b, at, c.share[0]); };
  const float near = ray_mixed(row(c.at), row(c.at + b.row), c.share[1]);
  const float far = ray_mixed(row(c.at + b.plane), row(c.at + b.plane + b.row), c.share[1]);
  return ray_mixed(near, far, c.share[2]);
}

/// The look of the voxel nearest to a place.
std::uint16_t look_at(const BrickTables& b, const SampleCorner& c) {
  std::int32_t at = c.at;
  if (c.share[0] >= 0.5f) at += 1;
  if (c.share[1] >= 0.5f) at += b.row;
  if (c.share[2] >= 0.5f) at += b.plane;
  return b.looks[at];
}

/// Differences over two samples, straight between samples.
template <bool kIsWide>
RayPlace gradient_at(const BrickTables& b, const SampleCorner& c) {
  const auto along = [&](std::int32_t stride) {
    const auto slope = [&](std::int32_t at) {
      return sample_at<kIsWide>(b, at + stride) - sample_at<kIsWide>(b, at - stride);
    };
    const auto row = [&](std::int32_t at) {
      return ray_mixed(slope(at), slope(at + 1), c.share[0]);
    };
    const float near = ray_mixed(row(c.at), row(c.at + b.row), c.share[1]);
    const float far = ray_mixed(row(c.at + b.plane), row(c.at + b.plane + b.row), c.share[1]);
    return ray_mixed(near, far, c.share[2]);
  };
  return {along(1), along(b.row), along(b.plane)};
}

/// Differences within the cell of a place, twice.
template <bool kIsWide>
RayPlace cell_gradient_at(const BrickTables& b, const SampleCorner& c) {
  const auto row = [&](std::int32_t by) { return row_value<kIsWide>(b, c.at + by, c.share[0]); };
  const auto slope = [&](std::int32_t by) {
    return sample_at<kIsWide>(b, c.at + by + 1) - sample_at<kIsWide>(b, c.at + by);
  };
  const float x =
      ray_mixed(ray_mixed(slope(0), slope(b.row), c.share[1]),
                ray_mixed(slope(b.plane), slope(b.plane + b.row), c.share[1]), c.share[2]);
  const float y = ray_mixed(row(b.row) - row(0), row(b.plane + b.row) - row(b.plane), c.share[2]);
  const float z = ray_mixed(row(b.plane) - row(0), row(b.plane + b.row) - row(b.row), c.share[1]);
  return {x + x, y + y, z + z};
}

/// Light and highlight on a surface across a gradient; the side that is seen is the outer one.
struct PortableLight {
  float light = 0;
  float highlight = 0;
  float slope = 0;  // length of the gradient
};

/// Shares of the light.
struct PortableShade {
  float ambient = 1;
  float direct = 1;
};

PortableShade row_shade(const ShadeTable& t, std::int32_t pair, float share) {
  const auto at = [&](std::int32_t byte) { return static_cast<float>(t.pairs[2 * pair + byte]); };
  return {ray_mixed(at(0), at(2), share), ray_mixed(at(1), at(3), share)};
}

PortableShade mixed_shade(const PortableShade& a, const PortableShade& b, float share) {
  return {ray_mixed(a.ambient, b.ambient, share), ray_mixed(a.direct, b.direct, share)};
}

PortableShade shade_at(const ShadeTable& t, const RayPlace& place) {
  if (t.pairs == nullptr) return {};
  std::array<std::int32_t, 3> cell;
  RayPlace share;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float at =
        std::min(std::max(place[axis] * t.scale[axis] + t.offset[axis], 0.0f), t.highest[axis]);
    cell[axis] = std::min(static_cast<std::int32_t>(at), t.last_cell[axis]);
    share[axis] = at - static_cast<float>(cell[axis]);
  }
  const auto row = [&](std::int32_t y, std::int32_t z) {
    return row_shade(t, (cell[2] + z) * t.plane + (cell[1] + y) * t.row + cell[0], share[0]);
  };
  const PortableShade near = mixed_shade(row(0, 0), row(1, 0), share[1]);
  const PortableShade far = mixed_shade(row(0, 1), row(1, 1), share[1]);
  const auto [ambient, direct] = mixed_shade(near, far, share[2]);
  return {ambient * (1 / 255.0f), direct_behind_meshes(t, place.data(), direct * (1 / 255.0f))};
}

PortableLight light_on(const RayFrame& f, const RayPlace& gradient, const PortableShade& shade) {
  const RayLight& light = f.light;
  RayPlace seen;
  for (std::size_t i = 0; i < 3; ++i) {
    seen[i] = f.gradient[3 * i] * gradient[0] + f.gradient[3 * i + 1] * gradient[1] +
              f.gradient[3 * i + 2] * gradient[2];
  }
  const float length = std::sqrt(seen[0] * seen[0] + seen[1] * seen[1] + seen[2] * seen[2]);
  float scale = 1 / std::max(length, kSmallestStep);
  if (seen[2] < 0) scale = 0 - scale;
  const auto along = [&](const RayPlace& direction) {
    const float sum =
        seen[0] * direction[0] + seen[1] * direction[1] + seen[2] * direction[2];
    return std::max(sum * scale, 0.0f);
  };
  const float strength = length / (length + light.soft_gradient + kSmallestStep);
  const float lit = light.ambient * shade.ambient +
                    light.diffuse * along(light.toward_light) * shade.direct;
  const float flat = kFlatLight * (kFlatAmbient * shade.ambient +
                                   (1 - kFlatAmbient) * shade.direct);
  float shine = along(light.halfway);
  for (int i = 0; i < kShineSquares; ++i) shine = shine * shine;
  return {flat + (lit - flat) * strength, light.specular * shine * strength * shade.direct,
          length};
}

std::int32_t entry_of(const ColorTable& table, float value) {
  float entry = 0;
  for (const ColorTable::Piece& piece : table.pieces) {
    entry = entry +
            std::clamp((value - piece.begin) * piece.entries_per_value, 0.0f, piece.entries);
  }
  return std::min(static_cast<std::int32_t>(entry), ColorTable::kSide - 1);
}

/// The opacity of a part of a step: its transmittance to the power of the length.
float opacity_of_part(float opacity, float length) {
  constexpr int kParts = 1 << kStepParts;
  const auto parts = static_cast<std::int32_t>(length * kParts + 0.5f);
  if (parts >= kParts) return opacity;
  float transmittance = 1;
  float root = 1 - opacity;
  for (int bit = kParts >> 1; bit > 0; bit >>= 1) {
    root = std::sqrt(root);
    if ((parts & bit) != 0) transmittance = transmittance * root;
  }
  return 1 - transmittance;
}

template <RayMode kMode, bool kIsWide>
class PortableFollower {
 public:
  PortableFollower(const RayFrame& frame, RayTile& tile, std::size_t number)
      : f_(frame),
        tile_(tile),
        number_(number),
        ray_(start(frame, tile.u + kTileOrder.column[number], tile.v + kTileOrder.row[number])),
        span_(span_of(frame, ray_)) {
    if (tile.stops) {
      stop_ = tile.stops->stop[number];
      from_ = tile.stops->from[number];
    }
  }

  std::int64_t follow() {
    float k = std::max(std::abs(tile_.k[number_]), span_.enter);
    is_done_before_ = tile_.k[number_] < 0;
    tile_.waits_for[number_] = -1;
    while (is_before_end(k)) {
      const RayPlace place = place_at(k);
      const RayCell before = cell_of(place);
      RayCell inside;
      RayCell brick;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        inside[axis] = std::clamp(before[axis], 0, f_.bricks.size[axis] - 1);
        brick[axis] = inside[axis] >> f_.bricks.shift;
      }
      const std::int32_t number =
          (brick[2] * f_.bricks.grid[1] + brick[1]) * f_.bricks.grid[0] + brick[0];
      if (!(f_.bricks.brick_bounds[number] > held())) {
        k = skip(k, inside, f_.bricks.shift);
        continue;
      }
      const std::int32_t slot = f_.bricks.slots[number];
      if (slot < 0) {
        tile_.waits_for[number_] = number;
        break;
      }
      mark_used(f_.bricks, slot);
      if (!(f_.bricks.cube_bounds[cube_of(slot, inside, brick)] > held())) {
        k = skip(k, inside, kSkipShift);
        continue;
      }
      ++taken_;
      k = take(k, before, corner_of(slot, place, before, brick));
    }
    const bool is_done_before = is_done_before_ || k == back_k_;
    if (k > span_.leave) k = kRayDone;
    else if (kMode == RayMode::volume && is_done_before) k = 0 - k;
    tile_.k[number_] = k;
    return taken_;
  }

 private:
  static RayLine start(const RayFrame& frame, float u, float v) {
    const RayLine ray = ray_at(frame, u, v);
    return with_inverse(kMode == RayMode::extreme ? on_planes(ray, frame.eye_pixels > 0) : ray);
  }

  bool is_before_end(float k) const {
    if constexpr (kMode == RayMode::iso) return k <= std::min(span_.leave, stop_ + kBehindStop);
    const bool is_done_before = is_done_before_ || k == back_k_;
    return k <= span_.leave && (k < stop_ || (k == stop_ && !is_done_before));
  }

  float skip(float k, const RayCell& inside, int shift) {
    const float next = limited(k, skipped(k, inside, shift));
    if constexpr (kMode != RayMode::volume) return next;
    // Nothing is seen from the sample before on, as far as the stop.
    is_done_before_ = k == stop_;
    return std::min(next, stop_);
  }

  /// The sample after the one at k: `next`, but the end of the ray before what lies beyond it.
  float limited(float k, float next) const {
    if (next < span_.leave) return next;
    return k < span_.leave ? span_.leave : kRayDone;
  }

  /// What a bound has to be above.
  float held() const { return kMode == RayMode::extreme ? tile_.gathered[number_] : 0; }

  RayPlace place_at(float k) const {
    RayPlace place;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = ray_.origin[axis] + k * ray_.step[axis];
    }
    return place;
  }

  RayCell cell_of(const RayPlace& place) const {
    RayCell cell;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell[axis] = std::clamp(static_cast<std::int32_t>(std::floor(place[axis])), -1,
                              f_.bricks.size[axis] - 1);
    }
    return cell;
  }

  std::size_t cube_of(std::int32_t slot, const RayCell& inside, const RayCell& brick) const {
    const int cubes = f_.bricks.shift - kSkipShift;
    RayCell cube;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cube[axis] = (inside[axis] >> kSkipShift) - (brick[axis] << cubes);
    }
    return static_cast<std::size_t>(
        (((((slot << cubes) + cube[2]) << cubes) + cube[1]) << cubes) + cube[0]);
  }

  SampleCorner corner_of(std::int32_t slot, const RayPlace& place, const RayCell& before,
                         const RayCell& brick) const {
    const BrickTables& b = f_.bricks;
    RayCell local;
    SampleCorner corner;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      local[axis] = before[axis] - (brick[axis] << b.shift) + kApronBelow;
      corner.share[axis] = place[axis] - static_cast<float>(before[axis]);
    }
    corner.at = slot * b.slot + (local[2] * b.plane + local[1] * b.row + local[0]);
    return corner;
  }

  /// The first sample behind the brick or cube of side 1 << shift around `inside`.
  float skipped(float k, const RayCell& inside, int shift) const {
    float nearest = kRayDone;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool rises = ray_.step[axis] > 0;
      const std::int32_t begin = inside[axis] >> shift << shift;
      const float ahead = rises ? static_cast<float>(1 << shift) - f_.margin : f_.margin;
      const float face = static_cast<float>(begin) + ahead;
      nearest = std::min(nearest, (face - ray_.origin[axis]) * ray_.inverse[axis]);
    }
    return std::max(std::floor(k) + 1, std::ceil(nearest));
  }

  /// The corner of a place near one in the cell `before`: no farther than `reach` cells.
  SampleCorner near_corner(float k, const RayCell& before, const SampleCorner& corner,
                           std::int32_t reach = kApronBelow) const {
    const RayPlace place = place_at(k);
    return corner_near(place, place, before, corner, reach);
  }

  /// The same for values: what cuts take away is not in it.
  SampleCorner value_corner(float k, const RayCell& before, const SampleCorner& corner,
                            std::int32_t reach = kApronBelow) const {
    const RayPlace place = place_at(k);
    return corner_near(place, kept_place(f_.cuts, place), before, corner, reach);
  }

  /// counted  a place whose shares count in the cell of `place`
  SampleCorner corner_near(const RayPlace& place, const RayPlace& counted, const RayCell& before,
                           const SampleCorner& corner, std::int32_t reach) const {
    SampleCorner moved = corner;
    std::array<std::int32_t, 3> by;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto floor = static_cast<std::int32_t>(std::floor(place[axis]));
      const std::int32_t cell = std::clamp(floor, before[axis] - reach, before[axis] + reach);
      by[axis] = cell - before[axis];
      moved.share[axis] = counted[axis] - static_cast<float>(cell);
    }
    moved.at += by[2] * f_.bricks.plane + by[1] * f_.bricks.row + by[0];
    return moved;
  }

  bool is_seen(const SampleCorner& corner) const {
    return f_.bricks.looks == nullptr || f_.looks.begins[look_at(f_.bricks, corner)] >= 0;
  }

  /// Of the samples around a hit that lie inside the surface and are seen, the look of the one that
  /// counts most there; by rounding it would be that of the outside as often.
  std::uint16_t inner_look_at(const SampleCorner& corner) const {
    const BrickTables& b = f_.bricks;
    std::uint16_t look = look_at(b, corner);
    float most = 0;
    for (std::int32_t i = 0; i < 8; ++i) {
      const std::array<std::int32_t, 3> next = {i & 1, i >> 1 & 1, i >> 2};
      const std::int32_t at = corner.at + next[2] * b.plane + next[1] * b.row + next[0];
      RayPlace part;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        part[axis] = next[axis] != 0 ? corner.share[axis] : 1 - corner.share[axis];
      }
      const float weight = part[0] * part[1] * part[2];
      const bool is_inner = sample_at<kIsWide>(b, at) * f_.sign >= f_.isovalue &&
                            f_.looks.begins[b.looks[at]] >= 0;
      if (!is_inner || !(weight > most)) continue;
      most = weight;
      look = b.looks[at];
    }
    return look;
  }

  float value_near(float k, const RayCell& before, const SampleCorner& corner) const {
    return value_at<kIsWide>(f_.bricks, value_corner(k, before, corner));
  }

  /// Takes the sample at k, or the part of the ray that begins or ends there. Returns what is next.
  float take(float k, const RayCell& before, const SampleCorner& corner) {
    if constexpr (kMode == RayMode::volume) return take_part(k, before, corner);
    const float next = limited(k, std::floor(k) + 1);
    if constexpr (kMode == RayMode::mean) {
      const float length = std::min(next, span_.leave) - k;
      const SampleCorner middle = value_corner(k + 0.5f * length, before, corner);
      if (!is_seen(middle)) return next;
      tile_.red[number_] += value_at<kIsWide>(f_.bricks, middle) * length;
      tile_.gathered[number_] += length;
      return next;
    }
    const SampleCorner here = value_corner(k, before, corner);
    const float value = value_at<kIsWide>(f_.bricks, here) * f_.sign;
    if constexpr (kMode == RayMode::extreme) {
      if (is_seen(here)) tile_.gathered[number_] = std::max(tile_.gathered[number_], value);
      return next;
    }
    if (!(value >= f_.isovalue) || !is_seen(here)) return next;
    hit(k, before, corner);
    return kRayDone;
  }

  /// The part behind k; before it, where nothing was seen before, the part that ends at k.
  float take_part(float k, const RayCell& before, const SampleCorner& corner) {
    const bool is_known = back_k_ == k;
    float from = k;
    float to = k;
    if (is_known) to = std::min({std::floor(k) + 1, span_.leave, stop_});
    else if (!is_done_before_) from = std::max({std::ceil(k) - 1, span_.enter, from_});
    const std::int32_t front =
        is_known ? back_entry_ : entry_of(f_.table, value_near(from, before, corner));
    const std::int32_t back = entry_of(f_.table, value_near(to, before, corner));
    back_k_ = to;
    back_entry_ = back;
    if (!(from < to)) --taken_;  // the front of the next one
    const float k_middle = (from + to) * 0.5f;
    const SampleCorner middle = near_corner(k_middle, before, corner);
    std::int32_t entry = front * ColorTable::kSide + back;
    std::uint32_t own_color = 0;
    if (f_.bricks.looks != nullptr) {
      const std::uint16_t look = look_at(f_.bricks, middle);
      own_color = f_.looks.colors[look];
      entry = f_.looks.begins[look] < 0 ? -1 : entry + f_.looks.begins[look];
    }
    const float opacity =
        entry < 0 ? 0 : opacity_of_part(f_.table.opacities[entry], to - from);
    if (opacity > 0) {
      composite(opacity, own_color != 0 ? own_color : f_.table.colors[entry], k_middle, middle);
      if (tile_.gathered[number_] >= f_.enough) return kRayDone;
    }
    return to < span_.leave ? to : kRayDone;
  }

  void composite(float opacity, std::uint32_t color, float k, const SampleCorner& middle) {
    float weight = opacity * (1 - tile_.gathered[number_]);
    PortableLight light{kFlatLight, 0, 0};
    const bool has_slope = f_.table.gradient_rise > 0;
    if (has_slope || weight > f_.unlit_weight) {
      const RayPlace gradient = f_.has_cell_gradients
                                    ? cell_gradient_at<kIsWide>(f_.bricks, middle)
                                    : gradient_at<kIsWide>(f_.bricks, middle);
      light = light_on(f_, gradient, shade_at(f_.shade, place_at(k)));
    }
    if (has_slope) {
      const float rise = (light.slope - f_.table.gradient_begin) * f_.table.gradient_rise;
      weight = weight * std::clamp(rise, 0.0f, 1.0f);
    }
    const float lit = weight * light.light * (1 / 255.0f);
    const float shine = weight * light.highlight;
    const auto channel = [&](int bits) { return static_cast<float>(color >> bits & 255); };
    tile_.red[number_] += channel(0) * lit + shine;
    tile_.green[number_] += channel(8) * lit + shine;
    tile_.blue[number_] += channel(16) * lit + shine;
    tile_.gathered[number_] += weight;
  }

  float excess_at(float k, const RayCell& before, const SampleCorner& corner) const {
    return value_at<kIsWide>(f_.bricks, value_corner(k, before, corner, 1)) * f_.sign -
           f_.isovalue;
  }

  bool is_inside(float k, const RayCell& before, const SampleCorner& corner) const {
    const SampleCorner near = value_corner(k, before, corner, 1);
    return value_at<kIsWide>(f_.bricks, near) * f_.sign >= f_.isovalue && is_seen(near);
  }

  float halved(float outside, float inside, const RayCell& before,
               const SampleCorner& corner) const {
    for (int i = 0; i < kHitHalvings; ++i) {
      const float middle = (outside + inside) * 0.5f;
      if (is_inside(middle, before, corner)) inside = middle;
      else outside = middle;
    }
    return inside;
  }

  float narrowed(float outside, float inside, const RayCell& before,
                 const SampleCorner& corner) const {
    float below = std::min(excess_at(outside, before, corner), -kSmallestExcess);
    float above = std::max(excess_at(inside, before, corner), 0.0f);
    const auto crossing = [&] {
      return outside + (inside - outside) * (below / (below - above));
    };
    int side = 0;  // where the place before lay
    for (int i = 0; i < kHitLines; ++i) {
      const float middle = crossing();
      const float excess = excess_at(middle, before, corner);
      if (excess >= 0) {
        if (side > 0) below = below * 0.5f;
        inside = middle;
        above = excess;
        side = 1;
      } else {
        if (side < 0) above = above * 0.5f;
        outside = middle;
        below = excess;
        side = -1;
      }
    }
    return crossing();
  }

  /// Between the sample at k, which lies inside, and the one before it.
  void hit(float k, const RayCell& before, const SampleCorner& corner) {
    const float k_before = std::ceil(k) - 1;
    const bool is_at_face = span_.enter > k_before;
    const float outside = std::max(k_before, span_.enter);
    float inside = k;
    const bool is_cut = is_at_face && is_inside(outside, before, corner);
    if (is_cut) inside = outside;
    else if (f_.bricks.looks != nullptr) inside = halved(outside, inside, before, corner);
    else inside = narrowed(outside, inside, before, corner);
    const SampleCorner at_hit = near_corner(inside, before, corner, 1);
    RayPlace gradient = gradient_at<kIsWide>(f_.bricks, at_hit);
    if (is_cut) {
      // A cut has the side of the face, whatever lies behind.
      gradient = {};
      gradient[span_.axis] = kCutGradient;
    }
    const PortableLight light =
        light_on(f_, gradient, shade_at(f_.shade, place_at(inside)));
    tile_.red[number_] = light.light;
    tile_.green[number_] = light.highlight;
    tile_.blue[number_] = inside;
    tile_.gathered[number_] = 1;
    if (f_.bricks.looks != nullptr) {
      tile_.gathered[number_] +=
          static_cast<float>(inner_look_at(value_corner(inside, before, corner, 1)));
    }
  }

  const RayFrame& f_;
  RayTile& tile_;
  std::size_t number_;
  RayLine ray_;
  RaySpan span_;
  std::int64_t taken_ = 0;
  float back_k_ = -1;  // a sample whose entry is known
  std::int32_t back_entry_ = 0;
  float stop_ = kRayDone;
  float from_ = -kRayDone;
  bool is_done_before_ = false;  // what lies before the next sample
};

template <RayMode kMode, bool kIsWide>
std::int64_t follow_tile(const RayFrame& frame, RayTile& tile) {
  std::int64_t taken = 0;
  for (std::size_t i = 0; i < kTileRays; ++i) {
    if (tile.k[i] < kRayDone) taken += PortableFollower<kMode, kIsWide>(frame, tile, i).follow();
  }
  return taken;
}

}  // namespace

std::int64_t follow_rays_portable(const RayFrame& frame, RayTile& tile) {
  return with_ray_mode(frame, [&](auto mode, auto is_wide) {
    return follow_tile<decltype(mode)::value, decltype(is_wide)::value>(frame, tile);
  });
}

}  // namespace octavo
