#include "octavo/builder/flat_cubes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "octavo/builder/float_grid.h"
#include "octavo/core/error.h"
#include "octavo/file/parallel_read.h"
#include "octavo/octree/o_code.h"
#include "octavo/planes/plane_cursor.h"

namespace octavo {

namespace {

constexpr int kBlockLevel = 6;
constexpr std::int64_t kSide = std::int64_t{1} << kBlockLevel;

// What is known of a cube: its least and greatest voxel, and the sum of what is above the least.
struct Extent {
  std::int64_t min = std::numeric_limits<std::int64_t>::max();
  std::int64_t max = std::numeric_limits<std::int64_t>::min();
  std::uint64_t excess = 0;
  std::uint64_t voxels = 0;

  void add(const Extent& part) {
    if (part.voxels == 0) return;
    if (voxels == 0) {
      *this = part;
      return;
    }
    const std::int64_t lower = std::min(min, part.min);
    const auto above = [&](const Extent& e) {
      return e.excess + e.voxels * static_cast<std::uint64_t>(e.min - lower);
    };
    excess = above(*this) + above(part);
    voxels += part.voxels;
    min = lower;
    max = std::max(max, part.max);
  }

  std::int64_t mean() const {
    return min + static_cast<std::int64_t>((2 * excess + voxels) / (2 * voxels));
  }
};

// A block of 64^3 voxels as the numbers that bricks hold, dense in its own size.
struct Block {
  Size3 size;
  std::vector<std::int64_t> voxels;

  std::int64_t* row(std::int64_t y, std::int64_t z) {
    return voxels.data() + (z * size.y + y) * size.x;
  }
};

Box box_from(const Index3& lo, std::int64_t side) {
  return {lo, {lo.x + side, lo.y + side, lo.z + side}};
}

// Evens out the flat cubes in a cube of a block, the smaller ones first, as far as the volume goes.
// Returns what the voxels were before.
Extent even_out(Block& block, int level, const Index3& corner, std::int64_t flat) {
  Extent extent;
  if (level == 0) {
    const std::int64_t value = block.row(corner.y, corner.z)[corner.x];
    return {value, value, 0, 1};
  }
  const std::int64_t side = std::int64_t{1} << level;
  for (std::int64_t i = 0; i < 8; ++i) {
    const Index3 child{corner.x + side / 2 * (i & 1), corner.y + side / 2 * (i >> 1 & 1),
                       corner.z + side / 2 * (i >> 2)};
    if (box_of(block.size).contains(child)) extent.add(even_out(block, level - 1, child, flat));
  }
  if (extent.max - extent.min <= flat) {
    const Box cube = intersection(box_of(block.size), box_from(corner, side));
    for (std::int64_t z = cube.lo.z; z < cube.hi.z; ++z) {
      for (std::int64_t y = cube.lo.y; y < cube.hi.y; ++y) {
        std::fill_n(block.row(y, z) + cube.lo.x, cube.size().x, extent.mean());
      }
    }
  }
  return extent;
}

class FlatCubes final : public PlaneSource {
 public:
  FlatCubes(std::shared_ptr<const FileReader> reader, const VolumeDescription& description,
            std::int64_t flat, int threads)
      : reader_(std::move(reader)),
        description_(description),
        coding_(reader_->description().coding.value_or(SampleCoding{})),
        flat_(flat),
        for_each_(for_each_parallel(threads)),
        size_(description.size),
        files_(files_of_volume({reader_->source().name()})),
        cursor_(size_.z) {
    check();
    for (int axis = 0; axis < 3; ++axis) grid_[axis] = (size_[axis] + kSide - 1) / kSide;
    find_large_cubes();
  }

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  const PlaneFiles& files() const override { return files_; }

  std::uint64_t resident_bytes() const override {
    return static_cast<std::uint64_t>(size_.x * size_.y * std::min(size_.z, kSide) *
                                      bytes_per_voxel(description_.type));
  }

  void read_plane(std::span<std::byte> plane) override {
    const auto bytes =
        static_cast<std::size_t>(size_.x * size_.y * bytes_per_voxel(description_.type));
    if (plane.size() != bytes) {
      throw Error(ErrorKind::invalid_argument, "a buffer of another size than that of a plane");
    }
    const std::int64_t z = cursor_.take();
    if (z / kSide != layer_at_) make_layer(z / kSide);
    const auto at = static_cast<std::size_t>(z % kSide) * bytes;
    std::memcpy(plane.data(), layer_.data() + at, bytes);
  }

  void seek(std::int64_t first, std::int64_t end) override { cursor_.seek(first, end); }

 private:
  // The cubes of side 64 * 2^k, all of them or none flat.
  struct Floor {
    Size3 grid;
    std::vector<Extent> extents;
  };

