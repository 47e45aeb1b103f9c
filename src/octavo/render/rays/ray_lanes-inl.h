// What rays side by side look at, in the lanes of vectors: values, gradients, light, entries of
// tables.

#if defined(OCTAVO_RENDER_RAYS_RAY_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_RENDER_RAYS_RAY_LANES_INL_H_
#undef OCTAVO_RENDER_RAYS_RAY_LANES_INL_H_
#else
#define OCTAVO_RENDER_RAYS_RAY_LANES_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "octavo/render/rays/mesh_shadow.h"
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
HWY_INLINE float lowest_of(Reals value) { return hn::GetLane(hn::MinOfLanes(kRays, value)); }
HWY_INLINE float highest_of(Reals value) { return hn::GetLane(hn::MaxOfLanes(kRays, value)); }
HWY_INLINE Wholes clamped(Wholes value, Wholes low, Wholes high) {
  return hn::Min(hn::Max(value, low), high);
}

/// Two samples in a row.
struct SamplePair {
  Reals first;
  Reals second;
};

HWY_INLINE SamplePair pair_of(Wholes both) {
  return {hn::ConvertTo(kRays, hn::ShiftRight<16>(hn::ShiftLeft<16>(both))),
          hn::ConvertTo(kRays, hn::ShiftRight<16>(both))};
}

HWY_INLINE SamplePair difference(const SamplePair& a, const SamplePair& b) {
  return {hn::Sub(a.first, b.first), hn::Sub(a.second, b.second)};
}

/// The samples of bricks, looked up one by one.
template <bool kIsWide>
struct BrickRows {
  const BrickTables& bricks;

  std::int32_t row() const { return bricks.row; }
  std::int32_t plane() const { return bricks.plane; }

  HWY_INLINE SamplePair pair(Wholes at) const {
    if constexpr (kIsWide) {
      const auto* const samples = static_cast<const float*>(bricks.samples);
      return {hn::GatherIndex(kRays, samples, at),
              hn::GatherIndex(kRays, samples, hn::Add(at, whole(1)))};
    } else {
      return pair_of(hn::GatherOffset(kWhole, static_cast<const std::int32_t*>(bricks.samples),
                                      hn::ShiftLeft<1>(at)));
    }
  }
};

/// What stands around places: the sample before each along each axis, and the shares of the next.
struct Corners {
  Wholes at;
  Reals share[3];
};

template <class Rows>
HWY_INLINE Reals value_at(const Rows& rows, const Corners& c) {
  const auto row = [&](std::int32_t by) HWY_ATTR {
    const SamplePair pair = rows.pair(hn::Add(c.at, whole(by)));
    return mixed(pair.first, pair.second, c.share[0]);
  };
  const Reals near = mixed(row(0), row(rows.row()), c.share[1]);
  const Reals far = mixed(row(rows.plane()), row(rows.plane() + rows.row()), c.share[1]);
  return mixed(near, far, c.share[2]);
}

/// The looks of the voxels nearest to places.
HWY_INLINE Wholes looks_at(const BrickTables& b, const Corners& c) {
  const auto by = [&](std::size_t axis, std::int32_t stride) HWY_ATTR {
    return hn::IfThenElseZero(of_wholes(hn::Ge(c.share[axis], real(0.5f))), whole(stride));
  };
  const Wholes at = hn::Add(hn::Add(c.at, by(0, 1)), hn::Add(by(1, b.row), by(2, b.plane)));
  const Wholes both = hn::GatherOffset(kWhole, reinterpret_cast<const std::int32_t*>(b.looks),
                                       hn::ShiftLeft<1>(at));
  return hn::And(both, whole(0xffff));
}

/// Lanes at whose places a voxel is seen.
HWY_INLINE RayMask seen_of(const RayFrame& f, RayMask lanes, const Corners& corner) {
  if (f.bricks.looks == nullptr) return lanes;
  const Wholes begins = hn::GatherIndex(kWhole, f.looks.begins, looks_at(f.bricks, corner));
  return hn::And(lanes, of_reals(hn::Gt(begins, whole(-1))));
}

