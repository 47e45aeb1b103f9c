// Where all rays of a packet run together: the cubes around them, and the brick that they are in.

#if defined(OCTAVO_RENDER_RAYS_RAY_COURSE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_RENDER_RAYS_RAY_COURSE_INL_H_
#undef OCTAVO_RENDER_RAYS_RAY_COURSE_INL_H_
#else
#define OCTAVO_RENDER_RAYS_RAY_COURSE_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "octavo/render/rays/ray_block-inl.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_lanes-inl.h"
#include "octavo/render/rays/ray_lines-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

/// Values along the three axes.
constexpr hn::CappedTag<float, 4> kAxes{};

/// Between what the places of all rays of a packet lie, along each axis.
struct PacketBounds {
  using Axes = std::array<float, 4>;

  alignas(16) Axes origin_low{};
  alignas(16) Axes origin_high{};
  alignas(16) Axes step_low{};
  alignas(16) Axes step_high{};
  alignas(16) Axes last_cell{};
  Axes inverse_low{};  // 1 / step
  Axes inverse_high{};

  float low(std::size_t axis, float k) const { return origin_low[axis] + k * step_low[axis]; }
  float high(std::size_t axis, float k) const { return origin_high[axis] + k * step_high[axis]; }
};

HWY_INLINE PacketBounds bounds_of(const RayFrame& f, const PacketLines& lines) {
  PacketBounds bounds;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bounds.origin_low[axis] = lowest_of(lines.origin[axis]);
    bounds.origin_high[axis] = highest_of(lines.origin[axis]);
    bounds.step_low[axis] = lowest_of(lines.step[axis]);
    bounds.step_high[axis] = highest_of(lines.step[axis]);
    bounds.inverse_low[axis] = 1 / bounds.step_low[axis];
    bounds.inverse_high[axis] = 1 / bounds.step_high[axis];
    bounds.last_cell[axis] = static_cast<float>(f.bricks.size[axis] - 1);
  }
  return bounds;
}

/// How far values between whole numbers are rounded beyond them.
constexpr float kRangeMargin = 1 / 16.0f;

/// Steps that rays take together until they look again where they are.
constexpr int kStride = 2;

/// Cells from low to high, of all rays within a stride.
struct PacketCells {
  alignas(16) std::array<std::int32_t, 4> low;
  alignas(16) std::array<std::int32_t, 4> high;
};

/// The brick that all rays are in or next to.
struct CommonBrick {
  std::array<std::int32_t, 3> begin{};
  std::int32_t number = -1;
  std::int32_t slot = -1;
  std::int64_t base = 0;  // the sample of cell 0, if it went as far
};

/// What lies around all rays of a packet.
class PacketCourse {
 public:
  PacketCourse() = default;
  /// is_of_surfaces  what lies behind a cell is looked at as well
  HWY_INLINE PacketCourse(const RayFrame& frame, const PacketLines& lines, bool is_of_surfaces)
      : f_(&frame), bounds_(bounds_of(frame, lines)), is_of_surfaces_(is_of_surfaces) {}

  HWY_INLINE PacketCells cells_around(float k) const {
    const auto at = [&](const PacketBounds::Axes& origin, const PacketBounds::Axes& step,
                        float steps) HWY_ATTR {
      return hn::Add(hn::Load(kAxes, origin.data()),
                     hn::Mul(hn::Set(kAxes, steps), hn::Load(kAxes, step.data())));
    };
    const auto low = hn::Min(at(bounds_.origin_low, bounds_.step_low, k),
                             at(bounds_.origin_low, bounds_.step_low, k + kStride));
    const auto high = hn::Max(at(bounds_.origin_high, bounds_.step_high, k),
                              at(bounds_.origin_high, bounds_.step_high, k + kStride));
    const auto last = hn::Load(kAxes, bounds_.last_cell.data());
    const auto cell = [&](auto place) HWY_ATTR {
      const auto inside = hn::Min(hn::Max(place, hn::Zero(kAxes)), last);
      return hn::ConvertTo(hn::RebindToSigned<decltype(kAxes)>{}, inside);
    };
    PacketCells cells;
    hn::Store(cell(low), hn::RebindToSigned<decltype(kAxes)>{}, cells.low.data());
    hn::Store(cell(high), hn::RebindToSigned<decltype(kAxes)>{}, cells.high.data());
    return cells;
  }

  HWY_INLINE std::int32_t brick_of(const std::array<std::int32_t, 3>& place) const {
    return (place[2] * f_->bricks.grid[1] + place[1]) * f_->bricks.grid[0] + place[0];
  }

