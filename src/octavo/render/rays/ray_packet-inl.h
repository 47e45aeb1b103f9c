// Rays side by side in the lanes of vectors: what ray_portable.cpp does for one.
//
// Neighbors in a tile are neighbors in the volume, so most lanes are in one cube. A lane whose ray
// is done, waits or skips is masked out; what it would read is sample 0.

#if defined(OCTAVO_RENDER_RAYS_RAY_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_RENDER_RAYS_RAY_PACKET_INL_H_
#undef OCTAVO_RENDER_RAYS_RAY_PACKET_INL_H_
#else
#define OCTAVO_RENDER_RAYS_RAY_PACKET_INL_H_
#endif

#include <hwy/highway.h>

#include "octavo/render/rays/ray_job.h"

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<float, 16> kRays{};
constexpr hn::RebindToSigned<decltype(kRays)> kWhole{};
using Reals = hn::Vec<decltype(kRays)>;
using Wholes = hn::Vec<decltype(kWhole)>;
using RayMask = hn::Mask<decltype(kRays)>;

HWY_INLINE Reals real(float value) { return hn::Set(kRays, value); }
HWY_INLINE Wholes whole(std::int32_t value) { return hn::Set(kWhole, value); }
HWY_INLINE auto of_wholes(RayMask mask) { return hn::RebindMask(kWhole, mask); }
HWY_INLINE RayMask of_reals(hn::Mask<decltype(kWhole)> mask) { return hn::RebindMask(kRays, mask); }
HWY_INLINE Reals mixed(Reals a, Reals b, Reals share) {
  return hn::Add(a, hn::Mul(hn::Sub(b, a), share));
}
HWY_INLINE Wholes floor_of(Reals value) { return hn::ConvertTo(kWhole, hn::Floor(value)); }
HWY_INLINE Wholes clamped(Wholes value, Wholes low, Wholes high) {
  return hn::Min(hn::Max(value, low), high);
}

/// Two samples in a row.
struct SamplePair {
  Reals first;
  Reals second;
};

template <bool kIsWide>
HWY_INLINE SamplePair pair_at(const BrickTables& b, Wholes at) {
  if constexpr (kIsWide) {
    const auto* const samples = static_cast<const float*>(b.samples);
    return {hn::GatherIndex(kRays, samples, at),
            hn::GatherIndex(kRays, samples, hn::Add(at, whole(1)))};
  } else {
    const Wholes both = hn::GatherOffset(kWhole, static_cast<const std::int32_t*>(b.samples),
                                         hn::ShiftLeft<1>(at));
    return {hn::ConvertTo(kRays, hn::ShiftRight<16>(hn::ShiftLeft<16>(both))),
            hn::ConvertTo(kRays, hn::ShiftRight<16>(both))};
  }
}

/// What stands around places: the sample before each along each axis, and the shares of the next.
struct Corners {
  Wholes at;
  Reals share[3];
};

template <bool kIsWide>
HWY_INLINE Reals row_value(const BrickTables& b, Wholes at, Reals share) {
  const SamplePair pair = pair_at<kIsWide>(b, at);
  return mixed(pair.first, pair.second, share);
}

template <bool kIsWide>
HWY_INLINE Reals value_at(const BrickTables& b, const Corners& c) {
  const auto row = [&](std::int32_t by) HWY_ATTR {
    return row_value<kIsWide>(b, hn::Add(c.at, whole(by)), c.share[0]);
  };
  const Reals near = mixed(row(0), row(b.row), c.share[1]);
  const Reals far = mixed(row(b.plane), row(b.plane + b.row), c.share[1]);
  return mixed(near, far, c.share[2]);
}

struct Gradients {
  Reals along[3];
};

/// A row through a place: its value there and its slope.
struct RowsAt {
  Reals value;
  Reals slope;
};

template <bool kIsWide>
HWY_INLINE RowsAt rows_at(const BrickTables& b, Wholes at, Reals share) {
  const SamplePair low = pair_at<kIsWide>(b, hn::Sub(at, whole(1)));
  const SamplePair high = pair_at<kIsWide>(b, hn::Add(at, whole(1)));
  const Reals first = hn::Sub(high.first, low.first);
  const Reals second = hn::Sub(high.second, low.second);
  return {mixed(low.second, high.first, share), mixed(first, second, share)};
}

