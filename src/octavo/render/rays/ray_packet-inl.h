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
#include "octavo/render/rays/ray_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

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
    gathered_ = hn::Load(kRays, tile.gathered.data() + first);
    if constexpr (kMode == RayMode::iso) {
      // Of lanes without a hit a sample that has neighbors on all sides.
      hits_ = hn::FirstN(kRays, 0);
      hit_k_ = hn::Zero(kRays);
      hit_at_ = whole(kApronBelow * (frame.bricks.plane + frame.bricks.row + 1));
      for (Wholes& before : hit_before_) before = hn::Zero(kWhole);
    }
    if constexpr (kMode == RayMode::volume) {
      back_k_ = real(-1);
      back_entry_ = hn::Zero(kWhole);
    }
    if constexpr (kMode != RayMode::extreme) red_ = hn::Load(kRays, tile.red.data() + first);
    if constexpr (kMode == RayMode::volume || kMode == RayMode::iso) {
      green_ = hn::Load(kRays, tile.green.data() + first);
      blue_ = hn::Load(kRays, tile.blue.data() + first);
    }
  }

  HWY_INLINE std::int64_t follow() {
    const Reals kept = hn::Load(kRays, tile_.k.data() + first_);
    k_ = hn::Max(hn::Abs(kept), enter_);
    done_before_ = hn::Lt(kept, hn::Zero(kRays));
    Wholes waits_for = whole(-1);
    RayMask active = before_end();
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
        // Nothing is seen from the sample before on, as far as the stop.
        const RayMask at_stop = hn::And(skipping, hn::Eq(k_, stop_));
        done_before_ = hn::Or(at_stop, hn::AndNot(skipping, done_before_));
      }
      next = limited(next);
      if constexpr (kMode == RayMode::volume) next = hn::Min(next, stop_);
      if (!hn::AllFalse(kRays, taking)) {
        taken_ += static_cast<std::int64_t>(hn::CountTrue(kRays, taking));
        next = hn::IfThenElse(taking, take(taking, next), next);
      }
      k_ = hn::IfThenElse(active, next, k_);
      active = hn::And(active, before_end());
    }
    // All lanes find their places together.
    if constexpr (kMode == RayMode::iso) {
      if (!hn::AllFalse(kRays, hits_)) hit();
    }
    keep(waits_for);
    return taken_;
  }

 private:
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
    RayMask is_inner_begin = hn::FirstN(kRays, 0);
    RayMask is_inner_end = is_inner_begin;
    Reals end = real(kRayDone);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = [&](float face) HWY_ATTR {
        return hn::Div(hn::Sub(real(face), origin_[axis]), step_[axis]);
      };
      const Reals low = at(f_.low[axis]);
      const Reals high = at(f_.high[axis]);
      const RayMask rises = hn::Gt(step_[axis], hn::Zero(kRays));
      const bool is_inner_low = f_.low[axis] > f_.whole_low[axis];
      const bool is_inner_high = f_.high[axis] < f_.whole_high[axis];
      const auto is_inner = [&](bool where_rising, bool where_falling) HWY_ATTR {
        return hn::Or(hn::And(rises, all_or_none(where_rising)),
                      hn::AndNot(rises, all_or_none(where_falling)));
      };
      const Reals first = hn::Min(low, high);
      const Reals last = hn::Max(low, high);
      const RayMask is_later = hn::Gt(first, enter_);
      is_inner_begin = hn::Or(
          hn::And(is_later, is_inner(is_inner_low, is_inner_high)),
          hn::AndNot(is_later, is_inner_begin));
      enter_ = hn::IfThenElse(is_later, first, enter_);
      enter_axis_ = hn::IfThenElse(of_wholes(is_later), whole(static_cast<std::int32_t>(axis)),
                                   enter_axis_);
      const RayMask is_sooner = hn::Lt(last, leave_);
      is_inner_end = hn::Or(
          hn::And(is_sooner, is_inner(is_inner_high, is_inner_low)),
          hn::AndNot(is_sooner, is_inner_end));
      leave_ = hn::Min(leave_, last);
      end = hn::Min(end, hn::Max(at(f_.whole_low[axis]), at(f_.whole_high[axis])));
    }
    const RayMask is_beside = hn::Gt(enter_, leave_);
    enter_ = hn::IfThenElse(is_inner_begin, hn::Ceil(enter_), enter_);
    leave_ = hn::IfThenElse(is_inner_end, hn::Min(hn::Ceil(leave_), end), leave_);
    enter_ = hn::IfThenZeroElse(is_beside, enter_);
    leave_ = hn::IfThenElse(is_beside, real(-1), leave_);
  }

  HWY_INLINE static RayMask all_or_none(bool all) {
    return hn::FirstN(kRays, all ? hn::Lanes(kRays) : 0);
  }

  HWY_INLINE RayMask before_end() const {
    if constexpr (kMode == RayMode::iso) {
      return hn::Le(k_, hn::Min(leave_, hn::Add(stop_, real(kBehindStop))));
    }
    const RayMask in_box = hn::Le(k_, leave_);
    if constexpr (kMode != RayMode::volume) return in_box;
    const RayMask at_stop = hn::AndNot(is_done_before(), hn::Eq(k_, stop_));
    return hn::And(in_box, hn::Or(hn::Lt(k_, stop_), at_stop));
  }

  HWY_INLINE RayMask is_done_before() const {
    return hn::Or(done_before_, hn::Eq(back_k_, k_));
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
    mark_bricks(hn::And(moved, hn::Gt(slot_, whole(-1))));
    brick_ = hn::IfThenElse(of_wholes(active), brick_, whole(-1));
  }

  HWY_INLINE void mark_bricks(hn::Mask<decltype(kWhole)> in_memory) const {
    alignas(64) std::int32_t slots[16];
    hn::Store(hn::IfThenElse(in_memory, slot_, whole(-1)), kWhole, slots);
    for (std::size_t i = 0; i < hn::Lanes(kWhole); ++i) {
      if (slots[i] >= 0) mark_used(f_.bricks, slots[i]);
    }
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

  /// Takes the samples of some lanes, or the parts of their rays that begin or end there. Returns
  /// what is next, where without ends of rays that is `next`.
  HWY_INLINE Reals take(RayMask taking, Reals next) {
    const Corners corner = corners(taking);
    if constexpr (kMode == RayMode::volume) {
      return take_parts(taking, corner);
    } else if constexpr (kMode == RayMode::mean) {
      const Reals length = hn::Sub(hn::Min(next, leave_), k_);
      const Reals k_middle = hn::Add(k_, hn::Mul(real(0.5f), length));
      const Corners middle = near_corners(k_middle, before_, corner.at);
      const Reals value = value_at<kIsWide>(f_.bricks, middle);
      const RayMask seen = seen_of(taking, middle);
      red_ = hn::IfThenElse(seen, hn::Add(red_, hn::Mul(value, length)), red_);
      gathered_ = hn::IfThenElse(seen, hn::Add(gathered_, length), gathered_);
      return next;
    }
    const Reals value = hn::Mul(value_at<kIsWide>(f_.bricks, corner), real(f_.sign));
    if constexpr (kMode == RayMode::extreme) {
      const RayMask seen = seen_of(taking, corner);
      gathered_ = hn::IfThenElse(seen, hn::Max(gathered_, value), gathered_);
      return next;
    } else {
      const RayMask inside =
          seen_of(hn::And(taking, hn::Ge(value, real(f_.isovalue))), corner);
      hits_ = hn::Or(hits_, inside);
      hit_k_ = hn::IfThenElse(inside, k_, hit_k_);
      hit_at_ = hn::IfThenElse(of_wholes(inside), corner.at, hit_at_);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        hit_before_[axis] =
            hn::IfThenElse(of_wholes(inside), before_[axis], hit_before_[axis]);
      }
      return hn::IfThenElse(inside, real(kRayDone), next);
    }
  }

  /// Lanes at whose places a voxel is seen.
  HWY_INLINE RayMask seen_of(RayMask lanes, const Corners& corner) const {
    if (f_.bricks.looks == nullptr) return lanes;
    const Wholes begins =
        hn::GatherIndex(kWhole, f_.looks.begins, looks_at(f_.bricks, corner));
    return hn::And(lanes, of_reals(hn::Gt(begins, whole(-1))));
  }

  HWY_INLINE Reals value_near(Reals k, const Corners& corner) const {
    return value_at<kIsWide>(f_.bricks, near_corners(k, before_, corner.at));
  }

  /// The parts behind k_; before them, where nothing was seen before, the parts that end at k_.
  HWY_INLINE Reals take_parts(RayMask taking, const Corners& corner) {
    const RayMask known = hn::And(taking, hn::Eq(back_k_, k_));
    Reals from = k_;
    Reals to = hn::IfThenElse(
        known, hn::Min(hn::Add(hn::Floor(k_), real(1)), hn::Min(leave_, stop_)), k_);
    Wholes front = back_entry_;
    const RayMask unknown = hn::AndNot(known, taking);
    if (!hn::AllFalse(kRays, unknown)) {
      const Reals before = hn::Max(hn::Sub(hn::Ceil(k_), real(1)), hn::Max(enter_, from_));
      from = hn::IfThenElse(hn::AndNot(done_before_, unknown), before, from);
      const Wholes entries = entries_of(f_.table, value_near(from, corner));
      front = hn::IfThenElse(of_wholes(unknown), entries, front);
    }
    // What is found there is the front of the next one.
    const RayMask is_empty = hn::And(taking, hn::Ge(from, to));
    taken_ -= static_cast<std::int64_t>(hn::CountTrue(kRays, is_empty));

    // Of other lanes a place where they are.
    to = hn::IfThenElse(taking, to, k_);
    const Wholes back = entries_of(f_.table, value_near(to, corner));
    back_k_ = hn::IfThenElse(taking, to, back_k_);
    back_entry_ = hn::IfThenElse(of_wholes(taking), back, back_entry_);

    Wholes entry = hn::IfThenElseZero(
        of_wholes(taking), hn::Add(hn::Mul(front, whole(ColorTable::kSide)), back));
    const Reals middle = hn::Mul(hn::Add(from, to), real(0.5f));
    RayMask visible = taking;
    Wholes look = hn::Zero(kWhole);
    if (f_.bricks.looks != nullptr) {
      look = looks_at(f_.bricks, near_corners(middle, before_, corner.at));
      const Wholes begins = hn::GatherIndex(kWhole, f_.looks.begins, look);
      visible = hn::And(taking, of_reals(hn::Gt(begins, whole(-1))));
      entry = hn::Add(entry, hn::Max(begins, whole(0)));
    }
    const Reals length = hn::IfThenElse(taking, hn::Sub(to, from), real(1));
    const Reals opacity =
        opacities_of_parts(hn::GatherIndex(kRays, f_.table.opacities, entry), length);
    const RayMask seen = hn::And(visible, hn::Gt(opacity, hn::Zero(kRays)));
    Reals next = hn::IfThenElse(hn::Lt(to, leave_), to, real(kRayDone));
    if (hn::AllFalse(kRays, seen)) return next;
    composite(seen, {opacity, entry, look, middle}, near_corners(middle, before_, corner.at));
    const RayMask is_enough = hn::And(seen, hn::Ge(gathered_, real(f_.enough)));
    return hn::IfThenElse(is_enough, real(kRayDone), next);
  }

  /// Parts of rays.
  struct PacketPart {
    Reals opacity;
    Wholes entry;
    Wholes look;
    Reals k;  // of their middles
  };

  HWY_INLINE void composite(RayMask seen, const PacketPart& part, const Corners& middle) {
    const ColorTable& table = f_.table;
    Reals weight = hn::IfThenElseZero(seen, hn::Mul(part.opacity, hn::Sub(real(1), gathered_)));
    PacketLight light{real(kFlatLight), hn::Zero(kRays), hn::Zero(kRays)};
    const bool has_slope = table.gradient_rise > 0;
    const RayMask is_lit =
        has_slope ? seen : hn::And(seen, hn::Gt(weight, real(kUnlitWeight)));
    if (!hn::AllFalse(kRays, is_lit)) {
      const Gradients gradient = f_.has_cell_gradients
                                     ? cell_gradient_at<kIsWide>(f_.bricks, middle)
                                     : gradient_at<kIsWide>(f_.bricks, middle);
      const PacketLight full = light_on(f_, gradient, shade_around(part.k));
      light = {hn::IfThenElse(is_lit, full.light, light.light),
               hn::IfThenElseZero(is_lit, full.highlight), full.slope};
    }
    if (has_slope) {
      const Reals rise = hn::Mul(hn::Sub(light.slope, real(table.gradient_begin)),
                                 real(table.gradient_rise));
      weight = hn::Mul(weight, hn::Min(hn::Max(rise, hn::Zero(kRays)), real(1)));
    }
    Wholes color =
        hn::GatherIndex(kWhole, reinterpret_cast<const std::int32_t*>(table.colors), part.entry);
    if (f_.bricks.looks != nullptr) {
      const Wholes own = hn::GatherIndex(
          kWhole, reinterpret_cast<const std::int32_t*>(f_.looks.colors), part.look);
      color = hn::IfThenElse(hn::Ne(own, hn::Zero(kWhole)), own, color);
    }
    const Reals lit = hn::Mul(hn::Mul(weight, light.light), real(1 / 255.0f));
    const Reals shine = hn::Mul(weight, light.highlight);
    const auto add = [&](Wholes shifted, Reals& sum) HWY_ATTR {
      const Reals channel = hn::ConvertTo(kRays, hn::And(shifted, whole(255)));
      sum = hn::Add(sum, hn::Add(hn::Mul(channel, lit), shine));
    };
    add(color, red_);
    add(hn::ShiftRight<8>(color), green_);
    add(hn::ShiftRight<16>(color), blue_);
    gathered_ = hn::Add(gathered_, weight);
  }

  HWY_INLINE PacketShade shade_around(Reals k) const {
    Reals place[3];
    place_at(k, place);
    return shade_at(f_.shade, place);
  }

  /// The corners of places that lie less than a step from those in the cells `cell`.
  HWY_INLINE Corners near_corners(Reals k, const Wholes* cell, Wholes cell_at) const {
    const BrickTables& b = f_.bricks;
    Corners moved;
    Reals place[3];
    Wholes by[3];
    place_at(k, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Wholes before = cell[axis];
      const Wholes at =
          clamped(floor_of(place[axis]), hn::Sub(before, whole(1)), hn::Add(before, whole(1)));
      by[axis] = hn::Sub(at, before);
      moved.share[axis] = hn::Sub(place[axis], hn::ConvertTo(kRays, at));
    }
    moved.at = hn::Add(
        cell_at,
        hn::Add(hn::Add(hn::Mul(by[2], whole(b.plane)), hn::Mul(by[1], whole(b.row))), by[0]));
    return moved;
  }

  HWY_INLINE RayMask is_inside(Reals k) const {
    const Corners corner = near_corners(k, hit_before_, hit_at_);
    const Reals value = value_at<kIsWide>(f_.bricks, corner);
    return seen_of(hn::Ge(hn::Mul(value, real(f_.sign)), real(f_.isovalue)), corner);
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
    const Corners corner = near_corners(inside, hit_before_, hit_at_);
    Gradients gradient = gradient_at<kIsWide>(f_.bricks, corner);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto is_axis = hn::Eq(enter_axis_, whole(static_cast<std::int32_t>(axis)));
      const Reals face = hn::IfThenElseZero(of_reals(is_axis), real(kCutGradient));
      gradient.along[axis] = hn::IfThenElse(is_cut, face, gradient.along[axis]);
    }
    const PacketLight light = light_on(f_, gradient, shade_around(inside));
    red_ = hn::IfThenElse(lanes, light.light, red_);
    green_ = hn::IfThenElse(lanes, light.highlight, green_);
    blue_ = hn::IfThenElse(lanes, inside, blue_);
    Reals shown = real(1);
    if (f_.bricks.looks != nullptr) {
      shown = hn::Add(shown, hn::ConvertTo(kRays, looks_at(f_.bricks, corner)));
    }
    gathered_ = hn::IfThenElse(lanes, shown, gathered_);
  }

  HWY_INLINE void keep(Wholes waits_for) {
    k_ = hn::IfThenElse(hn::Le(k_, leave_), k_, real(kRayDone));
    if constexpr (kMode == RayMode::volume) {
      const RayMask is_kept = hn::And(is_done_before(), hn::Lt(k_, real(kRayDone)));
      k_ = hn::IfThenElse(is_kept, hn::Sub(hn::Zero(kRays), k_), k_);
    }
    hn::Store(waits_for, kWhole, tile_.waits_for.data() + first_);
    hn::Store(k_, kRays, tile_.k.data() + first_);
    hn::Store(gathered_, kRays, tile_.gathered.data() + first_);
    if constexpr (kMode != RayMode::extreme) hn::Store(red_, kRays, tile_.red.data() + first_);
    if constexpr (kMode == RayMode::volume || kMode == RayMode::iso) {
      hn::Store(green_, kRays, tile_.green.data() + first_);
      hn::Store(blue_, kRays, tile_.blue.data() + first_);
    }
  }

  const RayFrame& f_;
  RayTile& tile_;
  std::int64_t taken_ = 0;
  std::size_t first_;
  Reals origin_[3];
  Reals step_[3];
  Reals enter_;
  Reals leave_;
  Wholes enter_axis_;
  Reals stop_;
  Reals from_;
  Reals k_;
  Reals place_[3];
  Wholes before_[3];
  Wholes inside_[3];
  Wholes brick_ = whole(-1);
  Wholes brick_begin_[3];
  Wholes slot_;
  Wholes brick_at_;
  Reals brick_bound_;
  RayMask done_before_;  // what lies before the next sample
  Reals back_k_;         // samples whose entries are known
  Wholes back_entry_;
  RayMask hits_;
  Reals hit_k_;
  Wholes hit_at_;
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