  /// What may be skipped around cells: 0 where anything may be found in the cubes around them, or
  /// the shift of the sides of empty cubes or groups.
  /// has_cubes  cubes are looked at, not groups alone
  HWY_INLINE int empty_shift(const PacketCells& cells, float held, bool has_cubes) const {
    if (!is_any_above(cells, f_->bricks.group_bounds, kGroupShift, held)) return kGroupShift;
    if (!has_cubes || is_any_above(cells, f_->bricks.cube_bounds, kSkipShift, held)) return 0;
    return kSkipShift;
  }

  /// Whether a bound around cells is above what rays hold.
  /// bounds  by slot and part; the sides of parts are 1 << shift
  HWY_INLINE bool is_any_above(const PacketCells& cells, const float* bounds, int shift,
                               float held) const {
    const int bits = f_->bricks.shift - shift;
    PacketCells parts;
    PacketCells bricks;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      parts.low[axis] = cells.low[axis] >> shift;
      parts.high[axis] = cells.high[axis] >> shift;
      bricks.low[axis] = parts.low[axis] >> bits;
      bricks.high[axis] = parts.high[axis] >> bits;
    }
    for (std::int32_t z = bricks.low[2]; z <= bricks.high[2]; ++z) {
      for (std::int32_t y = bricks.low[1]; y <= bricks.high[1]; ++y) {
        for (std::int32_t x = bricks.low[0]; x <= bricks.high[0]; ++x) {
          if (is_above_in({x, y, z}, parts, bounds, bits, held)) return true;
        }
      }
    }
    return false;
  }

  /// The same of one brick, which has 1 << bits parts along a side.
  HWY_INLINE bool is_above_in(const std::array<std::int32_t, 3>& place, const PacketCells& parts,
                              const float* bounds, int bits, float held) const {
    const BrickTables& b = f_->bricks;
    const std::int32_t number = brick_of(place);
    if (!(b.brick_bounds[number] > held)) return false;
    const std::int32_t slot = b.slots[number];
    if (slot < 0) return true;
    std::array<std::int32_t, 3> low;
    std::array<std::int32_t, 3> high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int32_t begin = place[axis] << bits;
      low[axis] = std::max(parts.low[axis] - begin, 0);
      high[axis] = std::min(parts.high[axis] - begin, (1 << bits) - 1);
    }
    const float* const first = bounds + (std::int64_t{slot} << 3 * bits);
    for (std::int32_t z = low[2]; z <= high[2]; ++z) {
      for (std::int32_t y = low[1]; y <= high[1]; ++y) {
        const float* const row = first + (((z << bits) + y) << bits);
        for (std::int32_t x = low[0]; x <= high[0]; ++x) {
          if (row[x] > held) return true;
        }
      }
    }
    return false;
  }

  /// The last step at which all rays are still in the cubes or groups around cells.
  HWY_INLINE float last_within(const PacketCells& cells, int shift) const {
    const std::int32_t side = 1 << shift;
    float last = kRayDone;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int32_t begin = cells.low[axis] & ~(side - 1);
      const std::int32_t end = (cells.high[axis] & ~(side - 1)) + side;
      // Beyond the volume there is nothing.
      if (bounds_.step_high[axis] > 0 && end < f_->bricks.size[axis]) {
        const float face = static_cast<float>(end) - f_->margin;
        last = std::min(last, (face - bounds_.origin_high[axis]) * bounds_.inverse_high[axis]);
      }
      if (bounds_.step_low[axis] < 0 && begin > 0) {
        const float face = static_cast<float>(begin) + f_->margin;
        last = std::min(last, (face - bounds_.origin_low[axis]) * bounds_.inverse_low[axis]);
      }
    }
    return std::floor(last);
  }

  /// False where the rays are in different bricks, or in none in memory.
  HWY_INLINE bool enter_common(const PacketCells& cells, CommonBrick& brick) const {
    const BrickTables& b = f_->bricks;
    std::array<std::int32_t, 3> place;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = (cells.low[axis] + cells.high[axis]) >> (b.shift + 1);
      const std::int32_t begin = place[axis] << b.shift;
      // A brick holds what surrounds cells next to it, of surfaces those that lie behind.
      const std::int32_t below = is_of_surfaces_ && bounds_.step_high[axis] > 0 ? 0 : 1;
      const std::int32_t above = is_of_surfaces_ && bounds_.step_low[axis] < 0 ? 0 : 1;
      const std::int32_t end = begin + (1 << b.shift);
      if (cells.low[axis] < begin - below || cells.high[axis] >= end + above) return false;
      brick.begin[axis] = begin;
    }
    const std::int32_t number = brick_of(place);
    if (number == brick.number) return brick.slot >= 0;
    brick.number = number;
    brick.slot = b.slots[number];
    if (brick.slot < 0) return false;
    mark_used(b, brick.slot);
    brick.base = std::int64_t{brick.slot} * b.slot + inner_sample(b) -
                 (std::int64_t{brick.begin[2]} * b.plane + std::int64_t{brick.begin[1]} * b.row +
                  brick.begin[0]);
    return true;
  }

  /// The lowest and the highest of the samples around cells of a brick, as far as values between
  /// them go. False where they are too many.
  HWY_INLINE bool find_range(const CommonBrick& brick, const PacketCells& cells, float& lowest,
                             float& highest) const {
    constexpr hn::CappedTag<std::int16_t, 8> kRow{};
    const auto count = [&](std::size_t axis) HWY_ATTR {
      return cells.high[axis] - cells.low[axis] + 2;
    };
    if (count(0) > static_cast<std::int32_t>(hn::Lanes(kRow))) return false;
    const auto* const samples = static_cast<const std::int16_t*>(f_->bricks.samples) +
                                block_begin(brick, {cells.low[0], cells.low[1], cells.low[2]});
    auto low = hn::LoadU(kRow, samples);
    auto high = low;
    for (std::int32_t z = 0; z < count(2); ++z) {
      const std::int16_t* row = samples + std::int64_t{z} * f_->bricks.plane;
      for (std::int32_t y = 0; y < count(1); ++y, row += f_->bricks.row) {
        const auto values = hn::LoadU(kRow, row);
        low = hn::Min(low, values);
        high = hn::Max(high, values);
      }
    }
    // What lies beyond the row counts as its first.
    const auto in_row = hn::FirstN(kRow, static_cast<std::size_t>(count(0)));
    low = hn::IfThenElse(in_row, low, hn::Set(kRow, hn::GetLane(low)));
    high = hn::IfThenElse(in_row, high, hn::Set(kRow, hn::GetLane(high)));
    lowest = static_cast<float>(hn::GetLane(hn::MinOfLanes(kRow, low))) - kRangeMargin;
    highest = static_cast<float>(hn::GetLane(hn::MaxOfLanes(kRow, high))) + kRangeMargin;
    return true;
  }

  /// Whether nothing is to be seen between the samples around cells of a brick; of 16-bit samples.
  template <RayMode kMode>
  HWY_INLINE bool has_nothing(const CommonBrick& brick, const PacketCells& cells) const {
    constexpr bool is_of_colors = kMode == RayMode::volume;
    if constexpr (!is_of_colors && kMode != RayMode::iso) return false;
    const std::int32_t* const seen_before = f_->table.seen_before;
    if (is_of_colors && (seen_before == nullptr || f_->bricks.looks != nullptr)) return false;
    float low = 0;
    float high = 0;
    if (!find_range(brick, cells, low, high)) return false;
    if constexpr (!is_of_colors) return std::max(low * f_->sign, high * f_->sign) < f_->isovalue;
    return seen_before[entry_of(f_->table, high) + 1] == seen_before[entry_of(f_->table, low)];
  }

  /// The first cell of a block with the samples around all rays at k; false where they lie too far
  /// from each other.
  HWY_INLINE bool find_block(const CommonBrick& brick, float k,
                             std::array<std::int32_t, 3>& low) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float first = bounds_.low(axis, k);
      const float last = bounds_.high(axis, k);
      const std::int32_t begin = brick.begin[axis];
      const std::int32_t end = begin + (1 << f_->bricks.shift);
      if (!(first >= static_cast<float>(begin - 1) && last < static_cast<float>(end + 1))) {
        return false;
      }
      low[axis] = std::min(static_cast<std::int32_t>(std::floor(first)), end - 2);
      const auto high = static_cast<std::int32_t>(std::floor(last));
      if (high - low[axis] > kBlockSide - 2) return false;
    }
    return true;
  }

  HWY_INLINE std::int64_t block_begin(const CommonBrick& brick,
                                      const std::array<std::int32_t, 3>& low) const {
    return brick.base + std::int64_t{low[2]} * f_->bricks.plane +
           std::int64_t{low[1]} * f_->bricks.row + low[0];
  }

 private:
  const RayFrame* f_ = nullptr;
  PacketBounds bounds_;
  bool is_of_surfaces_ = false;
};

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#endif
