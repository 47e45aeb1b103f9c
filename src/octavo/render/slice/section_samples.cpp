#include "octavo/render/slice/section_samples.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "octavo/core/error.h"
#include "octavo/core/nearest_voxel.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kTileSide = 64;
constexpr double kOutside = std::numeric_limits<double>::quiet_NaN();

/// The cell of samples around a place, and where in it the place lies.
struct Cell {
  Index3 low;
  Index3 high;
  Point3 share{};
};

Index3 cell_of(const Index3& sample, const Size3& side) {
  return {sample.x / side.x, sample.y / side.y, sample.z / side.z};
}

/// The samples that a tile needs, brick by brick.
class TileSamples {
 public:
  TileSamples(const FileReader& reader, int level)
      : reader_(reader), level_(level), side_(brick_side_at(reader.levels(), level)) {}

  /// Asks for a sample before `load`.
  void need(const Index3& sample) {
    const Index3 brick = cell_of(sample, side_);
    Box& box = blocks_[find(brick)].box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = std::min(box.lo[axis], sample[axis]);
      box.hi[axis] = std::max(box.hi[axis], sample[axis] + 1);
    }
  }

  /// Adds the boxes that `load` reads.
  void add_boxes(std::vector<Box>& boxes) const {
    for (const Block& block : blocks_) boxes.push_back(block.box);
  }

  void load() {
    const VoxelType type = reader_.description().type;
    for (Block& block : blocks_) {
      const auto count = static_cast<std::size_t>(block.box.size().voxel_count());
      bytes_.resize(count * static_cast<std::size_t>(bytes_per_voxel(type)));
      reader_.read(block.box, level_, bytes_.data());
      block.values.resize(count);
      with_voxel_type(type, [&](auto tag) { copy<typename decltype(tag)::type>(block.values); });
    }
  }

  /// A sample that was asked for.
  double at(const Index3& sample) {
    const Block& block = blocks_[find(cell_of(sample, side_))];
    const Size3 size = block.box.size();
    return block.values[static_cast<std::size_t>(
        ((sample.z - block.box.lo.z) * size.y + sample.y - block.box.lo.y) * size.x + sample.x -
        block.box.lo.x)];
  }

 private:
  struct Block {
    Index3 brick;
    Box box;
    std::vector<double> values;
  };

  /// Neighboring pixels mostly lie in one brick.
  std::size_t find(const Index3& brick) {
    if (last_ < blocks_.size() && blocks_[last_].brick == brick) return last_;
    for (last_ = 0; last_ < blocks_.size(); ++last_) {
      if (blocks_[last_].brick == brick) return last_;
    }
    constexpr std::int64_t kFar = std::numeric_limits<std::int64_t>::max();
    blocks_.push_back({brick, {{kFar, kFar, kFar}, {0, 0, 0}}, {}});
    return last_;
  }

  template <class T>
  void copy(std::vector<double>& values) const {
    for (std::size_t i = 0; i < values.size(); ++i) {
      T value;
      std::memcpy(&value, bytes_.data() + i * sizeof value, sizeof value);
      values[i] = static_cast<double>(value);
    }
  }

  const FileReader& reader_;
  int level_;
  Size3 side_;
  std::vector<Block> blocks_;
  std::size_t last_ = 0;
  std::vector<std::byte> bytes_;
};

/// One tile of a section.
class Tile {
 public:
  Tile(const PixelMap& map, const Size3& size, SampleInterpolation interpolation)
      : map_(map), size_(size), interpolation_(interpolation) {}

  /// Where a pixel lies; false outside the volume.
  bool place(std::int64_t x, std::int64_t y, Cell& cell) const {
    const Point3 index = map_.at(static_cast<double>(x), static_cast<double>(y));
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      if (!is_in_voxels(index[a], size_[axis])) return false;
      const auto last = static_cast<double>(size_[axis] - 1);
      const double inside = std::clamp(index[a], 0.0, last);
      const double at = interpolation_ == SampleInterpolation::nearest
                            ? std::min(last, static_cast<double>(nearest_voxel(inside)))
                            : inside;
      cell.low[axis] = static_cast<std::int64_t>(at);
      cell.share[a] = at - std::floor(at);
      cell.high[axis] = cell.low[axis] + (cell.share[a] > 0 ? 1 : 0);
    }
    return true;
  }

  template <class Visit>
  static void for_each_corner(const Cell& cell, Visit visit) {
    for (std::int64_t z = cell.low.z; z <= cell.high.z; ++z) {
      for (std::int64_t y = cell.low.y; y <= cell.high.y; ++y) {
        for (std::int64_t x = cell.low.x; x <= cell.high.x; ++x) visit(Index3{x, y, z});
      }
    }
  }

  static double interpolated(const Cell& cell, TileSamples& samples) {
    std::array<double, 8> v{};
    for (std::size_t i = 0; i < 8; ++i) {
      v[i] = samples.at({(i & 1) != 0 ? cell.high.x : cell.low.x,
                         (i & 2) != 0 ? cell.high.y : cell.low.y,
                         (i & 4) != 0 ? cell.high.z : cell.low.z});
    }
    // A share of 0 must give the sample itself, also beside one that is not finite.
    const auto mixed = [](double a, double b, double share) {
      return share > 0 ? a + share * (b - a) : a;
    };
    for (std::size_t i = 0; i < 4; ++i) v[i] = mixed(v[2 * i], v[2 * i + 1], cell.share[0]);
    for (std::size_t i = 0; i < 2; ++i) v[i] = mixed(v[2 * i], v[2 * i + 1], cell.share[1]);
    const double value = mixed(v[0], v[1], cell.share[2]);
    return std::isfinite(value) ? value : nearest(cell, samples);
  }

  /// Nothing lies between an infinity, or NaN, and another sample.
  static double nearest(const Cell& cell, TileSamples& samples) {
    Index3 at;
    for (int a = 0; a < 3; ++a) {
      const std::int64_t beyond = nearest_voxel(cell.share[static_cast<std::size_t>(a)]);
      at[a] = std::min(cell.low[a] + beyond, cell.high[a]);
    }
    return samples.at(at);
  }

 private:
  const PixelMap& map_;
  Size3 size_;
  SampleInterpolation interpolation_;
};

