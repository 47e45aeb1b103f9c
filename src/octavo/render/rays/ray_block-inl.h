// A few samples that rays side by side look at together: each lane picks its own out of registers.
//
//     4 x 4 x 4 samples of 16 bits  ->  two vectors  ->  the pair of any lane by one instruction
//
// Where there is no such instruction lanes look samples up one by one.

#if defined(OCTAVO_RENDER_RAYS_RAY_BLOCK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_RENDER_RAYS_RAY_BLOCK_INL_H_
#undef OCTAVO_RENDER_RAYS_RAY_BLOCK_INL_H_
#else
#define OCTAVO_RENDER_RAYS_RAY_BLOCK_INL_H_
#endif

#include <hwy/highway.h>

#include <array>

#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_lanes-inl.h"
#include "octavo/render/rays/ray_lines-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

/// Samples of a block along each axis.
constexpr std::int32_t kBlockSide = 4;
/// The first cell of one.
using BlockCell = std::array<std::int32_t, 3>;

#undef OCTAVO_HAS_SAMPLE_BLOCKS
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
#define OCTAVO_HAS_SAMPLE_BLOCKS 1

constexpr hn::Repartition<std::int16_t, decltype(kWhole)> kShorts{};
using Shorts = hn::Vec<decltype(kShorts)>;

struct BlockRows {
  Shorts low;   // the two planes before
  Shorts high;

  std::int32_t row() const { return kBlockSide; }
  std::int32_t plane() const { return kBlockSide * kBlockSide; }

  HWY_INLINE SamplePair pair(Wholes at) const {
    const Wholes both = hn::Add(hn::Or(at, hn::ShiftLeft<16>(at)), whole(1 << 16));
    return pair_of(Wholes{_mm512_permutex2var_epi16(low.raw, both.raw, high.raw)});
  }
};

HWY_INLINE Shorts two_planes(const BrickTables& b, std::int64_t at) {
  constexpr hn::CappedTag<std::int16_t, kBlockSide> kRow{};
  constexpr hn::Twice<decltype(kRow)> kTwo{};
  constexpr hn::Twice<decltype(kTwo)> kPlane{};
  const std::int16_t* const samples = static_cast<const std::int16_t*>(b.samples) + at;
  const auto two_rows = [&](std::int64_t by) HWY_ATTR {
    return hn::Combine(kTwo, hn::LoadU(kRow, samples + by + b.row),
                       hn::LoadU(kRow, samples + by));
  };
  const auto plane = [&](std::int64_t by) HWY_ATTR {
    return hn::Combine(kPlane, two_rows(by + 2 * std::int64_t{b.row}), two_rows(by));
  };
  return hn::Combine(kShorts, plane(b.plane), plane(0));
}

/// The block whose first sample is the one `at`.
HWY_INLINE BlockRows block_at(const BrickTables& b, std::int64_t at) {
  return {two_planes(b, at), two_planes(b, at + 2 * std::int64_t{b.plane})};
}

/// Differences over two samples of the same block; they must fit into 16 bits.
HWY_INLINE BlockRows differences_at(const BrickTables& b, std::int64_t at, std::int64_t stride) {
  const BlockRows after = block_at(b, at + stride);
  const BlockRows before = block_at(b, at - stride);
  return {hn::Sub(after.low, before.low), hn::Sub(after.high, before.high)};
}

/// What stands around the places of rays at k, in the block whose first cell is `low`.
/// cuts  of values; none: of gradients
HWY_INLINE Corners block_corners(const PacketLines& lines, const RayCuts* cuts, float k,
                                 const BlockCell& low) {
  Corners corners;
  Reals place[3];
  Wholes by[3];
  lines.place_at(real(k), place);
  Reals floor[3];
  for (std::size_t axis = 0; axis < 3; ++axis) floor[axis] = hn::Floor(place[axis]);
  keep_places(cuts, place);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    corners.share[axis] = hn::Sub(place[axis], floor[axis]);
    by[axis] = hn::ConvertTo(kWhole, floor[axis]);
  }
  static_assert(kBlockSide == 1 << 2);
  const Wholes at = hn::Add(hn::Add(by[0], hn::ShiftLeft<2>(by[1])), hn::ShiftLeft<4>(by[2]));
  corners.at = hn::Sub(at, whole(low[0] + 4 * low[1] + 16 * low[2]));
  return corners;
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#endif
