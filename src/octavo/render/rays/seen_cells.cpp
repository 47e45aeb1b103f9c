#include "octavo/render/rays/seen_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

#include "octavo/render/rays/ray_job.h"

namespace octavo {

namespace {

constexpr std::size_t kMostRanges = 8;  // one bit of a byte each
constexpr int kRangeSteps = 256;        // no narrower range is looked for
constexpr int kRangeHalvings = 24;      // of a step, where a range ends

/// 1 for each byte of eight that is 0.
std::uint64_t empty_bytes(std::uint64_t eight) {
  constexpr std::uint64_t kLow = 0x7f7f7f7f7f7f7f7fu;
  return ~(((eight & kLow) + kLow) | eight | kLow) >> 7;
}

/// The cells of a brick, a byte each: the ranges that hold all of the samples around them.
class CellRanges {
 public:
  template <class Pooled>
  CellRanges(const SeenBrick<Pooled>& brick, std::span<const UnseenRange> ranges)
      : shift_(brick.shift), side_(std::size_t{1} << brick.shift), cells_(side_ * side_ * side_) {
    std::vector<std::uint8_t> held(side_ + 1);
    std::vector<std::uint8_t> before(side_);  // of the row before
    std::vector<std::uint8_t> in_row(side_);
    for (std::size_t z = 0; z <= side_; ++z) {
      for (std::size_t y = 0; y <= side_; ++y) {
        const Pooled* const samples = brick.samples + static_cast<std::ptrdiff_t>(z) * brick.plane +
                                      static_cast<std::ptrdiff_t>(y) * brick.row;
        find_held(samples, ranges, held);
        for (std::size_t x = 0; x < side_; ++x) in_row[x] = held[x] & held[x + 1];
        if (y > 0) add_row(in_row, before, y - 1, z);
        std::swap(in_row, before);
      }
    }
  }

  /// Cells of cubes that are empty for other reasons are in all ranges.
  void add_empty_cubes(const float* bounds) {
    const std::size_t cubes = side_ >> kSkipShift;
    for (std::size_t z = 0; z < side_; ++z) {
      for (std::size_t y = 0; y < side_; ++y) {
        const float* const row = bounds + ((z >> kSkipShift) * cubes + (y >> kSkipShift)) * cubes;
        std::uint8_t* const cells = row_at(y, z);
        for (std::size_t x = 0; x < side_; ++x) {
          if (!(row[x >> kSkipShift] > 0)) cells[x] = 0xff;
        }
      }
    }
  }

  /// Joins each cell with the next ones along y and z.
  void join_neighbors() {
    static_assert(kSeenSide == 2);
    const std::size_t plane = side_ * side_;
    for (std::size_t z = 0; z < side_; ++z) {
      join_rows(row_at(0, z), row_at(1, z), plane - side_);
      if (z > 0) join_rows(row_at(0, z - 1), row_at(0, z), plane);
    }
  }

  /// Bits of cells that are in no range.
  void store(std::uint8_t* bytes) const {
    for (std::size_t i = 0; i < seen_bytes(shift_); ++i) {
      std::uint64_t eight;
      std::memcpy(&eight, cells_.data() + 8 * i, sizeof eight);
      bytes[i] = static_cast<std::uint8_t>(empty_bytes(eight) * 0x0102040810204080u >> 56);
    }
  }

 private:
  std::uint8_t* row_at(std::size_t y, std::size_t z) {
    return cells_.data() + (z * side_ + y) * side_;
  }

  template <class Pooled>
  static void find_held(const Pooled* samples, std::span<const UnseenRange> ranges,
                        std::vector<std::uint8_t>& held) {
    std::fill(held.begin(), held.end(), 0);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      constexpr bool is_whole = std::is_integral_v<Pooled>;
      const float from = is_whole ? std::ceil(ranges[i].first) : ranges[i].first;
      const float to = is_whole ? std::floor(ranges[i].last) : ranges[i].last;
      const auto first = static_cast<Pooled>(from);
      const auto last = static_cast<Pooled>(to);
      for (std::size_t x = 0; x < held.size(); ++x) {
        const bool is_in = samples[x] >= first && samples[x] <= last;
        held[x] = static_cast<std::uint8_t>(held[x] | (is_in ? 1u << i : 0u));
      }
    }
  }

  /// Samples of the rows y and y + 1 of a plane, which cells on both sides of it touch.
  void add_row(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b,
               std::size_t y, std::size_t z) {
    if (z < side_) {
      std::uint8_t* const cells = row_at(y, z);
      for (std::size_t x = 0; x < side_; ++x) cells[x] = a[x] & b[x];
    }
    if (z > 0) {
      std::uint8_t* const cells = row_at(y, z - 1);
      for (std::size_t x = 0; x < side_; ++x) cells[x] = cells[x] & a[x] & b[x];
    }
  }

  static void join_rows(std::uint8_t* cells, const std::uint8_t* next, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) cells[i] &= next[i];
  }

  int shift_;
  std::size_t side_;
  std::vector<std::uint8_t> cells_;
};

}  // namespace

std::vector<UnseenRange> unseen_ranges(
    const SampleRange& all, float margin,
    const std::function<bool(float lowest, float highest)>& is_seen) {
  std::vector<UnseenRange> ranges;
  const auto lowest = static_cast<float>(all.lowest);
  const auto highest = static_cast<float>(all.highest);
  if (!(lowest <= highest)) return ranges;
  const auto is_empty = [&](float a, float b) { return !is_seen(a - margin, b + margin); };
  const float step = (highest - lowest) / kRangeSteps;

  // Whole steps, side by side.
  for (int i = 0; i < kRangeSteps; ++i) {
    const float first = lowest + static_cast<float>(i) * step;
    const float last = i + 1 < kRangeSteps ? lowest + static_cast<float>(i + 1) * step : highest;
    const bool goes_on =
        !ranges.empty() && ranges.back().last == first && is_empty(ranges.back().first, last);
    if (goes_on) ranges.back().last = last;
    else if (ranges.size() < kMostRanges && is_empty(first, last)) ranges.push_back({first, last});
  }

  // As far into the steps beside them as they go.
  for (UnseenRange& range : ranges) {
    float by = step;
    for (int i = 0; i < kRangeHalvings; ++i) {
      by *= 0.5f;
      if (range.last + by <= highest && is_empty(range.first, range.last + by)) range.last += by;
      if (range.first - by >= lowest && is_empty(range.first - by, range.last)) range.first -= by;
    }
  }
  return ranges;
}

template <class Pooled>
void mark_seen_cells(const SeenBrick<Pooled>& brick, std::span<const UnseenRange> ranges,
                     std::uint8_t* bytes) {
  if (ranges.empty() && brick.cube_bounds == nullptr) {
    std::fill_n(bytes, seen_bytes(brick.shift), std::uint8_t{255});
    return;
  }
  CellRanges cells(brick, ranges);
  if (brick.cube_bounds != nullptr) cells.add_empty_cubes(brick.cube_bounds);
  cells.join_neighbors();
  cells.store(bytes);
}

template void mark_seen_cells(const SeenBrick<std::int16_t>&, std::span<const UnseenRange>,
                              std::uint8_t*);
template void mark_seen_cells(const SeenBrick<float>&, std::span<const UnseenRange>,
                              std::uint8_t*);

}  // namespace octavo
