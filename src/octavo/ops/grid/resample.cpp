#include "octavo/ops/grid/resample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/core/nearest_voxel.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kTileSide = 32;
// A tile that needs more source voxels is cut in two.
constexpr std::int64_t kMostSourceVoxels = std::int64_t{1} << 22;

double as_double(std::int64_t number) { return static_cast<double>(number); }
std::size_t as_index(std::int64_t number) { return static_cast<std::size_t>(number); }

// The voxel that a value becomes.
template <class T>
T voxel_of(double value) {
  if constexpr (std::is_floating_point_v<T>) {
    constexpr auto kLargest = static_cast<double>(std::numeric_limits<T>::max());
    return static_cast<T>(std::clamp(value, -kLargest, kLargest));
  } else {
    constexpr auto kLowest = static_cast<double>(std::numeric_limits<T>::lowest());
    constexpr auto kLargest = static_cast<double>(std::numeric_limits<T>::max());
    return static_cast<T>(std::clamp(std::floor(value + 0.5), kLowest, kLargest));
  }
}

// The voxel at or before a point. Its neighbors are counted from it: a point moved by whole voxels
// may round to another one.
std::int64_t voxel_at(double point) { return static_cast<std::int64_t>(std::floor(point)); }

// Where a map takes the centers of a box: the minimum and the maximum coordinate on each axis.
struct Extent {
  Point3 lo{};
  Point3 hi{};
};

Extent extent_of(const Affine& map, const Box& box) {
  Extent extent{map.offset, map.offset};
  for (std::size_t row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) {
      const double step = map.linear[3 * row + static_cast<std::size_t>(axis)];
      const double first = step * as_double(box.lo[axis]);
      const double last = step * as_double(box.hi[axis] - 1);
      extent.lo[row] += std::min(first, last);
      extent.hi[row] += std::max(first, last);
    }
  }
  return extent;
}

// Weights of the voxels at -1, 0, 1, 2 for a point `t` behind 0.
std::array<double, 4> cubic_weights(double t) {
  const double s = 1 - t;
  return {-0.5 * t * s * s, 1 + t * t * (1.5 * t - 2.5), 1 + s * s * (1.5 * s - 2.5),
          -0.5 * s * t * t};
}

}  // namespace

