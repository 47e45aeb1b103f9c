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
#include <bit>
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

/// Cells from low to high, of all rays within some steps.
struct PacketCells {
  alignas(16) std::array<std::int32_t, 4> low;
  alignas(16) std::array<std::int32_t, 4> high;
};

/// The brick that all rays are in or next to.
struct CommonBrick {
  // Between these places it has the samples around; blocks begin with no later cell.
  alignas(16) std::array<float, 4> first{0, 0, 0, -1};
  alignas(16) std::array<float, 4> behind{0, 0, 0, 1};
  alignas(16) std::array<std::int32_t, 4> last_block{};
  float until = -1;  // the step until which rays stay
  std::int32_t number = -1;
  std::int32_t slot = -1;
  std::int64_t base = 0;  // the sample of cell 0, if it went as far
};

/// Steps in which anything may be seen, a bit each.
struct StepBits {
  float begin = 0;
  float end = -1;
  std::uint64_t occupied = 0;
};

/// What lies around all rays of a packet.
class PacketCourse {
 public:
  PacketCourse() = default;
  /// is_of_surfaces  what lies behind a cell is looked at as well
  HWY_INLINE PacketCourse(const RayFrame& frame, const PacketLines& lines, bool is_of_surfaces)
      : f_(&frame), bounds_(bounds_of(frame, lines)), is_of_surfaces_(is_of_surfaces) {}

  HWY_INLINE PacketCells cells_around(float k, float steps) const {
    const auto at = [&](const PacketBounds::Axes& origin, const PacketBounds::Axes& step,
                        float place) HWY_ATTR {
      return hn::Add(hn::Load(kAxes, origin.data()),
                     hn::Mul(hn::Set(kAxes, place), hn::Load(kAxes, step.data())));
    };
    const auto low = hn::Min(at(bounds_.origin_low, bounds_.step_low, k),
                             at(bounds_.origin_low, bounds_.step_low, k + steps));
    const auto high = hn::Max(at(bounds_.origin_high, bounds_.step_high, k),
                              at(bounds_.origin_high, bounds_.step_high, k + steps));
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

  /// Where anything may be seen from k on. `steps` are looked up where they do not go so far.
  HWY_INLINE float next_occupied(float k, StepBits& steps) const {
    if (!(k < steps.end)) {
      steps.begin = k;
      steps.end = k + static_cast<float>(hn::Lanes(kRays));
      steps.occupied = occupied_steps(k);
    }
    const std::uint64_t rest = steps.occupied >> static_cast<int>(k - steps.begin);
    return rest != 0 ? k + static_cast<float>(std::countr_zero(rest)) : steps.end;
  }

  /// Where anything may be above what rays hold, in so many steps from k on.
  HWY_INLINE float next_above(float k, float steps, float held) const {
    const PacketCells cells = cells_around(k, steps);
    if (is_any_above(cells, f_->bricks.group_bounds, kGroupShift, held)) return k;
    return std::max(k + 1, last_in_groups(cells));
  }

  /// Steps from one on, as many as there are lanes: bit i is set where anything may be seen between
  /// k + i and k + i + 1.
  HWY_INLINE std::uint64_t occupied_steps(float k) const {
    const Reals from = hn::Add(real(k), hn::Iota(kRays, 0));
    const Reals to = hn::Add(from, real(1));
    Wholes low[3];
    Wholes high[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = [&](const PacketBounds::Axes& origin, const PacketBounds::Axes& step,
                          Reals place) HWY_ATTR {
        return hn::Add(real(origin[axis]), hn::Mul(place, real(step[axis])));
      };
      const auto cell = [&](Reals place) HWY_ATTR {
        return hn::ConvertTo(kWhole, hn::Min(hn::Max(place, hn::Zero(kRays)),
                                             real(bounds_.last_cell[axis])));
      };
      low[axis] = cell(hn::Min(at(bounds_.origin_low, bounds_.step_low, from),
                               at(bounds_.origin_low, bounds_.step_low, to)));
      high[axis] = cell(hn::Max(at(bounds_.origin_high, bounds_.step_high, from),
                                at(bounds_.origin_high, bounds_.step_high, to)));
    }
    Wholes found = hn::Zero(kWhole);
    for (Wholes z = low[2];;) {
      for (Wholes y = low[1];;) {
        for (Wholes x = low[0];;) {
          found = hn::Or(found, seen_from({x, high[0]}, joined_place(y, high[1]),
                                          joined_place(z, high[2])));
          if (!go_on(x, high[0], kSeenBits)) break;
        }
        if (!go_on(y, high[1], kSeenSide)) break;
      }
      if (!go_on(z, high[2], kSeenSide)) break;
    }
    std::array<std::uint8_t, 8> bytes{};
    hn::StoreMaskBits(kWhole, hn::Ne(found, hn::Zero(kWhole)), bytes.data());
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 2; ++i) bits |= std::uint64_t{bytes[i]} << 8 * i;
    return bits;
  }