  void check() const {
    if (description_.kind != VolumeKind::grey) {
      throw Error(ErrorKind::invalid_argument, "only grey volumes are condensed");
    }
    const std::int64_t most = (std::int64_t{1} << 62) >> std::min(62, 3 * universe_level(size_));
    if (flat_ >= 0 && (flat_ == 0 || flat_ < most)) return;
    throw Error(ErrorKind::invalid_argument,
                "a flatness of " + std::to_string(flat_) + "; it must be 0 to " +
                    std::to_string(std::max<std::int64_t>(0, most - 1)));
  }

  static std::size_t place(const Size3& grid, const Index3& cell) {
    return static_cast<std::size_t>((cell.z * grid.y + cell.y) * grid.x + cell.x);
  }

  static Index3 cell_of(const Size3& grid, std::int64_t i) {
    return {i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)};
  }

  Box block_box(const Index3& block) const {
    const Index3 lo{block.x * kSide, block.y * kSide, block.z * kSide};
    return intersection(box_of(size_), box_from(lo, kSide));
  }

  // Voxels as the numbers that bricks hold, and back.
  template <class T>
  std::int64_t code_of(T voxel) const {
    if constexpr (std::is_floating_point_v<T>) {
      if (const auto code = exact_code(coding_, voxel)) return *code;
      const char* const why =
          std::isfinite(voxel)
              ? "holds floats that are no multiples of one number, which have no exact means; "
                "only a copy within a max error is condensed"
              : "holds NaN or infinite values, which have no mean; only a copy with other values "
                "in their place is condensed";
      throw Error(ErrorKind::invalid_argument, why, reader_->source().name());
    } else {
      return static_cast<std::int64_t>(voxel);
    }
  }

  template <class T>
  T voxel_of(std::int64_t code) const {
    if constexpr (std::is_floating_point_v<T>) return coding_.voxel_of(code);
    else return static_cast<T>(code);
  }

  // Calls visit(entry, box) for the bricks of level 0 in a block.
  template <class Visit>
  void visit_bricks(const Box& block, Visit visit) const {
    const Size3 side = reader_->levels().brick_side(0);
    visit_cells(block, side, [&](const Index3& brick) {
      visit(reader_->brick(0, brick), reader_->levels().brick_box(0, brick));
      return true;
    });
  }

  Block decoded(const Index3& place) const {
    const Box box = block_box(place);
    Block block{box.size(), {}};
    block.voxels.resize(static_cast<std::size_t>(block.size.voxel_count()));
    const std::int64_t width = bytes_per_voxel(description_.type);
    std::vector<std::byte> voxels;
    visit_bricks(box, [&](const BrickEntry& entry, const Box& part) {
      const Size3 size = part.size();
      voxels.resize(static_cast<std::size_t>(size.voxel_count() * width));
      reader_->read_brick(entry, 0, voxels.data());
      with_voxel_type(description_.type, [&](auto id) {
        using T = typename decltype(id)::type;
        const std::byte* from = voxels.data();
        for (std::int64_t i = 0; i < size.y * size.z; ++i) {
          std::int64_t* const row =
              block.row(part.lo.y - box.lo.y + i % size.y, part.lo.z - box.lo.z + i / size.y);
          for (std::int64_t x = 0; x < size.x; ++x, from += sizeof(T)) {
            T value;
            std::memcpy(&value, from, sizeof value);
            row[part.lo.x - box.lo.x + x] = code_of(value);
          }
        }
      });
    });
    return block;
  }

  Extent decoded_extent(const Index3& place) const {
    const Block block = decoded(place);
    const auto [min, max] = std::minmax_element(block.voxels.begin(), block.voxels.end());
    Extent extent{*min, *max, 0, block.voxels.size()};
    for (const std::int64_t value : block.voxels) {
      extent.excess += static_cast<std::uint64_t>(value - *min);
    }
    return extent;
  }

  // Of the index; without the sum where it takes decoding.
  Extent indexed_extent(const Index3& place) const {
    Extent extent;
    visit_bricks(block_box(place), [&](const BrickEntry& entry, const Box& part) {
      extent.add({entry.range.min, entry.range.max, 0,
                  static_cast<std::uint64_t>(part.size().voxel_count())});
    });
    return extent;
  }

  // Finds the flat cubes above 64^3 and the mean of each.
  void find_large_cubes() {
    Floor blocks{grid_, std::vector<Extent>(static_cast<std::size_t>(grid_.voxel_count()))};
    const bool is_exact = reader_->max_error() == 0;
    const auto extent_of = [&](std::int64_t i) {
      const Index3 cell = cell_of(grid_, i);
      return is_exact ? indexed_extent(cell) : decoded_extent(cell);
    };
    if (std::max({grid_.x, grid_.y, grid_.z}) > 1) {
      for_each_(grid_.voxel_count(), [&](std::int64_t i) {
        blocks.extents[static_cast<std::size_t>(i)] = extent_of(i);
      });
    }
    means_.assign(blocks.extents.size(), kNone);
    std::vector<Floor> floors = {std::move(blocks)};
    while (floors.back().grid.voxel_count() > 1) floors.push_back(floor_above(floors.back()));
    for (std::size_t k = floors.size() - 1; k > 0; --k) {
      for (std::int64_t i = 0; i < floors[k].grid.voxel_count(); ++i) {
        const Extent& extent = floors[k].extents[static_cast<std::size_t>(i)];
        if (extent.max - extent.min > flat_) continue;
        even_out_large(cell_of(floors[k].grid, i), std::int64_t{1} << k);
      }
    }
  }

