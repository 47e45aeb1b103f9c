// Rays side by side in the lanes of vectors: what ray_portable.cpp does for one.
//
// Neighbors in a tile are neighbors in the volume. Packets mostly go together, one step after the
// other: what is empty around all of them is skipped at once, and samples come out of a small block
// that all look at. Where they are not in one brick, each lane goes on for itself; one whose ray is
// done, waits or skips is masked out, and what it would read is sample 0.
//
//     together in a brick? -> yes: nothing around? -> skip  |  else: a step of all rays
//                             no:  a sample of each ray, or what it skips

#if defined(OCTAVO_RENDER_RAYS_RAY_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_RENDER_RAYS_RAY_PACKET_INL_H_
#undef OCTAVO_RENDER_RAYS_RAY_PACKET_INL_H_
#else
#define OCTAVO_RENDER_RAYS_RAY_PACKET_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "octavo/render/rays/ray_block-inl.h"
#include "octavo/render/rays/ray_colors-inl.h"
#include "octavo/render/rays/ray_course-inl.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_lanes-inl.h"
#include "octavo/render/rays/ray_lines-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

/// The rays of as many neighbors as a vector has lanes.
template <RayMode kMode, bool kIsWide, bool kHasCuts>
class Packet {
 public:
  HWY_INLINE Packet(const RayFrame& frame, RayTile& tile, std::size_t first)
      : f_(frame),
        tile_(tile),
        first_(first),
        lines_(lines_of(
            frame, hn::Add(real(tile.u), hn::Load(kRays, kTileOrder.column.data() + first)),
            hn::Add(real(tile.v), hn::Load(kRays, kTileOrder.row.data() + first)),
            kMode == RayMode::extreme)) {
    stop_ = real(kRayDone);
    from_ = real(-kRayDone);
    if (tile.stops) {
      stop_ = hn::Load(kRays, tile.stops->stop.data() + first);
      from_ = hn::Load(kRays, tile.stops->from.data() + first);
    }
    sums_.gathered = hn::Load(kRays, tile.gathered.data() + first);
    brick_next_ = real(-1);
    hits_ = hn::FirstN(kRays, 0);
    hit_.begin();
    back_k_ = real(-1);
    back_entry_ = hn::Zero(kWhole);
    if constexpr (kMode != RayMode::extreme) sums_.red = hn::Load(kRays, tile.red.data() + first);
    if constexpr (kMode == RayMode::volume || kMode == RayMode::iso) {
      sums_.green = hn::Load(kRays, tile.green.data() + first);
      sums_.blue = hn::Load(kRays, tile.blue.data() + first);
    }
  }

  HWY_INLINE std::int64_t follow() {
    const Reals kept = hn::Load(kRays, tile_.k.data() + first_);
    k_ = hn::Max(hn::Abs(kept), lines_.enter);
    keep_to(occupied_span_of(tile_, first_));
    done_before_ = hn::Lt(kept, hn::Zero(kRays));
    Wholes waits_for = whole(-1);
    RayMask active = before_end();
    if (!hn::AllFalse(kRays, active)) course_ = PacketCourse(f_, lines_, kMode == RayMode::iso);
    while (!hn::AllFalse(kRays, active)) {
      if constexpr (kMode != RayMode::mean) {
        go_together(active);
        active = hn::And(active, before_end());
        if (hn::AllFalse(kRays, active)) break;
      }
      enter_bricks(active);

      // What is in a brick worth looking at, and what has to wait for it.
      const RayMask in_brick = hn::And(active, hn::Gt(brick_bound_, held()));
      const RayMask missing = hn::And(in_brick, of_reals(hn::Lt(slot_, whole(0))));
      if (!hn::AllFalse(kRays, missing)) {
        waits_for = hn::IfThenElse(of_wholes(missing), brick_, waits_for);
        active = hn::AndNot(missing, active);
      }
      const RayMask present = hn::AndNot(missing, in_brick);
      const PacketCubes cubes = cubes_around(present);
      const RayMask taking = hn::And(present, hn::Gt(cubes.bound, held()));

      // Samples; the others skip.
      Reals next = hn::Max(hn::Add(hn::Floor(k_), real(1)),
                           hn::IfThenElse(present, cubes.next, brick_next_));
      next = limited(k_, next);
      if constexpr (kMode == RayMode::volume) {
        // Nothing is seen from the sample before on, as far as the stop.
        const RayMask skipping = hn::AndNot(taking, active);
        const RayMask at_stop = hn::And(skipping, hn::Eq(k_, stop_));
        done_before_ = hn::Or(at_stop, hn::AndNot(skipping, done_before_));
        next = hn::Min(next, stop_);
      }
      if (!hn::AllFalse(kRays, taking)) next = hn::IfThenElse(taking, take(taking), next);
      k_ = hn::IfThenElse(active, next, k_);
      active = hn::And(active, before_end());
    }
    // All lanes find their places together.
    if (kMode == RayMode::iso && !hn::AllFalse(kRays, hits_)) {
      PacketHits<kIsWide, kHasCuts>(f_, lines_, hits_, hit_).light(sums_);
    }
    keep(waits_for);
    return taken_;
  }