template <bool kIsWide>
HWY_INLINE Gradients gradient_at(const BrickTables& b, const Corners& c) {
  const auto at = [&](std::int32_t y, std::int32_t z) HWY_ATTR {
    return hn::Add(c.at, whole(y * b.row + z * b.plane));
  };
  const auto row = [&](std::int32_t y, std::int32_t z) HWY_ATTR {
    return row_value<kIsWide>(b, at(y, z), c.share[0]);
  };
  const RowsAt r00 = rows_at<kIsWide>(b, at(0, 0), c.share[0]);
  const RowsAt r10 = rows_at<kIsWide>(b, at(1, 0), c.share[0]);
  const RowsAt r01 = rows_at<kIsWide>(b, at(0, 1), c.share[0]);
  const RowsAt r11 = rows_at<kIsWide>(b, at(1, 1), c.share[0]);
  const Reals x = mixed(mixed(r00.slope, r10.slope, c.share[1]),
                        mixed(r01.slope, r11.slope, c.share[1]), c.share[2]);
  const Reals y =
      mixed(mixed(hn::Sub(r10.value, row(-1, 0)), hn::Sub(row(2, 0), r00.value), c.share[1]),
            mixed(hn::Sub(r11.value, row(-1, 1)), hn::Sub(row(2, 1), r01.value), c.share[1]),
            c.share[2]);
  const Reals z =
      mixed(mixed(hn::Sub(r01.value, row(0, -1)), hn::Sub(row(0, 2), r00.value), c.share[2]),
            mixed(hn::Sub(r11.value, row(1, -1)), hn::Sub(row(1, 2), r10.value), c.share[2]),
            c.share[1]);
  return {{x, y, z}};
}

struct PacketLight {
  Reals light;
  Reals highlight;
};

HWY_INLINE PacketLight light_on(const RayFrame& f, const Gradients& gradient) {
  const RayLight& light = f.light;
  const auto dot = [](const Reals* a, const float* b) HWY_ATTR {
    return hn::Add(hn::Add(hn::Mul(a[0], real(b[0])), hn::Mul(a[1], real(b[1]))),
                   hn::Mul(a[2], real(b[2])));
  };
  Reals seen[3];
  for (std::size_t i = 0; i < 3; ++i) seen[i] = dot(gradient.along, f.gradient.data() + 3 * i);
  const Reals length =
      hn::Sqrt(hn::Add(hn::Add(hn::Mul(seen[0], seen[0]), hn::Mul(seen[1], seen[1])),
                       hn::Mul(seen[2], seen[2])));
  const Reals zero = hn::Zero(kRays);
  Reals scale = hn::Div(real(1), hn::Max(length, real(kSmallestStep)));
  scale = hn::IfThenElse(hn::Lt(seen[2], zero), hn::Sub(zero, scale), scale);
  const auto along = [&](const std::array<float, 3>& direction) HWY_ATTR {
    return hn::Max(hn::Mul(dot(seen, direction.data()), scale), zero);
  };
  const Reals strength = hn::Div(
      length, hn::Add(hn::Add(length, real(light.soft_gradient)), real(kSmallestStep)));
  const Reals lit =
      hn::Add(real(light.ambient), hn::Mul(real(light.diffuse), along(light.toward_light)));
  Reals shine = along(light.halfway);
  for (int i = 0; i < kShineSquares; ++i) shine = hn::Mul(shine, shine);
  const Reals flat = real(kFlatLight);
  return {hn::Add(flat, hn::Mul(hn::Sub(lit, flat), strength)),
          hn::Mul(hn::Mul(real(light.specular), shine), strength)};
}

