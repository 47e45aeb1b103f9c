#include "octavo/render/rays/occupied_spans.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "octavo/core/vectors.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

constexpr int kSpanBlockSide = 4;
static_assert(kSpanBlockSide * kSpanBlockSide == kSpanRays);

/// As far as places of pixels and steps are rounded.
constexpr double kPixelRounding = 1.0 / 64;
constexpr double kStepRounding = 1.0 / 64;
/// What lies nearer to the plane of an eye, in its distances from the picture, may be anywhere.
constexpr double kNearestPlane = 1e-3;

struct SpanEnds {
  double low = 0;
  double high = 0;
};

SpanEnds ends_around(double middle, double reach) { return {middle - reach, middle + reach}; }

/// a / b for all of both; b is above 0.
SpanEnds quotient(const SpanEnds& a, const SpanEnds& b) {
  return {std::min(a.low / b.low, a.low / b.high), std::max(a.high / b.low, a.high / b.high)};
}

double farthest(const SpanEnds& ends) { return std::max(std::abs(ends.low), std::abs(ends.high)); }
double nearest(const SpanEnds& ends) {
  return ends.low <= 0 && ends.high >= 0 ? 0 : std::min(std::abs(ends.low), std::abs(ends.high));
}

/// A box in samples.
struct SpanBox {
  Point3 middle{};
  Point3 half{};
};

/// The blocks of a picture, row by row.
struct SpanBlocks {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::vector<float> first;
  std::vector<float> last;

  SpanBlocks(std::int64_t block_columns, std::int64_t block_rows)
      : columns(block_columns),
        rows(block_rows),
        first(static_cast<std::size_t>(columns * rows), kRayDone),
        last(first.size(), -1) {}
};

/// Where boxes lie in a picture.
class BoxProjector {
 public:
  BoxProjector(const RayFrame& frame, std::int64_t width, std::int64_t height)
      : width_(width), height_(height), eye_(frame.eye_pixels), step_(frame.step_pixels) {
    for (std::size_t i = 0; i < 3; ++i) origin_[i] = frame.origin[i];
    const auto column = [](const std::array<float, 3>& f) { return Point3{f[0], f[1], f[2]}; };
    const Point3 a = column(eye_ > 0 ? frame.direction_across : frame.origin_across);
    const Point3 b = column(eye_ > 0 ? frame.direction_down : frame.origin_down);
    const Point3 c = column(frame.direction);
    const double by = 1 / dot(a, cross(b, c));
    rows_ = {scaled(cross(b, c), by), scaled(cross(c, a), by), scaled(cross(a, b), by)};
  }

  void add(const SpanBox& box, SpanBlocks& blocks) const {
    const Point3 from = difference(box.middle, origin_);
    std::array<SpanEnds, 3> ends;
    for (std::size_t i = 0; i < 3; ++i) {
      double reach = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        reach += std::abs(rows_[i][axis]) * box.half[axis];
      }
      ends[i] = ends_around(dot(rows_[i], from), reach);
    }
    if (eye_ > 0 && !put_before_eye(ends)) return;
    mark(ends, blocks);
  }

 private:
  /// Makes distances before an eye places of pixels and steps. False for what lies behind it.
  bool put_before_eye(std::array<SpanEnds, 3>& ends) const {
    if (ends[2].high <= 0) return false;
    const double all = 4 * static_cast<double>(width_ + height_);
    if (ends[2].low < kNearestPlane) {
      const double steps = ends[2].high * (eye_ + all) / step_;
      ends = {{{-all, all}, {-all, all}, {0, steps}}};
      return true;
    }
    ends[0] = quotient(ends[0], ends[2]);
    ends[1] = quotient(ends[1], ends[2]);
    const double inner = std::hypot(nearest(ends[0]), nearest(ends[1]), eye_);
    const double outer = std::hypot(farthest(ends[0]), farthest(ends[1]), eye_);
    ends[2] = {ends[2].low * inner / step_, ends[2].high * outer / step_};
    return true;
  }

  /// The blocks with pixels between ends, half open.
  static std::array<std::int64_t, 2> blocks_of(const SpanEnds& ends, std::int64_t pixels) {
    const double middle = static_cast<double>(pixels) / 2 - 0.5;
    const auto most = static_cast<double>(pixels);
    const double low = std::clamp(std::ceil(ends.low + middle - kPixelRounding), 0.0, most);
    const double high = std::clamp(std::floor(ends.high + middle + kPixelRounding) + 1, 0.0, most);
    if (low >= high) return {0, 0};
    return {static_cast<std::int64_t>(low) / kSpanBlockSide,
            (static_cast<std::int64_t>(high) + kSpanBlockSide - 1) / kSpanBlockSide};
  }

  void mark(const std::array<SpanEnds, 3>& ends, SpanBlocks& blocks) const {
    const auto columns = blocks_of(ends[0], width_);
    const auto rows = blocks_of(ends[1], height_);
    // A part of a ray counts where one of its ends does.
    const auto first = static_cast<float>(std::floor(ends[2].low - kStepRounding) - 1);
    const auto last = static_cast<float>(std::ceil(ends[2].high + kStepRounding) + 1);
    for (std::int64_t y = rows[0]; y < rows[1]; ++y) {
      float* const firsts = blocks.first.data() + y * blocks.columns;
      float* const lasts = blocks.last.data() + y * blocks.columns;
      for (std::int64_t x = columns[0]; x < columns[1]; ++x) {
        firsts[x] = std::min(firsts[x], first);
        lasts[x] = std::max(lasts[x], last);
      }
    }
  }

  std::int64_t width_;
  std::int64_t height_;
  double eye_;
  double step_;
  Point3 origin_{};
  std::array<Point3, 3> rows_{};  // places in a picture by places in samples
};