 private:
  using Rows = BrickRows<kIsWide>;

  HWY_INLINE const RayCuts* cuts() const { return kHasCuts ? f_.cuts : nullptr; }

  /// The cubes around places.
  struct PacketCubes {
    Reals bound;
    Reals next;  // the first sample behind each
  };

  HWY_INLINE RayMask before_end() const {
    if constexpr (kMode == RayMode::iso) return hn::Le(k_, end_of_search());
    const RayMask in_box = hn::Le(k_, lines_.leave);
    if constexpr (kMode != RayMode::volume) return in_box;
    const RayMask at_stop = hn::AndNot(is_done_before(), hn::Eq(k_, stop_));
    return hn::And(in_box, hn::Or(hn::Lt(k_, stop_), at_stop));
  }

  HWY_INLINE Reals end_of_search() const {
    return hn::Min(lines_.leave, hn::Add(stop_, real(kBehindStop)));
  }

  HWY_INLINE RayMask is_done_before() const {
    return hn::Or(done_before_, hn::Eq(back_k_, k_));
  }

  HWY_INLINE Reals held() const {
    if constexpr (kMode == RayMode::extreme) return sums_.gathered;
    else return hn::Zero(kRays);
  }

  HWY_INLINE RayMask is_full() const { return hn::Ge(sums_.gathered, real(f_.enough)); }

  HWY_INLINE void count(RayMask lanes) {
    taken_ += static_cast<std::int64_t>(hn::CountTrue(kRays, lanes));
  }

  /// Rays begin and end where there may be anything.
  HWY_INLINE void keep_to(const OccupiedSpan* span) {
    if (span == nullptr) return;
    k_ = hn::Max(k_, real(span->first));
    lines_.leave = hn::Min(lines_.leave, real(span->last));
  }

  // Each lane for itself.