  /// Cells along x that one look at bits shows, wherever in a byte they begin.
  static constexpr std::int32_t kSeenBits = 25;

  /// Moves places by so many cells, but not past the end of their brick, nor past the last one.
  /// False where all were past it.
  HWY_INLINE bool go_on(Wholes& place, Wholes last, std::int32_t by) const {
    const int shift = f_->bricks.shift;
    const Wholes brick = hn::Add(hn::ShiftRightSame(place, shift), whole(1));
    const Wholes next = hn::Min(hn::Add(place, whole(by)), hn::ShiftLeftSame(brick, shift));
    if (hn::AllTrue(kWhole, hn::Gt(next, last))) return false;
    place = hn::Min(next, last);
    return true;
  }

  /// Where to look for a cell and the next one, if that is not past the last: one before where it
  /// is the last, in the same brick.
  HWY_INLINE Wholes joined_place(Wholes place, Wholes last) const {
    const Wholes begin = hn::And(place, whole(-1 << f_->bricks.shift));
    return hn::Max(begin, hn::Min(place, hn::Sub(last, whole(kSeenSide - 1))));
  }

  /// Cells along x.
  struct CellRuns {
    Wholes first;
    Wholes last;
  };

  /// Not 0 where anything may be seen in runs of cells and those next to them along y and z, as far
  /// as they lie in one brick.
  HWY_INLINE Wholes seen_from(const CellRuns& x, Wholes y, Wholes z) const {
    const BrickTables& b = f_->bricks;
    const Wholes most = whole((1 << b.shift) - 1);
    const auto brick = [&](Wholes place) HWY_ATTR { return hn::ShiftRightSame(place, b.shift); };
    const Wholes row = hn::Add(hn::Mul(brick(z), whole(b.grid[1])), brick(y));
    const Wholes number = hn::Add(hn::Mul(row, whole(b.grid[0])), brick(x.first));
    // Mostly they are in one brick.
    const std::int32_t one = hn::GetLane(number);
    const Wholes begin = hn::AllTrue(kWhole, hn::Eq(number, whole(one)))
                             ? whole(b.seen_begins[one])
                             : hn::GatherIndex(kWhole, b.seen_begins, number);
    const Wholes plane = hn::Or(hn::ShiftLeftSame(hn::And(z, most), b.shift), hn::And(y, most));
    const Wholes bit = hn::Or(hn::ShiftLeftSame(plane, b.shift), hn::And(x.first, most));
    const auto is_whole = hn::Lt(begin, hn::Zero(kWhole));
    const Wholes at = hn::IfThenZeroElse(is_whole, hn::Add(begin, hn::ShiftRight<3>(bit)));
    const Wholes bits = hn::GatherOffset(
        kWhole, reinterpret_cast<const std::int32_t*>(b.seen_cells), at);
    const Wholes last = hn::Min(x.last, hn::Or(x.first, most));
    const Wholes run = hn::Min(hn::Sub(last, x.first), whole(kSeenBits - 1));
    const Wholes mask = hn::Sub(hn::Shl(whole(2), run), whole(1));
    static_assert(kNothingSeen + 1 == 0 && kAnythingSeen + 1 == -1);
    const Wholes seen = hn::And(hn::Shr(bits, hn::And(bit, whole(7))), mask);
    return hn::IfThenElse(is_whole, hn::Add(begin, whole(1)), seen);
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

  /// The last step at which all rays are still in the groups around cells.
  HWY_INLINE float last_in_groups(const PacketCells& cells) const {
    PacketCells box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = cells.low[axis] & ~(kGroupSide - 1);
      box.high[axis] = (cells.high[axis] & ~(kGroupSide - 1)) + kGroupSide;
    }
    return last_between(box);
  }