/// A section cut into tiles, row by row.
class SectionTiles {
 public:
  SectionTiles(const FileReader& reader, int level, const PlaneSection& section,
               SampleInterpolation interpolation)
      : reader_(reader),
        level_(level),
        width_(section.width),
        height_(section.height),
        map_(index_map(section.world,
                       reader.levels().geometry(reader.description().geometry, level))),
        tile_(map_, reader.levels().size(level), interpolation) {}

  std::int64_t count() const { return columns() * ((height_ + kTileSide - 1) / kTileSide); }

  /// Fetches what tiles first .. end - 1 need; false where that is too much at once.
  bool fetch(std::int64_t first, std::int64_t end) const {
    if (reader_.source().fetched_bytes_kept() == 0) return true;
    std::vector<Box> boxes;
    for (std::int64_t number = first; number < end; ++number) needs_of(number).add_boxes(boxes);
    return reader_.fetch(boxes, level_);
  }

  void sample(std::int64_t number, SectionSamples& result) const {
    TileSamples samples = needs_of(number);
    samples.load();
    std::int64_t count = 0;
    for_each_pixel(number, [&](std::int64_t x, std::int64_t y, const Cell& cell) {
      result.values[static_cast<std::size_t>(y * width_ + x)] = Tile::interpolated(cell, samples);
      ++count;
    });
    pixels_inside_ += count;
  }

  /// Of the tiles that were sampled.
  std::int64_t pixels_inside() const { return pixels_inside_; }

 private:
  std::int64_t columns() const { return (width_ + kTileSide - 1) / kTileSide; }

  TileSamples needs_of(std::int64_t number) const {
    TileSamples samples(reader_, level_);
    for_each_pixel(number, [&](std::int64_t, std::int64_t, const Cell& cell) {
      Tile::for_each_corner(cell, [&](const Index3& sample) { samples.need(sample); });
    });
    return samples;
  }

  template <class Visit>
  void for_each_pixel(std::int64_t number, Visit visit) const {
    const std::int64_t left = number % columns() * kTileSide;
    const std::int64_t top = number / columns() * kTileSide;
    Cell cell;
    for (std::int64_t y = top; y < std::min(top + kTileSide, height_); ++y) {
      for (std::int64_t x = left; x < std::min(left + kTileSide, width_); ++x) {
        if (tile_.place(x, y, cell)) visit(x, y, cell);
      }
    }
  }

  const FileReader& reader_;
  int level_;
  std::int64_t width_;
  std::int64_t height_;
  PixelMap map_;
  Tile tile_;
  mutable std::atomic<std::int64_t> pixels_inside_ = 0;
};

/// Tiles first .. end - 1, as many at a time as can be fetched.
void sample_tiles(const SectionTiles& tiles, std::int64_t first, std::int64_t end,
                  SectionSamples& result) {
  if (!tiles.fetch(first, end) && end - first > 1) {
    const std::int64_t middle = first + (end - first) / 2;
    sample_tiles(tiles, first, middle, result);
    sample_tiles(tiles, middle, end, result);
    return;
  }
  parallel_for(first, end, [&](std::int64_t number) { tiles.sample(number, result); });
}

}  // namespace

SectionSamples sample_section(const FileReader& reader, int level, const PlaneSection& section,
                              SampleInterpolation interpolation) {
  const Levels& levels = reader.levels();
  if (level < 0 || level >= levels.count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  SectionSamples result{section.width, section.height, {}, 0};
  result.values.resize(static_cast<std::size_t>(section.width * section.height), kOutside);
  const SectionTiles tiles(reader, level, section, interpolation);
  sample_tiles(tiles, 0, tiles.count(), result);
  result.pixels_inside = tiles.pixels_inside();
  return result;
}

void to_real(SectionSamples& samples, const Rescale& rescale) {
  if (rescale.is_identity()) return;
  for (double& value : samples.values) value = rescale.to_real(value);
}

void keep_labels(SectionSamples& samples, const std::vector<std::int64_t>& kept) {
  for (double& value : samples.values) {
    if (std::isnan(value)) continue;
    const auto label = static_cast<std::int64_t>(value);
    if (!std::binary_search(kept.begin(), kept.end(), label)) value = 0;
  }
}

int level_for_pixels(const FileReader& reader, double pixel_mm) {
  const Levels& levels = reader.levels();
  int level = 0;
  while (level + 1 < levels.count()) {
    const Geometry next = levels.geometry(reader.description().geometry, level + 1);
    if (*std::max_element(next.spacing_mm.begin(), next.spacing_mm.end()) > pixel_mm * 1.001) break;
    ++level;
  }
  return level;
}

}  // namespace octavo