  /// The bricks of rays that have left the ones before.
  HWY_INLINE void enter_bricks(RayMask active) {
    const RayMask moved = hn::And(active, hn::Ge(k_, brick_next_));
    if (hn::AllFalse(kRays, moved)) return;
    const BrickTables& b = f_.bricks;
    Reals place[3];
    Wholes brick[3];
    lines_.place_at(k_, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Wholes inside =
          clamped(floor_of(place[axis]), whole(0), whole(b.size[axis] - 1));
      brick[axis] = hn::ShiftRightSame(inside, b.shift);
    }
    Wholes number = hn::Add(hn::Mul(brick[2], whole(b.grid[1])), brick[1]);
    number = hn::Add(hn::Mul(number, whole(b.grid[0])), brick[0]);
    const auto is_other = of_wholes(moved);
    brick_ = hn::IfThenElse(is_other, number, brick_);
    // What lanes that are done would look at is brick 0.
    const Wholes looked_at = hn::IfThenElseZero(of_wholes(active), brick_);
    brick_bound_ = hn::GatherIndex(kRays, b.brick_bounds, looked_at);
    slot_ = hn::GatherIndex(kWhole, b.slots, looked_at);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Wholes begin = hn::ShiftLeftSame(brick[axis], b.shift);
      brick_begin_[axis] = hn::IfThenElse(is_other, begin, brick_begin_[axis]);
    }
    const Wholes rows = hn::Mul(brick_begin_[1], whole(b.row));
    const Wholes planes = hn::Mul(brick_begin_[2], whole(b.plane));
    const Wholes begins = hn::Add(hn::Add(planes, rows), brick_begin_[0]);
    base_ = hn::Add(hn::Sub(hn::Mul(slot_, whole(b.slot)), begins), whole(inner_sample(b)));
    const Reals next = lines_.next_behind(brick_begin_, 1 << b.shift, f_.margin);
    brick_next_ = hn::IfThenElse(moved, next, brick_next_);
    mark_bricks(hn::And(is_other, hn::Gt(slot_, whole(-1))));
  }

  HWY_INLINE void mark_bricks(hn::Mask<decltype(kWhole)> in_memory) const {
    alignas(64) std::int32_t slots[16];
    hn::Store(hn::IfThenElse(in_memory, slot_, whole(-1)), kWhole, slots);
    for (std::size_t i = 0; i < hn::Lanes(kWhole); ++i) {
      if (slots[i] >= 0) mark_used(f_.bricks, slots[i]);
    }
  }

  HWY_INLINE PacketCubes cubes_around(RayMask present) const {
    const int bits = f_.bricks.shift - kSkipShift;
    Reals place[3];
    Wholes cube[3];
    Wholes begin[3];
    lines_.place_at(k_, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Wholes local =
          clamped(hn::Sub(floor_of(place[axis]), brick_begin_[axis]), hn::Zero(kWhole),
                  whole((1 << f_.bricks.shift) - 1));
      cube[axis] = hn::ShiftRight<kSkipShift>(local);
      begin[axis] = hn::Add(brick_begin_[axis], hn::ShiftLeft<kSkipShift>(cube[axis]));
    }
    const Wholes z = hn::Add(hn::ShiftLeftSame(slot_, bits), cube[2]);
    const Wholes y = hn::Add(hn::ShiftLeftSame(z, bits), cube[1]);
    const Wholes number = hn::Add(hn::ShiftLeftSame(y, bits), cube[0]);
    const Wholes looked_at = hn::IfThenElseZero(of_wholes(present), number);
    return {hn::GatherIndex(kRays, f_.bricks.cube_bounds, looked_at),
            lines_.next_behind(begin, kSkipSide, f_.margin)};
  }

  /// `next`, but the ends of rays before what lies beyond them.
  HWY_INLINE Reals limited(Reals k, Reals next) const {
    const Reals last = hn::IfThenElse(hn::Lt(k, lines_.leave), lines_.leave, real(kRayDone));
    return hn::IfThenElse(hn::Lt(next, lines_.leave), next, last);
  }

  HWY_INLINE Reals after(Reals k) const { return limited(k, hn::Add(hn::Floor(k), real(1))); }

  /// Of rays that are in a brick; others look at a sample that is there.
  /// cuts  where values come from; none: of gradients
  HWY_INLINE Corners corners_at(Reals k, RayMask lanes, Wholes base, const RayCuts* cuts) const {
    Corners corners;
    Reals place[3];
    Reals floor[3];
    Wholes cell[3];
    lines_.place_at(k, place);
    for (std::size_t axis = 0; axis < 3; ++axis) floor[axis] = hn::Floor(place[axis]);
    keep_places(cuts, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      corners.share[axis] = hn::Sub(place[axis], floor[axis]);
      cell[axis] = hn::ConvertTo(kWhole, floor[axis]);
    }
    corners.at = hn::IfThenElse(of_wholes(lanes), sample_at(f_.bricks, base, cell),
                                whole(inner_sample(f_.bricks)));
    return corners;
  }

  HWY_INLINE Reals value_of(const Corners& corners) const {
    const Reals value = value_at(Rows{f_.bricks}, corners);
    if constexpr (kMode == RayMode::volume || kMode == RayMode::mean) return value;
    else return hn::Mul(value, real(f_.sign));
  }

  /// Takes the samples of some lanes, or parts of their rays. Returns what is next.
  HWY_INLINE Reals take(RayMask taking) {
    if constexpr (kMode == RayMode::volume) return take_parts(taking);
    count(taking);
    const Reals next = after(k_);
    if constexpr (kMode == RayMode::mean) {
      const Reals length = hn::Sub(hn::Min(next, lines_.leave), k_);
      const Reals at = hn::Add(k_, hn::Mul(real(0.5f), length));
      const Corners middle = corners_at(at, taking, base_, cuts());
      const Reals value = value_of(middle);
      const RayMask seen = seen_of(f_, taking, middle);
      sums_.red = hn::IfThenElse(seen, hn::Add(sums_.red, hn::Mul(value, length)), sums_.red);
      sums_.gathered = hn::IfThenElse(seen, hn::Add(sums_.gathered, length), sums_.gathered);
      return next;
    }
    const Corners corner = corners_at(k_, taking, base_, cuts());
    return add_samples(taking, {k_, value_of(corner), base_}, corner, next);
  }

  /// Modes extreme and iso. Returns what is next: of rays that have hit nothing.
  HWY_INLINE Reals add_samples(RayMask lanes, const PacketSamples& samples,
                               const Corners& corner, Reals next) {
    if constexpr (kMode == RayMode::extreme) {
      const RayMask seen = seen_of(f_, lanes, corner);
      sums_.gathered =
          hn::IfThenElse(seen, hn::Max(sums_.gathered, samples.value), sums_.gathered);
      return next;
    } else {
      const RayMask inside = seen_of(
          f_, hn::And(lanes, hn::Ge(samples.value, real(f_.isovalue))), corner);
      hits_ = hn::Or(hits_, inside);
      hit_.add(lanes, inside, samples);
      return hn::IfThenElse(inside, real(kRayDone), next);
    }
  }

  HWY_INLINE Wholes entries_at(Reals k, RayMask lanes, Wholes base) const {
    return entries_of(f_.table, value_of(corners_at(k, lanes, base, cuts())));
  }

  /// Where parts begin of which it is not known what lies before them.
  HWY_INLINE Reals begins_of(RayMask unknown) const {
    const Reals before =
        hn::Max(hn::Sub(hn::Ceil(k_), real(1)), hn::Max(lines_.enter, from_));
    return hn::IfThenElse(hn::AndNot(done_before_, unknown), before, k_);
  }

  /// The parts behind k_; before them, where nothing was seen before, the parts that end at k_.
  HWY_INLINE Reals take_parts(RayMask taking) {
    const RayMask known = hn::And(taking, hn::Eq(back_k_, k_));
    Reals from = k_;
    Reals to = hn::IfThenElse(
        known, hn::Min(hn::Add(hn::Floor(k_), real(1)), hn::Min(lines_.leave, stop_)), k_);
    Wholes front = back_entry_;
    const RayMask unknown = hn::AndNot(known, taking);
    if (!hn::AllFalse(kRays, unknown)) {
      from = begins_of(unknown);
      front = hn::IfThenElse(of_wholes(unknown), entries_at(from, unknown, base_), front);
    }
    const Wholes back = entries_at(to, taking, base_);
    back_k_ = hn::IfThenElse(taking, to, back_k_);
    back_entry_ = hn::IfThenElse(of_wholes(taking), back, back_entry_);
    add_parts(taking, {from, to, front, back}, base_, [&](RayMask seen, Reals middle) HWY_ATTR {
      return brick_gradients(seen, middle, base_);
    });
    const Reals next = hn::IfThenElse(hn::Lt(to, lines_.leave), to, real(kRayDone));
    return hn::IfThenElse(is_full(), real(kRayDone), next);
  }

  /// Parts of rays.
  struct PacketPart {
    Reals from;
    Reals to;
    Wholes front;
    Wholes back;
  };

  HWY_INLINE Gradients brick_gradients(RayMask seen, Reals middle, Wholes base) const {
    const Corners corners = corners_at(middle, seen, base, nullptr);
    return f_.has_cell_gradients ? cell_gradient_at(Rows{f_.bricks}, corners)
                                 : gradient_at(Rows{f_.bricks}, corners);
  }

  /// gradients  those of some lanes at places along them
  template <class GradientsAt>
  HWY_INLINE void add_parts(RayMask lanes, const PacketPart& part, Wholes base,
                            const GradientsAt& gradients) {
    // What is empty is but the front of what follows.
    const RayMask run = hn::And(lanes, hn::Lt(part.from, part.to));
    count(run);
    Wholes entry = hn::IfThenElseZero(
        of_wholes(run), hn::Add(hn::Mul(part.front, whole(ColorTable::kSide)), part.back));
    const Reals middle = hn::Mul(hn::Add(part.from, part.to), real(0.5f));
    RayMask visible = run;
    Wholes look = hn::Zero(kWhole);
    if (f_.bricks.looks != nullptr) {
      look = looks_at(f_.bricks, corners_at(middle, run, base, nullptr));
      const Wholes begins = hn::GatherIndex(kWhole, f_.looks.begins, look);
      visible = hn::And(run, of_reals(hn::Gt(begins, whole(-1))));
      entry = hn::Add(entry, hn::Max(begins, whole(0)));
    }
    const Reals length = hn::IfThenElse(run, hn::Sub(part.to, part.from), real(1));
    const Reals opacity =
        opacities_of_parts(hn::GatherIndex(kRays, f_.table.opacities, entry), length);
    const RayMask seen = hn::And(visible, hn::Gt(opacity, hn::Zero(kRays)));
    if (hn::AllFalse(kRays, seen)) return;
    const auto at_middles = [&]() HWY_ATTR { return gradients(seen, middle); };
    composite(f_, lines_, seen, {opacity, entry, look, middle}, at_middles, sums_);
  }

  // All together.

  /// Lanes that go together.
  struct CommonRays {
    RayMask open;
    Reals lower;        // where each begins
    Reals end;
    Reals front_k;      // samples that are known
    Wholes front_entry;
  };

  /// Steps that rays take together until they look again where they are.
  static constexpr int kStride = kMode == RayMode::extreme ? 2 : 1;

  HWY_INLINE void go_together(RayMask active) {
    CommonRays rays;
    rays.lower = k_;
    rays.end = lines_.leave;
    rays.front_k = back_k_;
    rays.front_entry = back_entry_;
    RayMask joined = active;
    if constexpr (kMode == RayMode::volume) {
      rays.end = hn::Min(rays.end, stop_);
      rays.lower = begins_of(hn::AndNot(hn::Eq(back_k_, k_), active));
    }
    if constexpr (kMode == RayMode::iso) joined = hn::And(joined, hn::Lt(k_, end_of_search()));
    joined = hn::And(joined, hn::Lt(rays.lower, rays.end));
    if (hn::AllFalse(kRays, joined)) return;
    const float first =
        std::floor(lowest_of(hn::IfThenElse(joined, rays.lower, real(kRayDone))));
    const float last = highest_of(hn::IfThenElse(joined, rays.end, real(-1)));
    rays.open = joined;
    CommonBrick brick;
    StepBits steps;
    float k = first;
    while (k < last && !hn::AllFalse(kRays, rays.open)) {
      const float next = past_empty(rays, steps, k);
      if (next > k) {
        k = next;
        pass_samples(rays, k);
        continue;
      }
      const bool stays = k + kStride <= brick.until;
      if (!stays && !course_.enter_common(course_.cells_around(k, kStride), brick)) break;
      for (int i = 0; i < kStride; ++i) {
        step_together(rays, brick, k);
        k += 1;
      }
    }
    if (k > first) leave_together(rays, joined, k);
  }

  /// Where anything may be found from k on.
  HWY_INLINE float past_empty(const CommonRays& rays, StepBits& steps, float k) const {
    if constexpr (kMode != RayMode::extreme) return course_.next_occupied(k, steps);
    const float held = lowest_of(hn::IfThenElse(rays.open, sums_.gathered, real(kRayDone)));
    return course_.next_above(k, kStride, held);
  }

  /// Samples as far as k are nothing new.
  HWY_INLINE void pass_samples(CommonRays& rays, float k) const {
    if constexpr (kMode == RayMode::volume) return;
    const RayMask passed = hn::Le(rays.lower, real(k));
    rays.front_k = hn::IfThenElse(passed, hn::Min(real(k), lines_.leave), rays.front_k);
  }

  /// Each ray goes on for itself.
  HWY_INLINE void leave_together(const CommonRays& rays, RayMask joined, float k) {
    Reals next = hn::Min(hn::Max(real(k), rays.lower), rays.end);
    if constexpr (kMode == RayMode::volume) {
      const RayMask is_over = hn::Or(hn::Ge(next, lines_.leave), is_full());
      next = hn::IfThenElse(is_over, real(kRayDone), next);
      done_before_ = hn::Or(joined, done_before_);
      back_k_ = hn::IfThenElse(joined, rays.front_k, back_k_);
      back_entry_ = hn::IfThenElse(of_wholes(joined), rays.front_entry, back_entry_);
    } else {
      next = hn::IfThenElse(hn::Ge(rays.front_k, rays.lower), after(rays.front_k), rays.lower);
      if constexpr (kMode == RayMode::iso) next = hn::IfThenElse(hits_, real(kRayDone), next);
    }
    k_ = hn::IfThenElse(joined, next, k_);
  }

  /// All rays from k to k + 1, as far as they go.
  HWY_INLINE void step_together(CommonRays& rays, const CommonBrick& brick, float k) {
    const Reals from = hn::Min(hn::Max(real(k), rays.lower), rays.end);
    const Reals to = hn::Min(hn::Max(real(k + 1), rays.lower), rays.end);
    RayMask run = hn::And(rays.open, hn::Lt(from, to));
    const RayMask fresh = hn::And(run, hn::Ne(rays.front_k, from));
    if constexpr (kMode == RayMode::volume) {
      if (!hn::AllFalse(kRays, fresh)) {
        const Wholes found = entries_of(f_.table, common_value(brick, k, from, fresh));
        rays.front_entry = hn::IfThenElse(of_wholes(fresh), found, rays.front_entry);
      }
      const Wholes back = entries_of(f_.table, common_value(brick, k + 1, to, run));
      add_parts(run, {from, to, rays.front_entry, back}, base_of(brick),
                [&](RayMask seen, Reals middle) HWY_ATTR {
                  return common_gradients(brick, k + 0.5f, middle, seen);
                });
      rays.front_k = hn::IfThenElse(run, to, rays.front_k);
      rays.front_entry = hn::IfThenElse(of_wholes(run), back, rays.front_entry);
      rays.open = hn::AndNot(is_full(), rays.open);
    } else {
      if (!hn::AllFalse(kRays, fresh)) take_together(rays, brick, k, from, fresh);
      if constexpr (kMode == RayMode::iso) run = hn::And(run, hn::Le(to, end_of_search()));
      take_together(rays, brick, k + 1, to, hn::And(run, rays.open));
    }
  }

  HWY_INLINE void take_together(CommonRays& rays, const CommonBrick& brick, float k, Reals at,
                                RayMask lanes) {
    count(lanes);
    const Wholes base = base_of(brick);
    Corners corner{};
    if (f_.bricks.looks != nullptr) corner = corners_at(at, lanes, base, cuts());
    const Reals value = hn::Mul(common_value(brick, k, at, lanes), real(f_.sign));
    add_samples(lanes, {at, value, base}, corner, at);
    rays.front_k = hn::IfThenElse(lanes, at, rays.front_k);
    if constexpr (kMode == RayMode::iso) rays.open = hn::AndNot(hits_, rays.open);
  }

  HWY_INLINE Wholes base_of(const CommonBrick& brick) const {
    return whole(static_cast<std::int32_t>(brick.base));
  }

  /// Values of lanes at `at`, of which most are k.
  HWY_INLINE Reals common_value(const CommonBrick& brick, float k, Reals at,
                                RayMask lanes) const {
#ifdef OCTAVO_HAS_SAMPLE_BLOCKS
    if constexpr (!kIsWide) {
      BlockCell low;
      const RayMask beside = hn::And(lanes, hn::Ne(at, real(k)));
      if (hn::AllFalse(kRays, beside) && course_.find_block(brick, k, low)) {
        return value_at(block_at(f_.bricks, course_.block_begin(brick, low)),
                        block_corners(lines_, cuts(), k, low));
      }
    }
#endif
    return value_at(Rows{f_.bricks}, corners_at(at, lanes, base_of(brick), cuts()));
  }

  HWY_INLINE Gradients common_gradients(const CommonBrick& brick, float k, Reals at,
                                        RayMask lanes) const {
#ifdef OCTAVO_HAS_SAMPLE_BLOCKS
    if constexpr (!kIsWide) {
      BlockCell low;
      const RayMask beside = hn::And(lanes, hn::Ne(at, real(k)));
      const bool is_short = f_.has_cell_gradients || f_.bricks.has_short_differences;
      if (is_short && hn::AllFalse(kRays, beside) && course_.find_block(brick, k, low)) {
        const std::int64_t begin = course_.block_begin(brick, low);
        const Corners corners = block_corners(lines_, nullptr, k, low);
        const BrickTables& b = f_.bricks;
        if (f_.has_cell_gradients) return cell_gradient_at(block_at(b, begin), corners);
        return {{value_at(differences_at(b, begin, 1), corners),
                 value_at(differences_at(b, begin, b.row), corners),
                 value_at(differences_at(b, begin, b.plane), corners)}};
      }
    }
#endif
    return brick_gradients(lanes, at, base_of(brick));
  }

  HWY_INLINE void keep(Wholes waits_for) {
    k_ = hn::IfThenElse(hn::Le(k_, lines_.leave), k_, real(kRayDone));
    if constexpr (kMode == RayMode::volume) {
      const RayMask is_kept = hn::And(is_done_before(), hn::Lt(k_, real(kRayDone)));
      k_ = hn::IfThenElse(is_kept, hn::Sub(hn::Zero(kRays), k_), k_);
    }
    hn::Store(waits_for, kWhole, tile_.waits_for.data() + first_);
    hn::Store(k_, kRays, tile_.k.data() + first_);
    hn::Store(sums_.gathered, kRays, tile_.gathered.data() + first_);
    if constexpr (kMode != RayMode::extreme) {
      hn::Store(sums_.red, kRays, tile_.red.data() + first_);
    }
    if constexpr (kMode == RayMode::volume || kMode == RayMode::iso) {
      hn::Store(sums_.green, kRays, tile_.green.data() + first_);
      hn::Store(sums_.blue, kRays, tile_.blue.data() + first_);
    }
  }

  const RayFrame& f_;
  RayTile& tile_;
  std::int64_t taken_ = 0;
  std::size_t first_;
  PacketLines lines_;
  PacketCourse course_;
  Reals stop_;
  Reals from_;
  Reals k_;
  Wholes brick_ = whole(-1);
  Wholes brick_begin_[3] = {hn::Zero(kWhole), hn::Zero(kWhole), hn::Zero(kWhole)};
  Wholes slot_ = whole(-1);
  Wholes base_;          // the sample of cell 0, if the brick went as far
  Reals brick_bound_;
  Reals brick_next_;     // the first sample behind the brick
  RayMask done_before_;  // what lies before the next sample
  Reals back_k_;         // samples whose entries are known
  Wholes back_entry_;
  RayMask hits_;
  PacketHit hit_;
  PacketSums sums_;
};

template <RayMode kMode, bool kIsWide, bool kHasCuts>
std::int64_t follow_packets(const RayFrame& frame, RayTile& tile) {
  std::int64_t taken = 0;
  for (std::size_t first = 0; first < kTileRays; first += hn::Lanes(kRays)) {
    const RayMask is_open = hn::Lt(hn::Load(kRays, tile.k.data() + first), real(kRayDone));
    if (hn::AllFalse(kRays, is_open)) continue;
    const OccupiedSpan* const span = occupied_span_of(tile, first);
    if (span != nullptr && span->first > span->last) {
      hn::Store(real(kRayDone), kRays, tile.k.data() + first);
      hn::Store(whole(-1), kWhole, tile.waits_for.data() + first);
      continue;
    }
    taken += Packet<kMode, kIsWide, kHasCuts>(frame, tile, first).follow();
  }
  return taken;
}

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#endif