/// The rays of as many neighbors as a vector has lanes.
template <RayMode kMode, bool kIsWide>
class Packet {
 public:
  HWY_INLINE Packet(const RayFrame& frame, RayTile& tile, std::size_t first)
      : f_(frame), tile_(tile), first_(first) {
    const Reals u = hn::Add(real(tile.u), hn::Load(kRays, kTileOrder.column.data() + first));
    const Reals v = hn::Add(real(tile.v), hn::Load(kRays, kTileOrder.row.data() + first));
    start(u, v);
    stop_ = real(kRayDone);
    from_ = real(-kRayDone);
    if (tile.stops) {
      stop_ = hn::Load(kRays, tile.stops->stop.data() + first);
      from_ = hn::Load(kRays, tile.stops->from.data() + first);
    }
    reach_ = hn::Min(leave_, hn::Add(stop_, real(kHalfStep)));
    gathered_ = hn::Load(kRays, tile.gathered.data() + first);
    if constexpr (kMode == RayMode::iso) {
      // Of lanes without a hit a sample that has neighbors on all sides.
      hits_ = hn::FirstN(kRays, 0);
      hit_k_ = hn::Zero(kRays);
      hit_corner_.at = whole(kApronBelow * (frame.bricks.plane + frame.bricks.row + 1));
      for (Wholes& before : hit_before_) before = hn::Zero(kWhole);
    }
    if constexpr (kMode != RayMode::extreme) red_ = hn::Load(kRays, tile.red.data() + first);
    if constexpr (kMode == RayMode::volume || kMode == RayMode::iso) {
      green_ = hn::Load(kRays, tile.green.data() + first);
      blue_ = hn::Load(kRays, tile.blue.data() + first);
    }
  }

  HWY_INLINE std::int64_t follow() {
    std::int64_t taken = 0;
    k_ = hn::Max(hn::Load(kRays, tile_.k.data() + first_),
                 kTakesEnds ? enter_ : hn::Ceil(enter_));
    Wholes waits_for = whole(-1);
    RayMask active = hn::Le(k_, reach_);
    while (!hn::AllFalse(kRays, active)) {
      place_at(k_, place_);
      find_bricks(active);

      // What is in a brick worth looking at, and what has to wait for it.
      const RayMask in_brick = hn::And(active, hn::Gt(brick_bound_, held()));
      const RayMask missing = hn::And(in_brick, of_reals(hn::Lt(slot_, whole(0))));
      if (!hn::AllFalse(kRays, missing)) {
        waits_for = hn::IfThenElse(of_wholes(missing), brick_, waits_for);
        active = hn::AndNot(missing, active);
      }
      const RayMask present = hn::AndNot(missing, in_brick);
      const Wholes cube = hn::IfThenElseZero(of_wholes(present), cube_number());
      const Reals bound = hn::GatherIndex(kRays, f_.bricks.cube_bounds, cube);
      const RayMask taking = hn::And(present, hn::Gt(bound, held()));

      // Samples; the others skip.
      Reals next = hn::Add(hn::Floor(k_), real(1));
      const RayMask skipping = hn::AndNot(taking, active);
      if (!hn::AllFalse(kRays, skipping)) {
        next = hn::IfThenElse(skipping, skipped(in_brick), next);
      }
      if constexpr (kTakesEnds) next = limited(next);
      if (!hn::AllFalse(kRays, taking)) {
        taken += static_cast<std::int64_t>(hn::CountTrue(kRays, taking));
        const RayMask ends = take(taking);
        if (tile_.stops) {
          // What lies behind the stop is left of the step: the sample is taken again.
          const RayMask is_cut = hn::And(taking, hn::Gt(hn::Add(k_, real(kHalfStep)), stop_));
          next = hn::IfThenElse(is_cut, k_, next);
          active = hn::AndNot(hn::AndNot(ends, is_cut), active);
        }
        next = hn::IfThenElse(ends, real(kRayDone), next);
      }
      k_ = hn::IfThenElse(active, next, k_);
      active = hn::And(active, hn::Le(k_, reach_));
    }
    // All lanes find their places together.
    if constexpr (kMode == RayMode::iso) {
      if (!hn::AllFalse(kRays, hits_)) hit();
    }
    keep(waits_for);
    return taken;
  }

 private:
  /// Whether samples stand for themselves, not for a part of the ray.
  static constexpr bool kTakesEnds = kMode == RayMode::extreme || kMode == RayMode::iso;