/// Of the samples around hits that lie inside the surface and are seen, the looks of those that
/// count most there.
template <class Rows>
HWY_INLINE Wholes inner_looks_at(const RayFrame& f, const Rows& rows, const Corners& c) {
  const BrickTables& b = f.bricks;
  Wholes look = looks_at(b, c);
  Reals most = hn::Zero(kRays);
  Reals before[3];
  for (std::size_t axis = 0; axis < 3; ++axis) before[axis] = hn::Sub(real(1), c.share[axis]);
  const auto take = [&](Reals value, Wholes of, Reals weight) HWY_ATTR {
    const Wholes begins = hn::GatherIndex(kWhole, f.looks.begins, of);
    RayMask is_it = hn::Ge(hn::Mul(value, real(f.sign)), real(f.isovalue));
    is_it = hn::And(is_it, of_reals(hn::Gt(begins, whole(-1))));
    is_it = hn::And(is_it, hn::Gt(weight, most));
    most = hn::IfThenElse(is_it, weight, most);
    look = hn::IfThenElse(of_wholes(is_it), of, look);
  };
  for (std::int32_t i = 0; i < 4; ++i) {
    const bool is_next[2] = {(i & 1) != 0, (i >> 1) != 0};
    const Wholes at =
        hn::Add(c.at, whole((is_next[0] ? b.row : 0) + (is_next[1] ? b.plane : 0)));
    const SamplePair pair = rows.pair(at);
    const Wholes both = hn::GatherOffset(kWhole, reinterpret_cast<const std::int32_t*>(b.looks),
                                         hn::ShiftLeft<1>(at));
    const Reals y = is_next[0] ? c.share[1] : before[1];
    const Reals z = is_next[1] ? c.share[2] : before[2];
    take(pair.first, hn::And(both, whole(0xffff)), hn::Mul(hn::Mul(before[0], y), z));
    take(pair.second, hn::And(hn::ShiftRight<16>(both), whole(0xffff)),
         hn::Mul(hn::Mul(c.share[0], y), z));
  }
  return look;
}

/// A sample that has neighbors on all sides.
HWY_INLINE std::int32_t inner_sample(const BrickTables& b) {
  return kApronBelow * (b.plane + b.row + 1);
}

/// The sample so many cells from `base`.
HWY_INLINE Wholes sample_at(const BrickTables& b, Wholes base, const Wholes* cell) {
  const Wholes by =
      hn::Add(hn::Mul(cell[2], whole(b.plane)), hn::Mul(cell[1], whole(b.row)));
  return hn::Add(base, hn::Add(by, cell[0]));
}

struct Gradients {
  Reals along[3];
};

/// Four samples in a row, of which the second lies at a place.
struct SampleRow {
  SamplePair low;
  SamplePair high;
};

template <bool kIsWide>
HWY_INLINE SampleRow row_at(const BrickRows<kIsWide>& rows, Wholes at) {
  const Wholes first = hn::Sub(at, whole(1));
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  // One load of 64 bits for each lane instead of two of 32.
  if constexpr (!kIsWide) {
    constexpr hn::Repartition<std::int64_t, decltype(kWhole)> kLong{};
    const auto* const samples = static_cast<const std::int64_t*>(rows.bricks.samples);
    const Wholes bytes = hn::ShiftLeft<1>(first);
    constexpr hn::Half<decltype(kWhole)> kHalf{};
    const auto lower = hn::BitCast(
        kWhole, hn::GatherOffset(kLong, samples,
                                 hn::PromoteTo(kLong, hn::LowerHalf(kHalf, bytes))));
    const auto upper = hn::BitCast(
        kWhole, hn::GatherOffset(kLong, samples,
                                 hn::PromoteTo(kLong, hn::UpperHalf(kHalf, bytes))));
    return {pair_of(hn::ConcatEven(kWhole, upper, lower)),
            pair_of(hn::ConcatOdd(kWhole, upper, lower))};
  }
#endif
  return {rows.pair(first), rows.pair(hn::Add(at, whole(1)))};
}

