// What the lanes of vectors make of what rays meet: colors in light, and surfaces.

#if defined(OCTAVO_RENDER_RAYS_RAY_COLORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_RENDER_RAYS_RAY_COLORS_INL_H_
#undef OCTAVO_RENDER_RAYS_RAY_COLORS_INL_H_
#else
#define OCTAVO_RENDER_RAYS_RAY_COLORS_INL_H_
#endif

#include <hwy/highway.h>

#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_lanes-inl.h"
#include "octavo/render/rays/ray_lines-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

/// What rays have gathered, as in RayTile.
struct PacketSums {
  Reals red;
  Reals green;
  Reals blue;
  Reals gathered;
};

HWY_INLINE PacketShade shade_around(const RayFrame& f, const PacketLines& lines, Reals k) {
  Reals place[3];
  lines.place_at(k, place);
  return shade_at(f.shade, place);
}

/// What is seen of parts of rays.
struct PacketLayer {
  Reals opacity;
  Wholes entry;
  Wholes look;
  Reals k;  // of their middles
};

/// gradients  finds those at the middles
template <class GradientsOf>
HWY_INLINE void composite(const RayFrame& f, const PacketLines& lines, RayMask seen,
                          const PacketLayer& part, const GradientsOf& gradients,
                          PacketSums& sums) {
  const ColorTable& table = f.table;
  Reals weight =
      hn::IfThenElseZero(seen, hn::Mul(part.opacity, hn::Sub(real(1), sums.gathered)));
  PacketLight light{real(kFlatLight), hn::Zero(kRays), hn::Zero(kRays)};
  const bool has_slope = table.gradient_rise > 0;
  const RayMask is_lit = has_slope ? seen : hn::And(seen, hn::Gt(weight, real(f.unlit_weight)));
  if (!hn::AllFalse(kRays, is_lit)) {
    const PacketLight full = light_on(f, gradients(), shade_around(f, lines, part.k));
    light = {hn::IfThenElse(is_lit, full.light, light.light),
             hn::IfThenElseZero(is_lit, full.highlight), full.slope};
  }
  if (has_slope) {
    const Reals rise =
        hn::Mul(hn::Sub(light.slope, real(table.gradient_begin)), real(table.gradient_rise));
    weight = hn::Mul(weight, hn::Min(hn::Max(rise, hn::Zero(kRays)), real(1)));
  }
  Wholes color =
      hn::GatherIndex(kWhole, reinterpret_cast<const std::int32_t*>(table.colors), part.entry);
  if (f.bricks.looks != nullptr) {
    const Wholes own = hn::GatherIndex(
        kWhole, reinterpret_cast<const std::int32_t*>(f.looks.colors), part.look);
    color = hn::IfThenElse(hn::Ne(own, hn::Zero(kWhole)), own, color);
  }
  const Reals lit = hn::Mul(hn::Mul(weight, light.light), real(1 / 255.0f));
  const Reals shine = hn::Mul(weight, light.highlight);
  const auto add = [&](Wholes shifted, Reals& sum) HWY_ATTR {
    const Reals channel = hn::ConvertTo(kRays, hn::And(shifted, whole(255)));
    sum = hn::Add(sum, hn::Add(hn::Mul(channel, lit), shine));
  };
  add(color, sums.red);
  add(hn::ShiftRight<8>(color), sums.green);
  add(hn::ShiftRight<16>(color), sums.blue);
  sums.gathered = hn::Add(sums.gathered, weight);
}

/// Samples of rays.
struct PacketSamples {
  Reals k;
  Reals value;
  Wholes base;  // the sample of cell 0, if the brick went as far
};

/// What is known of hits.
struct PacketHit {
  Reals k;
  Reals value;
  Wholes base;
  Reals k_before;      // a sample before; below 0: none is known
  Reals value_before;
  Reals k_taken;       // the sample that was taken last
  Reals value_taken;

  HWY_INLINE void begin() {
    k = value = value_before = value_taken = hn::Zero(kRays);
    base = hn::Zero(kWhole);
    k_before = k_taken = real(-1);
  }