/// The boxes of one brick that have something in them.
class OccupiedBoxes {
 public:
  OccupiedBoxes(const RayFrame& frame, const BoxProjector& projector, SpanBlocks& blocks)
      : frame_(frame), bricks_(frame.bricks), projector_(projector), blocks_(blocks) {}

  void add_brick(std::int32_t number) {
    if (!(bricks_.brick_bounds[number] > 0)) return;
    const std::int32_t columns = bricks_.grid[0];
    const std::int32_t rows = bricks_.grid[1];
    const std::array<std::int32_t, 3> place = {number % columns, number / columns % rows,
                                               number / (columns * rows)};
    for (std::size_t i = 0; i < 3; ++i) begin_[i] = place[i] << bricks_.shift;
    const std::int32_t slot = bricks_.slots[number];
    const int levels = bricks_.shift - kGroupShift;
    Fill fill = Fill::full;
    if (slot >= 0) {
      groups_ = bricks_.group_bounds + (std::int64_t{slot} << 3 * levels);
      fill = add({0, 0, 0}, levels);
    }
    if (fill == Fill::full) add_box({0, 0, 0}, levels);
  }

 private:
  enum class Fill { none, some, full };

  /// Adds the largest full parts of a node that is not full.
  Fill add(const std::array<std::int32_t, 3>& place, int level) {
    const int bits = bricks_.shift - kGroupShift;
    if (level == 0) {
      const std::int32_t group = (((place[2] << bits) + place[1]) << bits) + place[0];
      return groups_[group] > 0 ? Fill::full : Fill::none;
    }
    std::array<Fill, 8> parts;
    int full = 0;
    int none = 0;
    const auto part_at = [&](int octant) {
      return std::array<std::int32_t, 3>{2 * place[0] + (octant & 1),
                                         2 * place[1] + (octant >> 1 & 1),
                                         2 * place[2] + (octant >> 2)};
    };
    for (int octant = 0; octant < 8; ++octant) {
      Fill& part = parts[static_cast<std::size_t>(octant)];
      part = add(part_at(octant), level - 1);
      full += part == Fill::full ? 1 : 0;
      none += part == Fill::none ? 1 : 0;
    }
    if (none == 8) return Fill::none;
    if (full == 8) return Fill::full;
    for (int octant = 0; octant < 8; ++octant) {
      if (parts[static_cast<std::size_t>(octant)] == Fill::full) {
        add_box(part_at(octant), level - 1);
      }
    }
    return Fill::some;
  }

  void add_box(const std::array<std::int32_t, 3>& place, int level) {
    SpanBox box;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t side = kGroupSide << level;
      const std::int32_t from = begin_[i] + place[i] * side;
      const std::int32_t to = from + side;
      if (from >= bricks_.size[i]) return;
      // The outermost hold what lies beyond the volume.
      const double margin = frame_.margin;
      const double low = from == 0 ? -1.0 : from - margin;
      const double high = to >= bricks_.size[i] ? bricks_.size[i] + 1.0 : to + margin;
      box.middle[i] = (low + high) / 2;
      box.half[i] = (high - low) / 2;
    }
    projector_.add(box, blocks_);
  }

  const RayFrame& frame_;
  const BrickTables& bricks_;
  const BoxProjector& projector_;
  SpanBlocks& blocks_;
  std::array<std::int32_t, 3> begin_{};
  const float* groups_ = nullptr;
};

/// The place in a tile of one of its blocks.
std::size_t block_in_tile(std::int64_t column, std::int64_t row) {
  std::size_t place = 0;
  for (int bit = 0; bit < 3; ++bit) {
    place |= static_cast<std::size_t>(column >> bit & 1) << (2 * bit);
    place |= static_cast<std::size_t>(row >> bit & 1) << (2 * bit + 1);
  }
  return place;
}

}  // namespace

OccupiedSpans::OccupiedSpans(const RayFrame& frame, std::int64_t width, std::int64_t height)
    : spans_(static_cast<std::size_t>(tiles_along(width) * tiles_along(height)) * kTileSpans) {
  constexpr std::int64_t kBlocksAlong = kRayTileSide / kSpanBlockSide;
  const std::int64_t columns = tiles_along(width) * kBlocksAlong;
  const std::int64_t rows = tiles_along(height) * kBlocksAlong;
  const BoxProjector projector(frame, width, height);
  PerThread<SpanBlocks> of_threads([&] { return SpanBlocks(columns, rows); });
  const std::array<std::int32_t, 3>& grid = frame.bricks.grid;
  parallel_for(std::int32_t{0}, grid[0] * grid[1] * grid[2], [&](std::int32_t number) {
    OccupiedBoxes(frame, projector, of_threads.local()).add_brick(number);
  });
  for (const SpanBlocks& blocks : of_threads) {
    for (std::int64_t y = 0; y < rows; ++y) {
      for (std::int64_t x = 0; x < columns; ++x) {
        const std::int64_t tile = y / kBlocksAlong * tiles_along(width) + x / kBlocksAlong;
        OccupiedSpan& span =
            spans_[static_cast<std::size_t>(tile) * kTileSpans + block_in_tile(x, y)];
        const auto at = static_cast<std::size_t>(y * columns + x);
        span.first = std::min(span.first, blocks.first[at]);
        span.last = std::max(span.last, blocks.last[at]);
      }
    }
  }
}

bool OccupiedSpans::is_any_in(std::size_t number) const {
  const OccupiedSpan* const spans = of_tile(number);
  return std::any_of(spans, spans + kTileSpans,
                     [](const OccupiedSpan& span) { return span.first <= span.last; });
}

}  // namespace octavo
