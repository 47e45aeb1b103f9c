// Where rays side by side run, in the lanes of vectors.

#if defined(OCTAVO_RENDER_RAYS_RAY_LINES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_RENDER_RAYS_RAY_LINES_INL_H_
#undef OCTAVO_RENDER_RAYS_RAY_LINES_INL_H_
#else
#define OCTAVO_RENDER_RAYS_RAY_LINES_INL_H_
#endif

#include <hwy/highway.h>

#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

/// Moves places to where their values come from.
HWY_NOINLINE void keep_out_of_cuts(const RayCuts& cuts, Reals* place) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Reals from_first = hn::Max(place[axis], real(cuts.first[axis]));
    place[axis] = hn::Min(from_first, real(cuts.last[axis]));
  }
  for (std::size_t i = 0; i < cuts.hole_count; ++i) {
    const RayCuts::Hole& hole = cuts.holes[i];
    Reals nearest = real(kRayDone);
    Reals moved[3] = {place[0], place[1], place[2]};
    const auto move_to = [&](std::size_t axis, float side, Reals way) HWY_ATTR {
      const RayMask is_nearer = hn::Lt(way, nearest);
      nearest = hn::IfThenElse(is_nearer, way, nearest);
      for (std::size_t other = 0; other < 3; ++other) {
        const Reals to = other == axis ? real(side) : place[other];
        moved[other] = hn::IfThenElse(is_nearer, to, moved[other]);
      }
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float before = hole.before[axis];
      const float behind = hole.behind[axis];
      move_to(axis, before, hn::Sub(place[axis], real(before)));
      move_to(axis, behind, hn::Sub(real(behind), place[axis]));
    }
    // Otherwise they lie beside the hole.
    const RayMask is_beside = hn::Gt(nearest, hn::Zero(kRays));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = hn::IfThenElse(is_beside, moved[axis], place[axis]);
    }
  }
}

/// The same where there are cuts.
HWY_INLINE void keep_places(const RayCuts* cuts, Reals* place) {
  if (cuts == nullptr) return;
  Reals kept[3] = {place[0], place[1], place[2]};
  keep_out_of_cuts(*cuts, kept);
  for (std::size_t axis = 0; axis < 3; ++axis) place[axis] = kept[axis];
}

/// The rays of some neighbors, and where each enters and leaves what is drawn, in steps.
struct PacketLines {
  Reals start;  // where each begins, in steps
  Reals origin[3];
  Reals step[3];
  Reals inverse[3];  // 1 / step
  Reals enter;
  Reals leave;
  Wholes enter_axis;

  HWY_INLINE void place_at(Reals k, Reals* place) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = hn::Add(origin[axis], hn::Mul(k, step[axis]));
    }
  }

  /// The first sample behind boxes of a side.
  HWY_INLINE Reals next_behind(const Wholes* begin, std::int32_t side, float margin) const {
    Reals nearest = real(kRayDone);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const RayMask rises = hn::Gt(step[axis], hn::Zero(kRays));
      const Reals ahead =
          hn::IfThenElse(rises, real(static_cast<float>(side) - margin), real(margin));
      const Reals face = hn::Add(hn::ConvertTo(kRays, begin[axis]), ahead);
      nearest = hn::Min(nearest, hn::Mul(hn::Sub(face, origin[axis]), inverse[axis]));
    }
    return hn::Ceil(nearest);
  }
};

HWY_INLINE RayMask all_or_none(bool all) {
  return hn::FirstN(kRays, all ? hn::Lanes(kRays) : 0);
}

/// Moves samples to the planes of the grid that each ray crosses most squarely. Where there is an
/// eye, which may be inside, rays begin behind the first of them.
HWY_INLINE void move_to_planes(PacketLines& lines, bool has_eye) {
  Reals most = hn::Abs(lines.step[0]);
  Wholes main = hn::Zero(kWhole);
  Reals step = lines.step[0];
  Reals origin = lines.origin[0];
  for (std::size_t axis = 1; axis < 3; ++axis) {
    const RayMask is_more = hn::Gt(hn::Abs(lines.step[axis]), most);
    most = hn::IfThenElse(is_more, hn::Abs(lines.step[axis]), most);
    main = hn::IfThenElse(of_wholes(is_more), whole(static_cast<std::int32_t>(axis)), main);
    step = hn::IfThenElse(is_more, lines.step[axis], step);
    origin = hn::IfThenElse(is_more, lines.origin[axis], origin);
  }
  const Reals scale = hn::Div(real(1), most);
  const RayMask rises = hn::Gt(step, hn::Zero(kRays));
  const RayMask is_above = has_eye ? hn::Not(rises) : rises;
  const Reals plane = hn::IfThenElse(is_above, hn::Ceil(origin), hn::Floor(origin));
  const Reals by = hn::Abs(hn::Sub(plane, origin));
  const Reals ahead = has_eye ? hn::Neg(by) : by;
  if (has_eye) lines.start = by;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const RayMask is_main = of_reals(hn::Eq(main, whole(static_cast<std::int32_t>(axis))));
    const Reals moved = hn::Mul(lines.step[axis], scale);
    lines.origin[axis] = hn::IfThenElse(
        is_main, plane, hn::Add(lines.origin[axis], hn::Mul(ahead, moved)));
    lines.step[axis] =
        hn::IfThenElse(is_main, hn::IfThenElse(rises, real(1), real(-1)), moved);
  }
}