  /// inside  those of some lanes that are hits
  HWY_INLINE void add(RayMask lanes, RayMask inside, const PacketSamples& samples) {
    k = hn::IfThenElse(inside, samples.k, k);
    value = hn::IfThenElse(inside, samples.value, value);
    base = hn::IfThenElse(of_wholes(inside), samples.base, base);
    k_before = hn::IfThenElse(inside, k_taken, k_before);
    value_before = hn::IfThenElse(inside, value_taken, value_before);
    k_taken = hn::IfThenElse(lanes, samples.k, k_taken);
    value_taken = hn::IfThenElse(lanes, samples.value, value_taken);
  }
};

/// Samples that lie inside a surface, with the ones before them outside.
template <bool kIsWide, bool kHasCuts>
class PacketHits {
 public:
  /// lanes  with a hit; others look at a sample that is there
  HWY_INLINE PacketHits(const RayFrame& frame, const PacketLines& lines, RayMask lanes,
                        const PacketHit& hit)
      : f_(frame),
        lines_(lines),
        lanes_(lanes),
        hit_(hit),
        k_(hn::IfThenElseZero(lanes, hit.k)) {
    Reals place[3];
    lines.place_at(k_, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Wholes cell =
          clamped(floor_of(place[axis]), whole(-1), whole(frame.bricks.size[axis] - 1));
      cell_[axis] = hn::IfThenElseZero(of_wholes(lanes), cell);
    }
    at_ = hn::IfThenElse(of_wholes(lanes), sample_at(frame.bricks, hit.base, cell_),
                         whole(inner_sample(frame.bricks)));
  }