  static Floor floor_above(const Floor& below) {
    Floor floor;
    for (int axis = 0; axis < 3; ++axis) floor.grid[axis] = (below.grid[axis] + 1) / 2;
    floor.extents.resize(static_cast<std::size_t>(floor.grid.voxel_count()));
    for (std::int64_t i = 0; i < below.grid.voxel_count(); ++i) {
      const Index3 cell = cell_of(below.grid, i);
      floor.extents[place(floor.grid, {cell.x / 2, cell.y / 2, cell.z / 2})].add(
          below.extents[static_cast<std::size_t>(i)]);
    }
    return floor;
  }

  // Gives the mean of a cube of `count`^3 blocks, as far as there are any, to each of them.
  void even_out_large(const Index3& cell, std::int64_t count) {
    const Index3 lo{cell.x * count, cell.y * count, cell.z * count};
    if (means_[place(grid_, lo)] != kNone) return;  // in a larger one
    const Size3 side = intersection(box_of(grid_), box_from(lo, count)).size();
    std::vector<Extent> extents(static_cast<std::size_t>(side.voxel_count()));
    const auto block_at = [&](std::int64_t i) {
      const Index3 at = cell_of(side, i);
      return Index3{lo.x + at.x, lo.y + at.y, lo.z + at.z};
    };
    for_each_(side.voxel_count(), [&](std::int64_t i) {
      const Extent indexed = indexed_extent(block_at(i));
      extents[static_cast<std::size_t>(i)] =
          indexed.min == indexed.max ? indexed : decoded_extent(block_at(i));
    });
    Extent all;
    for (const Extent& extent : extents) all.add(extent);
    for (std::int64_t i = 0; i < side.voxel_count(); ++i) {
      means_[place(grid_, block_at(i))] = all.mean();
    }
  }

  void make_layer(std::int64_t z) {
    layer_at_ = z;
    const std::int64_t planes = std::min(kSide, size_.z - z * kSide);
    layer_.resize(
        static_cast<std::size_t>(size_.x * size_.y * planes * bytes_per_voxel(description_.type)));
    for_each_(grid_.x * grid_.y, [&](std::int64_t i) {
      const Index3 cell{i % grid_.x, i / grid_.x, z};
      const std::int64_t mean = means_[place(grid_, cell)];
      Block block;
      if (mean == kNone) {
        block = decoded(cell);
        even_out(block, kBlockLevel, {0, 0, 0}, flat_);
      } else {
        block.size = block_box(cell).size();
        block.voxels.assign(static_cast<std::size_t>(block.size.voxel_count()), mean);
      }
      put(block, cell);
    });
  }

  void put(Block& block, const Index3& cell) {
    with_voxel_type(description_.type, [&](auto id) {
      using T = typename decltype(id)::type;
      for (std::int64_t z = 0; z < block.size.z; ++z) {
        for (std::int64_t y = 0; y < block.size.y; ++y) {
          const std::int64_t* const row = block.row(y, z);
          const std::int64_t to = (z * size_.y + cell.y * kSide + y) * size_.x + cell.x * kSide;
          for (std::int64_t x = 0; x < block.size.x; ++x) {
            const T value = voxel_of<T>(row[x]);
            std::memcpy(layer_.data() + static_cast<std::size_t>(to + x) * sizeof value, &value,
                        sizeof value);
          }
        }
      }
    });
  }

  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();

  std::shared_ptr<const FileReader> reader_;
  VolumeDescription description_;
  SampleCoding coding_;  // of float32
  std::int64_t flat_;
  ForEach for_each_;
  Size3 size_;
  PlaneFiles files_;
  Size3 grid_;                       // of blocks
  std::vector<std::int64_t> means_;  // of each block's large cube, or kNone
  std::vector<Warning> warnings_;
  std::vector<std::byte> layer_;  // 64 planes
  std::int64_t layer_at_ = -1;    // which of the layers it is
  PlaneCursor cursor_;
};

}  // namespace

std::unique_ptr<PlaneSource> make_flat_cubes(std::shared_ptr<const FileReader> reader,
                                             const VolumeDescription& description,
                                             std::int64_t flat, int threads) {
  return std::make_unique<FlatCubes>(std::move(reader), description, flat, threads);
}

}  // namespace octavo