/// Differences over two samples, straight between samples.
template <bool kIsWide>
HWY_INLINE Gradients gradient_at(const BrickRows<kIsWide>& rows, const Corners& c) {
  const auto at = [&](std::int32_t y, std::int32_t z) HWY_ATTR {
    return hn::Add(c.at, whole(y * rows.row() + z * rows.plane()));
  };
  const auto row = [&](const SamplePair& pair) HWY_ATTR {
    return mixed(pair.first, pair.second, c.share[0]);
  };
  const auto all = [&](Reals r00, Reals r10, Reals r01, Reals r11) HWY_ATTR {
    return mixed(mixed(r00, r10, c.share[1]), mixed(r01, r11, c.share[1]), c.share[2]);
  };
  const SampleRow r00 = row_at(rows, at(0, 0));
  const SampleRow r10 = row_at(rows, at(1, 0));
  const SampleRow r01 = row_at(rows, at(0, 1));
  const SampleRow r11 = row_at(rows, at(1, 1));
  const auto along_row = [&](const SampleRow& r) HWY_ATTR {
    return row(difference(r.high, r.low));
  };
  const Reals x = all(along_row(r00), along_row(r10), along_row(r01), along_row(r11));
  const auto inner = [](const SampleRow& r) HWY_ATTR {
    return SamplePair{r.low.second, r.high.first};
  };
  const auto between = [&](const SamplePair& after, const SamplePair& before) HWY_ATTR {
    return row(difference(after, before));
  };
  const SamplePair p00 = inner(r00);
  const SamplePair p10 = inner(r10);
  const SamplePair p01 = inner(r01);
  const SamplePair p11 = inner(r11);
  const Reals y = all(between(p10, rows.pair(at(-1, 0))), between(rows.pair(at(2, 0)), p00),
                      between(p11, rows.pair(at(-1, 1))), between(rows.pair(at(2, 1)), p01));
  const Reals z = all(between(p01, rows.pair(at(0, -1))), between(p11, rows.pair(at(1, -1))),
                      between(rows.pair(at(0, 2)), p00), between(rows.pair(at(1, 2)), p10));
  return {{x, y, z}};
}

/// Differences within the cells of places, twice: a fourth of what gradient_at reads.
template <class Rows>
HWY_INLINE Gradients cell_gradient_at(const Rows& rows, const Corners& c) {
  const auto pair = [&](std::int32_t by) HWY_ATTR {
    return rows.pair(hn::Add(c.at, whole(by)));
  };
  const SamplePair r00 = pair(0);
  const SamplePair r10 = pair(rows.row());
  const SamplePair r01 = pair(rows.plane());
  const SamplePair r11 = pair(rows.plane() + rows.row());
  const auto slope = [](const SamplePair& row) HWY_ATTR {
    return hn::Sub(row.second, row.first);
  };
  const auto value = [&](const SamplePair& row) HWY_ATTR {
    return mixed(row.first, row.second, c.share[0]);
  };
  const Reals x = mixed(mixed(slope(r00), slope(r10), c.share[1]),
                        mixed(slope(r01), slope(r11), c.share[1]), c.share[2]);
  const Reals y = mixed(hn::Sub(value(r10), value(r00)), hn::Sub(value(r11), value(r01)),
                        c.share[2]);
  const Reals z = mixed(hn::Sub(value(r01), value(r00)), hn::Sub(value(r11), value(r10)),
                        c.share[1]);
  return {{hn::Add(x, x), hn::Add(y, y), hn::Add(z, z)}};
}

/// Shares of the light.
struct PacketShade {
  Reals ambient;
  Reals direct;
};

HWY_INLINE PacketShade row_shade(const ShadeTable& t, Wholes pair, Reals share) {
  const Wholes all = hn::GatherOffset(kWhole, reinterpret_cast<const std::int32_t*>(t.pairs),
                                      hn::ShiftLeft<1>(pair));
  const auto byte = [&](Wholes shifted) HWY_ATTR {
    return hn::ConvertTo(kRays, hn::And(shifted, whole(255)));
  };
  return {mixed(byte(all), byte(hn::ShiftRight<16>(all)), share),
          mixed(byte(hn::ShiftRight<8>(all)), byte(hn::ShiftRight<24>(all)), share)};
}

HWY_INLINE PacketShade mixed_shade(const PacketShade& a, const PacketShade& b, Reals share) {
  return {mixed(a.ambient, b.ambient, share), mixed(a.direct, b.direct, share)};
}

/// One lane after the other: what each finds in its cell has its own length.
HWY_NOINLINE Reals lanes_behind_meshes(const ShadeTable& t, const Reals* place, Reals direct) {
  constexpr std::size_t kMostLanes = 16;
  HWY_ALIGN float along[3][kMostLanes];
  HWY_ALIGN float left[kMostLanes];
  for (std::size_t axis = 0; axis < 3; ++axis) hn::Store(place[axis], kRays, along[axis]);
  hn::Store(direct, kRays, left);
  for (std::size_t lane = 0; lane < hn::Lanes(kRays); ++lane) {
    const float at[3] = {along[0][lane], along[1][lane], along[2][lane]};
    left[lane] = direct_behind_meshes(t, at, left[lane]);
  }
  return hn::Load(kRays, left);
}