  HWY_INLINE void start(Reals u, Reals v) {
    Reals scale = real(1);
    if (f_.eye_pixels > 0) {
      const Reals eye = real(f_.eye_pixels * f_.eye_pixels);
      const Reals square = hn::Add(hn::Add(hn::Mul(u, u), hn::Mul(v, v)), eye);
      scale = hn::Div(real(f_.step_pixels), hn::Sqrt(square));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      origin_[axis] = hn::Add(hn::Add(real(f_.origin[axis]),
                                      hn::Mul(u, real(f_.origin_across[axis]))),
                              hn::Mul(v, real(f_.origin_down[axis])));
      const Reals direction = hn::Add(
          hn::Add(real(f_.direction[axis]), hn::Mul(u, real(f_.direction_across[axis]))),
          hn::Mul(v, real(f_.direction_down[axis])));
      const Reals step = hn::Mul(direction, scale);
      step_[axis] =
          hn::IfThenElse(hn::Lt(hn::Abs(step), real(kSmallestStep)), real(kSmallestStep), step);
    }
    if constexpr (kMode == RayMode::extreme) move_to_planes();
    enter_ = hn::Zero(kRays);
    leave_ = real(kRayDone);
    enter_axis_ = whole(2);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Reals low = hn::Div(hn::Sub(real(f_.low[axis]), origin_[axis]), step_[axis]);
      const Reals high = hn::Div(hn::Sub(real(f_.high[axis]), origin_[axis]), step_[axis]);
      const Reals first = hn::Min(low, high);
      const RayMask is_later = hn::Gt(first, enter_);
      enter_ = hn::IfThenElse(is_later, first, enter_);
      enter_axis_ = hn::IfThenElse(of_wholes(is_later), whole(static_cast<std::int32_t>(axis)),
                                   enter_axis_);
      leave_ = hn::Min(leave_, hn::Max(low, high));
    }
  }

  /// Moves samples to the planes of the grid that each ray crosses most squarely.
  HWY_INLINE void move_to_planes() {
    Reals most = hn::Abs(step_[0]);
    Wholes main = hn::Zero(kWhole);
    Reals step = step_[0];
    Reals origin = origin_[0];
    for (std::size_t axis = 1; axis < 3; ++axis) {
      const RayMask is_more = hn::Gt(hn::Abs(step_[axis]), most);
      most = hn::IfThenElse(is_more, hn::Abs(step_[axis]), most);
      main = hn::IfThenElse(of_wholes(is_more), whole(static_cast<std::int32_t>(axis)), main);
      step = hn::IfThenElse(is_more, step_[axis], step);
      origin = hn::IfThenElse(is_more, origin_[axis], origin);
    }
    const Reals scale = hn::Div(real(1), most);
    const RayMask rises = hn::Gt(step, hn::Zero(kRays));
    const Reals plane = hn::IfThenElse(rises, hn::Ceil(origin), hn::Floor(origin));
    const Reals ahead = hn::Abs(hn::Sub(plane, origin));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const RayMask is_main = of_reals(hn::Eq(main, whole(static_cast<std::int32_t>(axis))));
      const Reals moved = hn::Mul(step_[axis], scale);
      origin_[axis] = hn::IfThenElse(
          is_main, plane, hn::Add(origin_[axis], hn::Mul(ahead, moved)));
      step_[axis] =
          hn::IfThenElse(is_main, hn::IfThenElse(rises, real(1), real(-1)), moved);
    }
  }

  HWY_INLINE Reals held() const {
    if constexpr (kMode == RayMode::extreme) return gathered_;
    else return hn::Zero(kRays);
  }

  HWY_INLINE void place_at(Reals k, Reals* place) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = hn::Add(origin_[axis], hn::Mul(k, step_[axis]));
    }
  }

  /// The brick of each place; tables are read where a ray has come into another one.
  HWY_INLINE void find_bricks(RayMask active) {
    const BrickTables& b = f_.bricks;
    Wholes brick[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      before_[axis] = clamped(floor_of(place_[axis]), whole(-1), whole(b.size[axis] - 1));
      inside_[axis] = hn::Max(before_[axis], whole(0));
      brick[axis] = hn::ShiftRightSame(inside_[axis], b.shift);
    }
    Wholes number = hn::Add(hn::Mul(brick[2], whole(b.grid[1])), brick[1]);
    number = hn::Add(hn::Mul(number, whole(b.grid[0])), brick[0]);
    const auto moved = hn::And(of_wholes(active), hn::Ne(number, brick_));
    if (hn::AllFalse(kWhole, moved)) return;
    brick_ = hn::IfThenElseZero(of_wholes(active), number);
    brick_bound_ = hn::GatherIndex(kRays, b.brick_bounds, brick_);
    slot_ = hn::GatherIndex(kWhole, b.slots, brick_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      brick_begin_[axis] = hn::ShiftLeftSame(brick[axis], b.shift);
    }
    brick_at_ = hn::Mul(slot_, whole(b.slot));
    brick_ = hn::IfThenElse(of_wholes(active), brick_, whole(-1));
  }

  HWY_INLINE Wholes cube_number() const {
    const int cubes = f_.bricks.shift - kSkipShift;
    const auto cube = [&](std::size_t axis) HWY_ATTR {
      return hn::ShiftRight<kSkipShift>(hn::Sub(inside_[axis], brick_begin_[axis]));
    };
    const Wholes z = hn::Add(hn::ShiftLeftSame(slot_, cubes), cube(2));
    const Wholes y = hn::Add(hn::ShiftLeftSame(z, cubes), cube(1));
    return hn::Add(hn::ShiftLeftSame(y, cubes), cube(0));
  }

  /// The first sample behind the cube around each place, or behind the brick where not in_brick.
  HWY_INLINE Reals skipped(RayMask in_brick) const {
    const auto is_cube = of_wholes(in_brick);
    Reals nearest = real(kRayDone);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Wholes cube = hn::ShiftLeft<kSkipShift>(hn::ShiftRight<kSkipShift>(inside_[axis]));
      const Wholes begin = hn::IfThenElse(is_cube, cube, brick_begin_[axis]);
      const Wholes side = hn::IfThenElse(is_cube, whole(kSkipSide), whole(1 << f_.bricks.shift));
      const RayMask rises = hn::Gt(step_[axis], hn::Zero(kRays));
      const Reals end = hn::ConvertTo(
          kRays, hn::Add(begin, hn::IfThenElseZero(of_wholes(rises), side)));
      const Reals stop = hn::IfThenElse(rises, hn::Sub(end, real(f_.margin)),
                                        hn::Add(end, real(f_.margin)));
      nearest = hn::Min(nearest, hn::Div(hn::Sub(stop, origin_[axis]), step_[axis]));
    }
    return hn::Max(hn::Add(hn::Floor(k_), real(1)), hn::Ceil(nearest));
  }

  /// The samples after those at k_: `next`, but the ends of rays before what lies beyond them.
  HWY_INLINE Reals limited(Reals next) const {
    const Reals last = hn::IfThenElse(hn::Lt(k_, leave_), leave_, real(kRayDone));
    return hn::IfThenElse(hn::Lt(next, leave_), next, last);
  }

  HWY_INLINE Corners corners(RayMask taking) const {
    const BrickTables& b = f_.bricks;
    Corners corners;
    Wholes local[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      local[axis] = hn::Add(hn::Sub(before_[axis], brick_begin_[axis]), whole(kApronBelow));
      corners.share[axis] = hn::Sub(place_[axis], hn::ConvertTo(kRays, before_[axis]));
    }
    const Wholes in_brick =
        hn::Add(hn::Add(hn::Mul(local[2], whole(b.plane)), hn::Mul(local[1], whole(b.row))),
                local[0]);
    // Of other lanes a sample that has neighbors on all sides.
    corners.at = hn::IfThenElse(of_wholes(taking), hn::Add(brick_at_, in_brick),
                                whole(kApronBelow * (b.plane + b.row + 1)));
    return corners;
  }

  /// Takes the samples of some lanes; those whose ray ends there.
  HWY_INLINE RayMask take(RayMask taking) {
    const Corners corner = corners(taking);
    const Reals value = value_at<kIsWide>(f_.bricks, corner);
    if constexpr (kMode == RayMode::extreme) {
      const Reals signed_value = hn::Mul(value, real(f_.sign));
      gathered_ = hn::IfThenElse(taking, hn::Max(gathered_, signed_value), gathered_);
      return hn::FirstN(kRays, 0);
    } else if constexpr (kMode == RayMode::mean) {
      red_ = hn::IfThenElse(taking, hn::Add(red_, value), red_);
      gathered_ = hn::IfThenElse(taking, hn::Add(gathered_, real(1)), gathered_);
      return hn::FirstN(kRays, 0);
    } else if constexpr (kMode == RayMode::volume) {
      return composite(taking, value, corner);
    } else {
      const RayMask inside =
          hn::And(taking, hn::Ge(hn::Mul(value, real(f_.sign)), real(f_.isovalue)));
      hits_ = hn::Or(hits_, inside);
      hit_k_ = hn::IfThenElse(inside, k_, hit_k_);
      hit_corner_.at = hn::IfThenElse(of_wholes(inside), corner.at, hit_corner_.at);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        hit_before_[axis] =
            hn::IfThenElse(of_wholes(inside), before_[axis], hit_before_[axis]);
      }
      return inside;
    }
  }

  /// Of the opacities of steps those parts which lie before the stop and behind the one before.
  HWY_INLINE Reals parts_of(Reals opacity) const {
    const Reals begin = hn::Sub(k_, real(kHalfStep));
    const Reals first = hn::Max(begin, from_);
    const Reals part = hn::Sub(hn::Min(hn::Add(k_, real(kHalfStep)), stop_), first);
    return hn::Div(hn::Mul(opacity, part),
                   hn::Sub(real(1), hn::Mul(opacity, hn::Sub(first, begin))));
  }

  HWY_INLINE RayMask composite(RayMask taking, Reals value, const Corners& corner) {
    const ColorTable& table = f_.table;
    Reals entry = hn::Mul(hn::Sub(value, real(table.lowest)), real(table.entries_per_value));
    entry = hn::Min(hn::Max(entry, hn::Zero(kRays)), real(static_cast<float>(table.last)));
    const Wholes number = hn::ConvertTo(kWhole, entry);
    Reals opacity = hn::GatherIndex(kRays, table.opacities, number);
    if (tile_.stops) opacity = parts_of(opacity);
    const RayMask seen = hn::And(taking, hn::Gt(opacity, hn::Zero(kRays)));
    if (hn::AllFalse(kRays, seen)) return seen;

    const Reals weight = hn::IfThenElseZero(seen, hn::Mul(opacity, hn::Sub(real(1), gathered_)));
    PacketLight light{real(kFlatLight), hn::Zero(kRays)};
    const RayMask is_lit = hn::Gt(weight, real(kUnlitWeight));
    if (!hn::AllFalse(kRays, is_lit)) {
      const PacketLight full = light_on(f_, gradient_at<kIsWide>(f_.bricks, corner));
      light = {hn::IfThenElse(is_lit, full.light, light.light),
               hn::IfThenElseZero(is_lit, full.highlight)};
    }
    const Wholes color = hn::GatherIndex(
        kWhole, reinterpret_cast<const std::int32_t*>(table.colors), number);
    const Reals lit = hn::Mul(hn::Mul(weight, light.light), real(1 / 255.0f));
    const Reals shine = hn::Mul(weight, light.highlight);
    const auto add = [&](Wholes part, Reals& sum) HWY_ATTR {
      const Reals channel = hn::ConvertTo(kRays, hn::And(part, whole(255)));
      sum = hn::Add(sum, hn::Add(hn::Mul(channel, lit), shine));
    };
    add(color, red_);
    add(hn::ShiftRight<8>(color), green_);
    add(hn::ShiftRight<16>(color), blue_);
    gathered_ = hn::Add(gathered_, weight);
    return hn::And(seen, hn::Ge(gathered_, real(f_.enough)));
  }

  /// The corners of places that lie less than a step from those that were hit.
  HWY_INLINE Corners near_corners(Reals k) const {
    const BrickTables& b = f_.bricks;
    Corners moved;
    Reals place[3];
    Wholes by[3];
    place_at(k, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Wholes before = hit_before_[axis];
      const Wholes at =
          clamped(floor_of(place[axis]), hn::Sub(before, whole(1)), hn::Add(before, whole(1)));
      by[axis] = hn::Sub(at, before);
      moved.share[axis] = hn::Sub(place[axis], hn::ConvertTo(kRays, at));
    }
    moved.at = hn::Add(
        hit_corner_.at,
        hn::Add(hn::Add(hn::Mul(by[2], whole(b.plane)), hn::Mul(by[1], whole(b.row))), by[0]));
    return moved;
  }

  HWY_INLINE RayMask is_inside(Reals k) const {
    const Reals value = value_at<kIsWide>(f_.bricks, near_corners(k));
    return hn::Ge(hn::Mul(value, real(f_.sign)), real(f_.isovalue));
  }

  HWY_INLINE void hit() {
    const RayMask lanes = hits_;
    const Reals k_before = hn::Sub(hn::Ceil(hit_k_), real(1));
    // What other lanes would look at lies nowhere: they look where they are.
    Reals outside = hn::IfThenElse(lanes, hn::Max(k_before, enter_), hit_k_);
    Reals inside = hit_k_;
    const RayMask is_cut =
        hn::And(hn::And(lanes, hn::Gt(enter_, k_before)), is_inside(outside));
    inside = hn::IfThenElse(is_cut, outside, inside);
    for (int i = 0; i < kHitHalvings; ++i) {
      const Reals middle = hn::Mul(hn::Add(outside, inside), real(0.5f));
      const RayMask is_in = is_inside(middle);
      inside = hn::IfThenElse(is_in, middle, inside);
      outside = hn::IfThenElse(is_in, outside, middle);
    }
    Gradients gradient = gradient_at<kIsWide>(f_.bricks, near_corners(inside));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto is_axis = hn::Eq(enter_axis_, whole(static_cast<std::int32_t>(axis)));
      const Reals face = hn::IfThenElseZero(of_reals(is_axis), real(kCutGradient));
      gradient.along[axis] = hn::IfThenElse(is_cut, face, gradient.along[axis]);
    }
    const PacketLight light = light_on(f_, gradient);
    red_ = hn::IfThenElse(lanes, light.light, red_);
    green_ = hn::IfThenElse(lanes, light.highlight, green_);
    blue_ = hn::IfThenElse(lanes, inside, blue_);
    gathered_ = hn::IfThenElse(lanes, real(1), gathered_);
  }

  HWY_INLINE void keep(Wholes waits_for) {
    hn::Store(waits_for, kWhole, tile_.waits_for.data() + first_);
    const RayMask goes_on = hn::Le(k_, leave_);
    hn::Store(hn::IfThenElse(goes_on, k_, real(kRayDone)), kRays, tile_.k.data() + first_);
    hn::Store(gathered_, kRays, tile_.gathered.data() + first_);
    if constexpr (kMode != RayMode::extreme) hn::Store(red_, kRays, tile_.red.data() + first_);
    if constexpr (kMode == RayMode::volume || kMode == RayMode::iso) {
      hn::Store(green_, kRays, tile_.green.data() + first_);
      hn::Store(blue_, kRays, tile_.blue.data() + first_);
    }
  }

  const RayFrame& f_;
  RayTile& tile_;
  std::size_t first_;
  Reals origin_[3];
  Reals step_[3];
  Reals enter_;
  Reals leave_;
  Wholes enter_axis_;
  Reals stop_;
  Reals from_;
  Reals reach_;
  Reals k_;
  Reals place_[3];
  Wholes before_[3];
  Wholes inside_[3];
  Wholes brick_ = whole(-1);
  Wholes brick_begin_[3];
  Wholes slot_;
  Wholes brick_at_;
  Reals brick_bound_;
  RayMask hits_;
  Reals hit_k_;
  Corners hit_corner_;
  Wholes hit_before_[3];
  Reals gathered_;
  Reals red_;
  Reals green_;
  Reals blue_;
};

template <RayMode kMode, bool kIsWide>
std::int64_t follow_packets(const RayFrame& frame, RayTile& tile) {
  std::int64_t taken = 0;
  for (std::size_t first = 0; first < kTileRays; first += hn::Lanes(kRays)) {
    const RayMask is_open =
        hn::Lt(hn::Load(kRays, tile.k.data() + first), real(kRayDone));
    if (hn::AllFalse(kRays, is_open)) continue;
    taken += Packet<kMode, kIsWide>(frame, tile, first).follow();
  }
  return taken;
}

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#endif