  /// The last step at which all rays are still in a box; the end does not belong to it.
  HWY_INLINE float last_between(const PacketCells& box) const {
    float last = kRayDone;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Beyond the volume there is nothing.
      if (bounds_.step_high[axis] > 0 && box.high[axis] < f_->bricks.size[axis]) {
        const float face = static_cast<float>(box.high[axis]) - f_->margin;
        last = std::min(last, (face - bounds_.origin_high[axis]) * bounds_.inverse_high[axis]);
      }
      if (bounds_.step_low[axis] < 0 && box.low[axis] > 0) {
        const float face = static_cast<float>(box.low[axis]) + f_->margin;
        last = std::min(last, (face - bounds_.origin_low[axis]) * bounds_.inverse_low[axis]);
      }
    }
    return std::floor(last);
  }

  /// False where the rays are in different bricks, or in none in memory.
  HWY_INLINE bool enter_common(const PacketCells& cells, CommonBrick& brick) const {
    const BrickTables& b = f_->bricks;
    std::array<std::int32_t, 3> place;
    std::array<std::int32_t, 3> begins;
    PacketCells box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = (cells.low[axis] + cells.high[axis]) >> (b.shift + 1);
      const std::int32_t begin = place[axis] << b.shift;
      // A brick holds what surrounds cells next to it, of surfaces those that lie behind.
      const std::int32_t below = is_of_surfaces_ && bounds_.step_high[axis] > 0 ? 0 : 1;
      const std::int32_t above = is_of_surfaces_ && bounds_.step_low[axis] < 0 ? 0 : 1;
      const std::int32_t end = begin + (1 << b.shift);
      if (cells.low[axis] < begin - below || cells.high[axis] >= end + above) return false;
      begins[axis] = begin;
      box.low[axis] = begin - below;
      box.high[axis] = end + above;
    }
    const std::int32_t number = brick_of(place);
    if (number == brick.number) return brick.slot >= 0;
    brick.number = number;
    brick.until = -1;
    brick.slot = b.slots[number];
    if (brick.slot < 0) return false;
    mark_used(b, brick.slot);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int32_t end = begins[axis] + (1 << b.shift);
      brick.first[axis] = static_cast<float>(begins[axis] - 1);
      brick.behind[axis] = static_cast<float>(end + 1);
      brick.last_block[axis] = end - 2;
    }
    brick.until = last_between(box);
    brick.base = std::int64_t{brick.slot} * b.slot + inner_sample(b) -
                 (std::int64_t{begins[2]} * b.plane + std::int64_t{begins[1]} * b.row + begins[0]);
    return true;
  }

  /// The first cell of a block with the samples around all rays at k; false where they lie too far
  /// from each other.
  HWY_INLINE bool find_block(const CommonBrick& brick, float k, BlockCell& low) const {
    constexpr hn::RebindToSigned<decltype(kAxes)> kCells{};
    const auto at = [&](const PacketBounds::Axes& origin, const PacketBounds::Axes& step) HWY_ATTR {
      return hn::Add(hn::Load(kAxes, origin.data()),
                     hn::Mul(hn::Set(kAxes, k), hn::Load(kAxes, step.data())));
    };
    const auto first = at(bounds_.origin_low, bounds_.step_low);
    const auto last = at(bounds_.origin_high, bounds_.step_high);
    const auto cell = hn::Min(hn::ConvertTo(kCells, hn::Floor(first)),
                              hn::Load(kCells, brick.last_block.data()));
    const auto high = hn::ConvertTo(kCells, hn::Floor(last));
    for (std::size_t axis = 0; axis < 3; ++axis) low[axis] = hn::ExtractLane(cell, axis);
    const auto in_brick = hn::And(hn::Ge(first, hn::Load(kAxes, brick.first.data())),
                                  hn::Lt(last, hn::Load(kAxes, brick.behind.data())));
    const auto in_block = hn::Lt(hn::Sub(high, cell), hn::Set(kCells, kBlockSide - 1));
    return hn::AllTrue(kAxes, hn::And(in_brick, hn::RebindMask(kAxes, in_block)));
  }

  HWY_INLINE std::int64_t block_begin(const CommonBrick& brick, const BlockCell& low) const {
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
