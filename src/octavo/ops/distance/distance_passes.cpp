#include "octavo/ops/distance/distance_passes.h"

#include <algorithm>
#include <cmath>

#include "octavo/core/error.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

// Columns side by side that are worked on together: a line of the cache.
constexpr std::int64_t kColumns = 16;

/// The pass along an axis of which neighbors stand `stride` apart, for columns side by side.
class ColumnPass {
 public:
  ColumnPass(std::int64_t length, double weight, DistanceTo to)
      : length_(static_cast<std::size_t>(length)),
        line_(length, weight, to),
        columns_(static_cast<std::size_t>(kColumns) * length_) {}

  void run(float* squared, std::int64_t count, std::int64_t stride) {
    const auto columns = static_cast<std::size_t>(count);
    for (std::size_t i = 0; i < length_; ++i) {
      const float* const from = squared + static_cast<std::int64_t>(i) * stride;
      for (std::size_t c = 0; c < columns; ++c) columns_[c * length_ + i] = from[c];
    }
    for (std::size_t c = 0; c < columns; ++c) {
      line_.improve({columns_.data() + c * length_, length_});
    }
    for (std::size_t i = 0; i < length_; ++i) {
      float* const to = squared + static_cast<std::int64_t>(i) * stride;
      for (std::size_t c = 0; c < columns; ++c) to[c] = columns_[c * length_ + i];
    }
  }

 private:
  std::size_t length_;
  LineDistance line_;
  std::vector<float> columns_;
};

void run_columns(ColumnPass& pass, std::int64_t count, std::int64_t stride, float* squared) {
  for (std::int64_t x = 0; x < count; x += kColumns) {
    pass.run(squared + x, std::min(kColumns, count - x), stride);
  }
}

}  // namespace

InsideVoxels inside_of(const MaskTree& mask) {
  return {mask.size(), [&mask](const Box& box, std::uint8_t* inside) {
            fill_voxels(mask, box, inside);
          }};
}

double distance_unit_mm(const DistanceSettings& settings) noexcept {
  return std::min({settings.spacing_mm[0], settings.spacing_mm[1], settings.spacing_mm[2]});
}

double distance_weight(const DistanceSettings& settings, int axis) noexcept {
  const double steps =
      settings.spacing_mm[static_cast<std::size_t>(axis)] / distance_unit_mm(settings);
  return steps * steps;
}

void measure_planes(const InsideVoxels& voxels, std::int64_t begin, std::int64_t end,
                    const DistanceSettings& settings, Progress& progress, float* squared) {
  const Size3 size = voxels.size;
  const std::int64_t plane = size.x * size.y;
  // Four planes are what a word of the tree holds.
  const std::int64_t first = begin / 4;
  const std::int64_t last = (end + 3) / 4;
  parallel_parts(first, last, 1, [&](std::int64_t begin_four, std::int64_t end_four) {
    LineDistance rows(size.x, distance_weight(settings, 0), settings.to);
    ColumnPass columns(size.y, distance_weight(settings, 1), settings.to);
    std::vector<std::uint8_t> inside(static_cast<std::size_t>(4 * plane));
    for (std::int64_t four = begin_four; four != end_four; ++four) {
      if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const std::int64_t lo = std::max(begin, 4 * four);
      const std::int64_t hi = std::min(end, 4 * four + 4);
      voxels.fill({{0, 0, lo}, {size.x, size.y, hi}}, inside.data());
      for (std::int64_t z = lo; z < hi; ++z) {
        float* const out = squared + (z - begin) * plane;
        const std::uint8_t* const in = inside.data() + (z - lo) * plane;
        const auto width = static_cast<std::size_t>(size.x);
        for (std::int64_t y = 0; y < size.y; ++y) {
          rows.begin({in + y * size.x, width}, {out + y * size.x, width});
        }
        run_columns(columns, size.x, size.x, out);
        progress.advance(1);
      }
    }
  });
}

void measure_columns(const Size3& block, const DistanceSettings& settings, float* squared) {
  const std::int64_t plane = block.x * block.y;
  parallel_parts(std::int64_t{0}, block.y, 1, [&](std::int64_t begin, std::int64_t end) {
    ColumnPass columns(block.z, distance_weight(settings, 2), settings.to);
    for (std::int64_t y = begin; y != end; ++y) {
      run_columns(columns, block.x, plane, squared + y * block.x);
    }
  });
}

void to_distances(std::int64_t count, const DistanceSettings& settings, double limit_mm,
                  const float* squared, float* mm) {
  const double unit = distance_unit_mm(settings);
  parallel_parts(std::int64_t{0}, count, 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i != end; ++i) {
      const double root = std::sqrt(static_cast<double>(std::abs(squared[i])));
      const double length = std::min(unit * root, limit_mm);
      mm[i] = static_cast<float>(std::copysign(length, squared[i]));
    }
  });
}

std::vector<float> signed_distances(const MaskTree& mask, const DistanceSettings& settings,
                                    Progress& progress) {
  const Size3 size = mask.size();
  std::vector<float> values(static_cast<std::size_t>(size.voxel_count()));
  measure_planes(inside_of(mask), 0, size.z, settings, progress, values.data());
  measure_columns(size, settings, values.data());
  to_distances(size.voxel_count(), settings, HUGE_VAL, values.data(), values.data());
  return values;
}

}  // namespace octavo