/// One tile: the source voxels that it may need, and where they lie.
class Resampler::Tile {
 public:
  Tile(const Resampler& of, const Box& tile, const Box& box, std::byte* voxels)
      : of_(of), tile_(tile), box_(box), voxels_(voxels), extent_(extent_of(of.to_source_, tile)) {
    is_met_ = true;
    is_inside_ = true;
    const double reach = of.interpolation_ == Interpolation::cubic ? 3 : 2;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double end = as_double(of.size_[axis]);
      // A range that is not a number meets nothing.
      if (!(extent_.lo[a] < end && extent_.hi[a] > -1)) {
        is_met_ = false;
        return;
      }
      is_inside_ = is_inside_ && extent_.lo[a] >= -0.5 && extent_.hi[a] <= end - 0.5;
      needed_.lo[axis] =
          static_cast<std::int64_t>(std::clamp(std::floor(extent_.lo[a]) - reach, 0.0, end - 1));
      needed_.hi[axis] = 1 + static_cast<std::int64_t>(
                                 std::clamp(std::floor(extent_.hi[a]) + reach, 0.0, end - 1));
    }
  }

  /// False when none of the tile lies in the source.
  bool is_met() const { return is_met_; }
  std::int64_t needed_voxels() const { return needed_.size().voxel_count(); }

  void fill_outside() const { fill_with(of_.outside_); }

  void make() const {
    const std::optional<double> uniform = value_of_bricks();
    if (uniform && (is_inside_ || *uniform == of_.outside_)) {
      fill_with(*uniform);
      return;
    }
    with_voxel_type(of_.source_.description().type, [&](auto id) {
      using T = typename decltype(id)::type;
      std::vector<T> source(as_index(needed_voxels()));
      of_.source_.read(needed_, of_.level_, source.data());
      make_from(source.data());
    });
  }

 private:
  template <class T>
  T* row_of(std::int64_t y, std::int64_t z) const {
    const Size3 size = box_.size();
    return reinterpret_cast<T*>(voxels_) + ((z - box_.lo.z) * size.y + y - box_.lo.y) * size.x -
           box_.lo.x;
  }

  void fill_with(double value) const {
    with_voxel_type(of_.source_.description().type, [&](auto id) {
      using T = typename decltype(id)::type;
      for_each_row([&](std::int64_t y, std::int64_t z) {
        T* const row = row_of<T>(y, z);
        std::fill(row + tile_.lo.x, row + tile_.hi.x, static_cast<T>(value));
      });
    });
  }

  // The one value of all bricks that are needed, if there is one.
  std::optional<double> value_of_bricks() const {
    const Levels& levels = of_.source_.levels();
    const Size3 side = brick_side_at(levels, of_.level_);
    std::optional<std::int64_t> value;
    visit_cells(needed_, side, [&](const Index3& place) {
      const BrickEntry brick = of_.source_.brick(Levels::tier_of(of_.level_), place);
      const bool is_same = brick.is_uniform() && brick.range.min == value.value_or(brick.range.min);
      value = is_same ? std::optional(brick.range.min) : std::nullopt;
      return is_same;
    });
    if (!value) return {};
    return of_.source_.description().voxel_of(*value);
  }

  template <class F>
  void for_each_row(const F& take) const {
    for (std::int64_t z = tile_.lo.z; z < tile_.hi.z; ++z) {
      for (std::int64_t y = tile_.lo.y; y < tile_.hi.y; ++y) take(y, z);
    }
  }

  template <class T>
  void make_from(const T* source) const {
    if (of_.interpolation_ != Interpolation::nearest) interpolate(source);
    else if (is_along_axes()) copy_along_axes(source);
    else copy_nearest(source);
  }

  // How far a voxel lies from the first one that was read, on one axis; those outside the source
  // are the ones at its border.
  std::int64_t distance(int axis, std::int64_t voxel) const {
    const Size3 size = needed_.size();
    const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? size.x : size.x * size.y;
    return stride * (std::clamp(voxel, needed_.lo[axis], needed_.hi[axis] - 1) - needed_.lo[axis]);
  }

  // The point of the source at a voxel of the grid, on one axis. Always summed in this order, so
  // that tiles do not show.
  double point(std::size_t axis, double x, double y, double z) const {
    const double* const m = of_.to_source_.linear.data() + 3 * axis;
    return of_.to_source_.offset[axis] + m[2] * z + m[1] * y + m[0] * x;
  }

  // True when every axis of the source follows one axis of the grid.
  bool is_along_axes() const {
    for (std::size_t row = 0; row < 3; ++row) {
      const double* const m = of_.to_source_.linear.data() + 3 * row;
      if ((m[0] != 0) + (m[1] != 0) + (m[2] != 0) > 1) return false;
    }
    return true;
  }

  // The nearest voxels of a grid that lies along the source: distances add up axis by axis.
  template <class T>
  void copy_along_axes(const T* source) const {
    constexpr std::int64_t kOutside = -1;
    std::array<std::vector<std::int64_t>, 3> distances;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<std::int64_t>& list = distances[static_cast<std::size_t>(axis)];
      for (std::int64_t i = tile_.lo[axis]; i < tile_.hi[axis]; ++i) {
        list.push_back(distance_along(axis, as_double(i)).value_or(kOutside));
      }
    }
    const T outside = static_cast<T>(of_.outside_);
    for_each_row([&](std::int64_t y, std::int64_t z) {
      T* const row = row_of<T>(y, z) + tile_.lo.x;
      const std::int64_t of_y = distances[1][as_index(y - tile_.lo.y)];
      const std::int64_t of_z = distances[2][as_index(z - tile_.lo.z)];
      const std::vector<std::int64_t>& of_x = distances[0];
      if (of_y == kOutside || of_z == kOutside) {
        std::fill_n(row, of_x.size(), outside);
        return;
      }
      const T* const from = source + of_y + of_z;
      for (std::size_t i = 0; i < of_x.size(); ++i) {
        row[i] = of_x[i] == kOutside ? outside : from[of_x[i]];
      }
    });
  }

  // What the axes of the source that follow one axis of the grid add to the distance; those that
  // follow none are taken with x.
  std::optional<std::int64_t> distance_along(int axis, double at) const {
    std::int64_t sum = 0;
    for (int s = 0; s < 3; ++s) {
      const double* const m = &of_.to_source_.linear[3 * static_cast<std::size_t>(s)];
      const int follows = m[2] != 0 ? 2 : m[1] != 0 ? 1 : 0;
      if (follows != axis) continue;
      const double p = of_.to_source_.offset[static_cast<std::size_t>(s)] + m[axis] * at;
      if (!is_in_voxels(p, of_.size_[s])) return {};
      sum += distance(s, nearest_voxel(p));
    }
    return sum;
  }

  // Calls take(voxel, x, y, z) for every voxel of the tile with its point in the source.
  template <class T, class F>
  void for_each_inside(const F& take) const {
    const T outside = static_cast<T>(of_.outside_);
    for_each_row([&](std::int64_t y, std::int64_t z) {
      T* const row = row_of<T>(y, z);
      for (std::int64_t x = tile_.lo.x; x < tile_.hi.x; ++x) {
        const double px = point(0, as_double(x), as_double(y), as_double(z));
        const double py = point(1, as_double(x), as_double(y), as_double(z));
        const double pz = point(2, as_double(x), as_double(y), as_double(z));
        const bool is_in = is_in_voxels(px, of_.size_.x) && is_in_voxels(py, of_.size_.y) &&
                           is_in_voxels(pz, of_.size_.z);
        if (is_in) take(row[x], px, py, pz);
        else row[x] = outside;
      }
    });
  }

  template <class T>
  void copy_nearest(const T* source) const {
    for_each_inside<T>([&](T& voxel, double x, double y, double z) {
      voxel = nearest_to(source, x, y, z);
    });
  }

  template <class T>
  void interpolate(const T* source) const {
    if (of_.interpolation_ == Interpolation::cubic) {
      for_each_inside<T>([&](T& voxel, double x, double y, double z) {
        voxel = voxel_at_point(source, cubic_at(source, x, y, z), x, y, z);
      });
    } else {
      for_each_inside<T>([&](T& voxel, double x, double y, double z) {
        voxel = voxel_at_point(source, linear_at(source, x, y, z), x, y, z);
      });
    }
  }

  template <class T>
  double linear_at(const T* source, double x, double y, double z) const {
    const std::int64_t vx = voxel_at(x);
    const std::int64_t vy = voxel_at(y);
    const std::int64_t vz = voxel_at(z);
    const double tx = x - as_double(vx);
    const double ty = y - as_double(vy);
    const double tz = z - as_double(vz);
    const std::int64_t x0 = distance(0, vx);
    const std::int64_t x1 = distance(0, vx + 1);
    const auto along_x = [&](std::int64_t at) {
      return as_value(source[at + x0]) * (1 - tx) + as_value(source[at + x1]) * tx;
    };
    const std::int64_t y0 = distance(1, vy);
    const std::int64_t y1 = distance(1, vy + 1);
    const auto along_y = [&](std::int64_t at) {
      return along_x(at + y0) * (1 - ty) + along_x(at + y1) * ty;
    };
    return along_y(distance(2, vz)) * (1 - tz) + along_y(distance(2, vz + 1)) * tz;
  }

  // The voxels along an axis that have a weight.
  struct Taps {
    std::array<double, 4> weights{};
    std::array<std::int64_t, 4> distances{};
    std::size_t count = 0;

    void add(double weight, std::int64_t distance) {
      weights[count] = weight;
      distances[count++] = distance;
    }
  };

  // The voxel at a point, of which `value` was interpolated.
  template <class T>
  T voxel_at_point(const T* source, double value, double x, double y, double z) const {
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(value)) return beside_no_number(source, x, y, z);
    }
    return voxel_of<T>(value);
  }

  // Nothing lies between an infinity, or NaN, and another voxel: the nearest counts. Where those
  // that are no numbers have no weight, the others are interpolated.
  template <class T>
  T beside_no_number(const T* source, double x, double y, double z) const {
    const bool is_cubic = of_.interpolation_ == Interpolation::cubic;
    const Point3 point = {x, y, z};
    std::array<Taps, 3> taps;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t before = voxel_at(point[a]);
      const double share = point[a] - as_double(before);
      const auto weights = is_cubic ? cubic_weights(share) : std::array{0.0, 1 - share, share, 0.0};
      for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] == 0) continue;
        const std::int64_t voxel = before - 1 + static_cast<std::int64_t>(i);
        taps[a].add(weights[i], distance(static_cast<int>(a), voxel));
      }
    }
    double sum = 0;
    for (std::size_t k = 0; k < taps[2].count; ++k) {
      for (std::size_t j = 0; j < taps[1].count; ++j) {
        const double of_row = taps[2].weights[k] * taps[1].weights[j];
        const T* const row = source + taps[2].distances[k] + taps[1].distances[j];
        for (std::size_t i = 0; i < taps[0].count; ++i) {
          const double voxel = as_value(row[taps[0].distances[i]]);
          // Whatever is added, it is no number any more.
          if (!std::isfinite(voxel)) return nearest_to(source, x, y, z);
          sum += of_row * taps[0].weights[i] * voxel;
        }
      }
    }
    return voxel_of<T>(sum);
  }

  template <class T>
  T nearest_to(const T* source, double x, double y, double z) const {
    return source[distance(0, nearest_voxel(x)) + distance(1, nearest_voxel(y)) +
                  distance(2, nearest_voxel(z))];
  }

  template <class T>
  double cubic_at(const T* source, double x, double y, double z) const {
    const std::int64_t vx = voxel_at(x);
    const std::int64_t vy = voxel_at(y);
    const std::int64_t vz = voxel_at(z);
    const std::array<double, 4> wx = cubic_weights(x - as_double(vx));
    const std::array<double, 4> wy = cubic_weights(y - as_double(vy));
    const std::array<double, 4> wz = cubic_weights(z - as_double(vz));
    std::array<std::int64_t, 4> dx{};
    std::array<std::int64_t, 4> dy{};
    for (std::int64_t i = 0; i < 4; ++i) {
      dx[as_index(i)] = distance(0, vx + i - 1);
      dy[as_index(i)] = distance(1, vy + i - 1);
    }
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const T* const plane = source + distance(2, vz + static_cast<std::int64_t>(k) - 1);
      double of_plane = 0;
      for (std::size_t j = 0; j < 4; ++j) {
        const T* const row = plane + dy[j];
        double of_row = 0;
        for (std::size_t i = 0; i < 4; ++i) of_row += wx[i] * as_value(row[dx[i]]);
        of_plane += wy[j] * of_row;
      }
      sum += wz[k] * of_plane;
    }
    return sum;
  }

  template <class T>
  static double as_value(T voxel) {
    return static_cast<double>(voxel);
  }

  const Resampler& of_;
  Box tile_;
  Box box_;
  std::byte* voxels_;
  Extent extent_;
  bool is_met_ = false;
  bool is_inside_ = false;  // all of the tile
  Box needed_;              // of the source, clipped to it
};