HWY_INLINE PacketShade shade_at(const ShadeTable& t, const Reals* place) {
  if (t.pairs == nullptr) return {real(1), real(1)};
  Wholes cell[3];
  Reals share[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Reals moved =
        hn::Add(hn::Mul(place[axis], real(t.scale[axis])), real(t.offset[axis]));
    const Reals at = hn::Min(hn::Max(moved, hn::Zero(kRays)), real(t.highest[axis]));
    cell[axis] = hn::Min(hn::ConvertTo(kWhole, at), whole(t.last_cell[axis]));
    share[axis] = hn::Sub(at, hn::ConvertTo(kRays, cell[axis]));
  }
  const auto row = [&](std::int32_t y, std::int32_t z) HWY_ATTR {
    const Wholes plane = hn::Mul(hn::Add(cell[2], whole(z)), whole(t.plane));
    const Wholes line = hn::Mul(hn::Add(cell[1], whole(y)), whole(t.row));
    return row_shade(t, hn::Add(hn::Add(plane, line), cell[0]), share[0]);
  };
  const PacketShade near = mixed_shade(row(0, 0), row(1, 0), share[1]);
  const PacketShade far = mixed_shade(row(0, 1), row(1, 1), share[1]);
  const PacketShade all = mixed_shade(near, far, share[2]);
  const Reals direct = hn::Mul(all.direct, real(1 / 255.0f));
  return {hn::Mul(all.ambient, real(1 / 255.0f)),
          t.meshes != nullptr ? lanes_behind_meshes(t, place, direct) : direct};
}

struct PacketLight {
  Reals light;
  Reals highlight;
  Reals slope;  // length of the gradient
};

HWY_INLINE PacketLight light_on(const RayFrame& f, const Gradients& gradient,
                                const PacketShade& shade) {
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
      hn::Add(hn::Mul(real(light.ambient), shade.ambient),
              hn::Mul(hn::Mul(real(light.diffuse), along(light.toward_light)), shade.direct));
  Reals shine = along(light.halfway);
  for (int i = 0; i < kShineSquares; ++i) shine = hn::Mul(shine, shine);
  const Reals flat = hn::Mul(
      real(kFlatLight), hn::Add(hn::Mul(real(kFlatAmbient), shade.ambient),
                                hn::Mul(real(1 - kFlatAmbient), shade.direct)));
  const Reals shone = hn::Mul(hn::Mul(real(light.specular), shine), strength);
  return {hn::Add(flat, hn::Mul(hn::Sub(lit, flat), strength)), hn::Mul(shone, shade.direct),
          length};
}

HWY_INLINE Wholes entries_of(const ColorTable& table, Reals value) {
  Reals entry = hn::Zero(kRays);
  for (const ColorTable::Piece& piece : table.pieces) {
    const Reals of_piece =
        hn::Mul(hn::Sub(value, real(piece.begin)), real(piece.entries_per_value));
    entry = hn::Add(entry, hn::Min(hn::Max(of_piece, hn::Zero(kRays)), real(piece.entries)));
  }
  return hn::Min(hn::ConvertTo(kWhole, entry), whole(ColorTable::kSide - 1));
}

/// The opacities of parts of steps: their transmittances to the power of the lengths.
HWY_INLINE Reals opacities_of_parts(Reals opacity, Reals length) {
  constexpr int kParts = 1 << kStepParts;
  const Wholes parts = hn::ConvertTo(
      kWhole, hn::Add(hn::Mul(length, real(static_cast<float>(kParts))), real(0.5f)));
  const RayMask is_part = of_reals(hn::Lt(parts, whole(kParts)));
  if (hn::AllFalse(kRays, is_part)) return opacity;
  Reals transmittance = real(1);
  Reals root = hn::Sub(real(1), opacity);
  for (int bit = kParts >> 1; bit > 0; bit >>= 1) {
    root = hn::Sqrt(root);
    const auto is_set = hn::Ne(hn::And(parts, whole(bit)), hn::Zero(kWhole));
    transmittance =
        hn::IfThenElse(of_reals(is_set), hn::Mul(transmittance, root), transmittance);
  }
  return hn::IfThenElse(is_part, hn::Sub(real(1), transmittance), opacity);
}

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#endif