  /// Finds the places between, and what is seen there.
  HWY_INLINE void light(PacketSums& sums) const {
    const Reals k_before = hn::Sub(hn::Ceil(k_), real(1));
    // What other lanes would look at lies nowhere: they look where they are.
    const Reals outside = hn::IfThenElse(lanes_, hn::Max(k_before, lines_.enter), k_);
    RayMask is_cut = hn::And(lanes_, hn::Gt(lines_.enter, k_before));
    if (!hn::AllFalse(kRays, is_cut)) is_cut = hn::And(is_cut, is_inside(outside));
    const Reals found =
        f_.bricks.looks != nullptr ? halved(outside, k_) : narrowed(outside, k_);
    const Reals inside = hn::IfThenElse(is_cut, outside, found);
    const Corners corner = near_corners(inside, nullptr);
    Gradients gradient = gradient_at(BrickRows<kIsWide>{f_.bricks}, corner);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto is_axis = hn::Eq(lines_.enter_axis, whole(static_cast<std::int32_t>(axis)));
      const Reals face = hn::IfThenElseZero(of_reals(is_axis), real(kCutGradient));
      gradient.along[axis] = hn::IfThenElse(is_cut, face, gradient.along[axis]);
    }
    const PacketLight light = light_on(f_, gradient, shade_around(f_, lines_, inside));
    sums.red = hn::IfThenElse(lanes_, light.light, sums.red);
    sums.green = hn::IfThenElse(lanes_, light.highlight, sums.green);
    sums.blue = hn::IfThenElse(lanes_, inside, sums.blue);
    Reals shown = real(1);
    if (f_.bricks.looks != nullptr) {
      const Wholes looks =
          inner_looks_at(f_, BrickRows<kIsWide>{f_.bricks}, near_corners(inside, cuts()));
      shown = hn::Add(shown, hn::ConvertTo(kRays, looks));
    }
    sums.gathered = hn::IfThenElse(lanes_, shown, sums.gathered);
  }

 private:
  HWY_INLINE const RayCuts* cuts() const { return kHasCuts ? f_.cuts : nullptr; }

  /// The corners of places that lie less than a step from hits.
  /// cuts  of values; none: of gradients
  HWY_INLINE Corners near_corners(Reals k, const RayCuts* cuts) const {
    Corners moved;
    Reals place[3];
    Wholes at[3];
    Wholes by[3];
    lines_.place_at(k, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Wholes cell = cell_[axis];
      at[axis] = clamped(floor_of(place[axis]), hn::Sub(cell, whole(1)), hn::Add(cell, whole(1)));
      by[axis] = hn::Sub(at[axis], cell);
    }
    keep_places(cuts, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      moved.share[axis] = hn::Sub(place[axis], hn::ConvertTo(kRays, at[axis]));
    }
    moved.at = sample_at(f_.bricks, at_, by);
    return moved;
  }

  HWY_INLINE Reals value_of(const Corners& corners) const {
    return hn::Mul(value_at(BrickRows<kIsWide>{f_.bricks}, corners), real(f_.sign));
  }

  /// How far values are above the isovalue.
  HWY_INLINE Reals excess_at(Reals k) const {
    return hn::Sub(value_of(near_corners(k, cuts())), real(f_.isovalue));
  }

  /// The same before hits, where it is mostly known.
  HWY_INLINE Reals excess_outside(Reals k) const {
    RayMask is_known = hn::Eq(hit_.k_before, k);
    Reals place[3];
    lines_.place_at(k, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Not where roundings make it two cells.
      const Wholes by = hn::Sub(floor_of(place[axis]), cell_[axis]);
      is_known = hn::And(is_known, of_reals(hn::Lt(hn::Abs(by), whole(2))));
    }
    if (hn::AllTrue(kRays, hn::Or(is_known, hn::Not(lanes_)))) {
      return hn::Sub(hit_.value_before, real(f_.isovalue));
    }
    return excess_at(k);
  }

  HWY_INLINE RayMask is_inside(Reals k) const {
    const Corners corner = near_corners(k, cuts());
    return seen_of(f_, hn::Ge(value_of(corner), real(f_.isovalue)), corner);
  }

  /// Where voxels end that are seen, values say nothing.
  HWY_INLINE Reals halved(Reals outside, Reals inside) const {
    for (int i = 0; i < kHitHalvings; ++i) {
      const Reals middle = hn::Mul(hn::Add(outside, inside), real(0.5f));
      const RayMask is_in = is_inside(middle);
      inside = hn::IfThenElse(is_in, middle, inside);
      outside = hn::IfThenElse(is_in, outside, middle);
    }
    return inside;
  }

  /// The place between the sample outside and that of the hit where values reach the isovalue, by
  /// straight lines between values; an end that stays counts half (Illinois).
  HWY_INLINE Reals narrowed(Reals outside, Reals inside) const {
    Reals below = hn::Min(excess_outside(outside), real(-kSmallestExcess));
    Reals above = hn::Max(hn::Sub(hit_.value, real(f_.isovalue)), hn::Zero(kRays));
    const auto crossing = [&]() HWY_ATTR {
      const Reals share = hn::Div(below, hn::Sub(below, above));
      return hn::Add(outside, hn::Mul(hn::Sub(inside, outside), share));
    };
    RayMask was_in = hn::FirstN(kRays, 0);
    RayMask was_out = was_in;
    for (int i = 0; i < kHitLines; ++i) {
      const Reals middle = crossing();
      const Reals excess = excess_at(middle);
      const RayMask is_in = hn::Ge(excess, hn::Zero(kRays));
      const RayMask is_out = hn::Not(is_in);
      const Reals half = real(0.5f);
      below = hn::IfThenElse(hn::And(is_in, was_in), hn::Mul(below, half), below);
      above = hn::IfThenElse(hn::And(is_out, was_out), hn::Mul(above, half), above);
      inside = hn::IfThenElse(is_in, middle, inside);
      above = hn::IfThenElse(is_in, excess, above);
      outside = hn::IfThenElse(is_in, outside, middle);
      below = hn::IfThenElse(is_in, below, excess);
      was_in = is_in;
      was_out = is_out;
    }
    return crossing();
  }

  const RayFrame& f_;
  const PacketLines& lines_;
  RayMask lanes_;
  const PacketHit& hit_;
  Reals k_;
  Wholes cell_[3];
  Wholes at_;
};

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#endif