/// Where rays enter and leave.
HWY_INLINE void find_ends(const RayFrame& f, PacketLines& lines) {
  lines.enter = lines.start;
  lines.leave = real(kRayDone);
  lines.enter_axis = whole(2);
  RayMask is_inner_begin = hn::FirstN(kRays, 0);
  RayMask is_inner_end = is_inner_begin;
  Reals end = real(kRayDone);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lines.inverse[axis] = hn::Div(real(1), lines.step[axis]);
    const auto at = [&](float face) HWY_ATTR {
      return hn::Mul(hn::Sub(real(face), lines.origin[axis]), lines.inverse[axis]);
    };
    const Reals low = at(f.low[axis]);
    const Reals high = at(f.high[axis]);
    const RayMask rises = hn::Gt(lines.step[axis], hn::Zero(kRays));
    const bool is_inner_low = f.low[axis] > f.whole_low[axis];
    const bool is_inner_high = f.high[axis] < f.whole_high[axis];
    const auto is_inner = [&](bool where_rising, bool where_falling) HWY_ATTR {
      return hn::Or(hn::And(rises, all_or_none(where_rising)),
                    hn::AndNot(rises, all_or_none(where_falling)));
    };
    const Reals first = hn::Min(low, high);
    const Reals last = hn::Max(low, high);
    const RayMask is_later = hn::Gt(first, lines.enter);
    is_inner_begin = hn::Or(hn::And(is_later, is_inner(is_inner_low, is_inner_high)),
                            hn::AndNot(is_later, is_inner_begin));
    lines.enter = hn::IfThenElse(is_later, first, lines.enter);
    lines.enter_axis = hn::IfThenElse(
        of_wholes(is_later), whole(static_cast<std::int32_t>(axis)), lines.enter_axis);
    const RayMask is_sooner = hn::Lt(last, lines.leave);
    is_inner_end = hn::Or(hn::And(is_sooner, is_inner(is_inner_high, is_inner_low)),
                          hn::AndNot(is_sooner, is_inner_end));
    lines.leave = hn::Min(lines.leave, last);
    end = hn::Min(end, hn::Max(at(f.whole_low[axis]), at(f.whole_high[axis])));
  }
  const RayMask is_beside = hn::Gt(lines.enter, lines.leave);
  lines.enter = hn::IfThenElse(is_inner_begin, hn::Ceil(lines.enter), lines.enter);
  lines.leave =
      hn::IfThenElse(is_inner_end, hn::Min(hn::Ceil(lines.leave), end), lines.leave);
  lines.enter = hn::IfThenZeroElse(is_beside, lines.enter);
  lines.leave = hn::IfThenElse(is_beside, real(-1), lines.leave);
}

/// u, v          of pixels from the middle of the picture
/// is_on_planes  samples lie on planes of the grid
HWY_INLINE PacketLines lines_of(const RayFrame& f, Reals u, Reals v, bool is_on_planes) {
  PacketLines lines;
  lines.start = hn::Zero(kRays);
  Reals scale = real(1);
  if (f.eye_pixels > 0) {
    const Reals eye = real(f.eye_pixels * f.eye_pixels);
    const Reals square = hn::Add(hn::Add(hn::Mul(u, u), hn::Mul(v, v)), eye);
    scale = hn::Div(real(f.step_pixels), hn::Sqrt(square));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lines.origin[axis] =
        hn::Add(hn::Add(real(f.origin[axis]), hn::Mul(u, real(f.origin_across[axis]))),
                hn::Mul(v, real(f.origin_down[axis])));
    const Reals direction =
        hn::Add(hn::Add(real(f.direction[axis]), hn::Mul(u, real(f.direction_across[axis]))),
                hn::Mul(v, real(f.direction_down[axis])));
    const Reals step = hn::Mul(direction, scale);
    lines.step[axis] =
        hn::IfThenElse(hn::Lt(hn::Abs(step), real(kSmallestStep)), real(kSmallestStep), step);
  }
  if (is_on_planes) move_to_planes(lines, f.eye_pixels > 0);
  find_ends(f, lines);
  return lines;
}

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#endif