Resampler::Resampler(const FileReader& source, int level, const Affine& to_source,
                     Interpolation interpolation, double outside)
    : source_(source),
      level_(level),
      to_source_(to_source),
      interpolation_(interpolation),
      outside_(outside) {
  if (level < 0 || level >= source.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  const auto is_number = [](double number) { return std::isfinite(number); };
  if (!std::all_of(to_source.linear.begin(), to_source.linear.end(), is_number) ||
      !std::all_of(to_source.offset.begin(), to_source.offset.end(), is_number)) {
    throw Error(ErrorKind::invalid_argument, "a map with numbers that are not finite");
  }
  size_ = source.levels().size(level);
}

void Resampler::fill(const Box& box, std::byte* voxels) const {
  Size3 tiles;
  for (int axis = 0; axis < 3; ++axis) {
    tiles[axis] = (box.hi[axis] - box.lo[axis] + kTileSide - 1) / kTileSide;
  }
  parallel_for(std::int64_t{0}, tiles.voxel_count(), [&](std::int64_t i) {
    const Index3 lo{box.lo.x + i % tiles.x * kTileSide,
                    box.lo.y + i / tiles.x % tiles.y * kTileSide,
                    box.lo.z + i / (tiles.x * tiles.y) * kTileSide};
    const Box tile{lo, {lo.x + kTileSide, lo.y + kTileSide, lo.z + kTileSide}};
    fill_tile(intersection(tile, box), box, voxels);
  });
}

void Resampler::fill_tile(const Box& tile, const Box& box, std::byte* voxels) const {
  const Tile work(*this, tile, box, voxels);
  if (!work.is_met()) {
    work.fill_outside();
    return;
  }
  const Size3 size = tile.size();
  if (work.needed_voxels() <= kMostSourceVoxels || size.voxel_count() == 1) {
    work.make();
    return;
  }
  int axis = 0;
  if (size.y > size[axis]) axis = 1;
  if (size.z > size[axis]) axis = 2;
  Box half = tile;
  half.hi[axis] = tile.lo[axis] + size[axis] / 2;
  fill_tile(half, box, voxels);
  half.lo[axis] = half.hi[axis];
  half.hi[axis] = tile.hi[axis];
  fill_tile(half, box, voxels);
}

MaskTree resampled_mask(const FileReader& labels, const Affine& to_source, const Size3& size,
                        std::span<const ValueWindow> windows, Progress& progress,
                        std::uint64_t max_bytes) {
  constexpr std::int64_t kSide = MaskBuilder::kLayerPlanes;
  const Resampler resampler(labels, 0, to_source, Interpolation::nearest, 0);
  const VoxelType type = labels.description().type;
  MaskBuilder builder(size);
  const Size3 grid{(size.x + kSide - 1) / kSide, (size.y + kSide - 1) / kSide, 1};
  for (std::int64_t z = 0; z < size.z; z += kSide) {
    parallel_for(std::int64_t{0}, grid.voxel_count(), [&](std::int64_t i) {
      if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const Index3 lo{i % grid.x * kSide, i / grid.x * kSide, z};
      const Box box = intersection(box_of(size), {lo, {lo.x + kSide, lo.y + kSide, lo.z + kSide}});
      const Size3 part = box.size();
      std::vector<std::byte> voxels(as_index(part.voxel_count() * bytes_per_voxel(type)));
      resampler.fill(box, voxels.data());
      const BrickView block{voxels.data(), type, part, part.x, part.x * part.y};
      for (const ValueWindow& window : windows) builder.add_block(box.lo, block, window);
    });
    builder.finish_layer();
    require_memory_within(builder.memory_bytes(), max_bytes, "the mask");
    progress.advance(std::min(kSide, size.z - z));
  }
  return builder.finish();
}

}  // namespace octavo
