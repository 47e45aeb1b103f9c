#include "octavo/mesh/extraction.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/mesh/surface_block.h"

namespace octavo {

namespace {

/// The part of a block that one brick of the file covers, in voxels of the block.
struct BrickPart {
  Box box;  ///< each side within -1 .. 64
  InsideShare share = InsideShare::none;
};

/// What a thread works with.
template <class T>
struct BlockSpace {
  SurfaceValues<T> values;
  std::vector<BrickPart> parts;
};

std::uint64_t low_bits(std::int64_t count) {
  return count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

/// Makes the blocks of one file and level.
template <class T>
class BlockMaker {
 public:
  BlockMaker(const FileReader& reader, int level, const SurfaceField& field)
      : reader_(reader),
        level_(level),
        field_(field),
        inside_(field),
        frame_(reader.levels().geometry(reader.description().geometry, level),
               reader.levels().size(level)),
        brick_side_(brick_side_at(reader.levels(), level)) {}

  const SurfaceFrame& frame() const { return frame_; }

  /// Has the reader decode and keep the bricks that begin in a block.
  void fetch(const Index3& place, BlockSpace<T>& space) const {
    const Index3 corner = corner_of(place);
    find_parts(corner, space.parts);
    for (const BrickPart& part : space.parts) {
      const Index3& lo = part.box.lo;
      if (part.share == InsideShare::some && lo.x >= 0 && lo.y >= 0 && lo.z >= 0) {
        read(part, corner, space.values);
      }
    }
  }

  /// The block at a place of the grid of blocks, its numbers counted from 0; nothing where the
  /// surface cuts none of its edges.
  std::unique_ptr<SurfaceBlock> make(const Index3& place, BlockSpace<T>& space) const {
    const Index3 corner = corner_of(place);
    find_parts(corner, space.parts);
    const auto is_outside = [](const BrickPart& part) { return part.share == InsideShare::none; };
    if (std::all_of(space.parts.begin(), space.parts.end(), is_outside)) return nullptr;

    auto block = std::make_unique<SurfaceBlock>();
    for (const BrickPart& part : space.parts) set_bits(part, corner, space.values, block->bits);
    if (!block->is_cut()) return nullptr;
    if (field_.isovalue) read_decided(corner, *block, space);
    place_points(field_, frame_, corner, space.values, *block);
    return block;
  }

 private:
  static Index3 corner_of(const Index3& place) {
    return {place.x * kSurfaceSide, place.y * kSurfaceSide, place.z * kSurfaceSide};
  }

  void find_parts(const Index3& corner, std::vector<BrickPart>& parts) const {
    const VolumeDescription& description = reader_.description();
    const bool may_hold_others = description.codec_type() == VoxelType::float32;
    const Box block = {{corner.x - 1, corner.y - 1, corner.z - 1},
                       {corner.x + kSurfaceSide, corner.y + kSurfaceSide,
                        corner.z + kSurfaceSide}};
    parts.clear();
    visit_cells(intersection(block, box_of(frame_.size())), brick_side_,
                [&](const Index3& brick) {
      const Box box = intersection(brick_box_at(reader_.levels(), level_, brick), block);
      const ValueRange range = reader_.brick(Levels::tier_of(level_), brick).range;
      const auto [lowest, highest] = std::minmax(
          {description.voxel_of(range.min), description.voxel_of(range.max)});
      parts.push_back({{{box.lo.x - corner.x, box.lo.y - corner.y, box.lo.z - corner.z},
                        {box.hi.x - corner.x, box.hi.y - corner.y, box.hi.z - corner.z}},
                       inside_share(field_, lowest, highest, may_hold_others)});
      return true;
    });
  }

  void read(const BrickPart& part, const Index3& corner, SurfaceValues<T>& values) const {
    const Box& box = part.box;
    reader_.read_strided({{box.lo.x + corner.x, box.lo.y + corner.y, box.lo.z + corner.z},
                          {box.hi.x + corner.x, box.hi.y + corner.y, box.hi.z + corner.z}},
                         level_, values.at(static_cast<int>(box.lo.x), static_cast<int>(box.lo.y),
                                           static_cast<int>(box.lo.z)),
                         SurfaceValues<T>::kRow, SurfaceValues<T>::kPlane);
  }

  void set_bits(const BrickPart& part, const Index3& corner, SurfaceValues<T>& values,
                SurfaceRows<SurfaceBits>& rows) const {
    if (part.share == InsideShare::none) return;
    const bool are_all = part.share == InsideShare::all;
    if (!are_all) read(part, corner, values);
    const auto begin = static_cast<int>(std::max<std::int64_t>(part.box.lo.x, 0));
    const int count = static_cast<int>(part.box.hi.x) - begin;
    const std::uint64_t ones = low_bits(count);
    for (auto z = static_cast<int>(part.box.lo.z); z < part.box.hi.z; ++z) {
      for (auto y = static_cast<int>(part.box.lo.y); y < part.box.hi.y; ++y) {
        SurfaceBits& row = rows.at(y, z);
        if (part.box.lo.x < 0) {
          row.before = are_all ? 1 : inside_.bits(values.at(-1, y, z), 1);
        }
        if (count == 0) continue;
        row.bits |= (are_all ? ones : inside_.bits(values.at(begin, y, z), count))
                    << begin;
      }
    }
  }

  /// Reads the values of parts that were decided without, where the surface passes beside them.
  void read_decided(const Index3& corner, const SurfaceBlock& block, BlockSpace<T>& space) const {
    for (const BrickPart& part : space.parts) {
      if (part.share == InsideShare::some) continue;
      if (is_cut_at(part, block.bits)) read(part, corner, space.values);
    }
  }

  /// Whether a voxel of a part, or one beside it in the block, lies on the other side.
  static bool is_cut_at(const BrickPart& part, const SurfaceRows<SurfaceBits>& rows) {
    const std::uint64_t expected = part.share == InsideShare::all ? ~std::uint64_t{0} : 0;
    const std::int64_t first = std::max<std::int64_t>(part.box.lo.x - 1, 0);
    const std::int64_t end = std::min<std::int64_t>(part.box.hi.x + 1, kSurfaceSide);
    const std::uint64_t columns = low_bits(end) & ~low_bits(first);
    const auto low = [](std::int64_t at) {
      return static_cast<int>(std::max<std::int64_t>(at - 1, -1));
    };
    const auto high = [](std::int64_t at) {
      return static_cast<int>(std::min<std::int64_t>(at + 1, kSurfaceSide));
    };
    for (int z = low(part.box.lo.z); z < high(part.box.hi.z); ++z) {
      for (int y = low(part.box.lo.y); y < high(part.box.hi.y); ++y) {
        const SurfaceBits& row = rows.at(y, z);
        if (((row.bits ^ expected) & columns) != 0) return true;
        if (part.box.lo.x <= 0 && row.before != (expected & 1)) return true;
      }
    }
    return false;
  }

  const FileReader& reader_;
  int level_;
  const SurfaceField& field_;
  InsideTest<T> inside_;
  SurfaceFrame frame_;
  Size3 brick_side_;
};

/// The blocks of one layer, [y][x]; those that are not cut are null.
using BlockLayer = std::vector<std::unique_ptr<SurfaceBlock>>;

template <class T>
class Extraction {
 public:
  Extraction(const FileReader& reader, int level, const SurfaceField& field, SurfaceSink& sink,
             Progress& progress)
      : maker_(reader, level, field), sink_(sink), progress_(progress) {
    // One block more than the voxels fill: edges end at the voxel outside.
    const Size3& size = maker_.frame().size();
    grid_ = {size.x / kSurfaceSide + 1, size.y / kSurfaceSide + 1, size.z / kSurfaceSide + 1};
  }

  void run() {
    BlockLayer before(layer_blocks());
    for (std::int64_t z = 0; z < grid_.z; ++z) {
      BlockLayer layer = make_layer(z);
      number(layer);
      join(before, layer);
      sink_.finish_layer();
      before = std::move(layer);
      for (const auto& block : before) {
        if (block) std::vector<MeshPoint>().swap(block->points);
      }
      const std::int64_t planes = maker_.frame().size().z - z * kSurfaceSide;
      progress_.advance(std::clamp<std::int64_t>(planes, 0, kSurfaceSide));
    }
  }

 private:
  static constexpr std::size_t kFetchedBlocks = 128;

  std::size_t layer_blocks() const { return static_cast<std::size_t>(grid_.x * grid_.y); }

  template <class Work>
  void for_each_block(std::size_t first, std::size_t end, Work work) {
    tbb::parallel_for(first, end, [&](std::size_t i) {
      if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const auto at = static_cast<std::int64_t>(i);
      work(i, at % grid_.x, at / grid_.x);
    });
  }

  /// Blocks overlap in the bricks that they read. So that no two threads decode the same one, those
  /// of some blocks are all fetched before these are made.
  BlockLayer make_layer(std::int64_t z) {
    BlockLayer layer(layer_blocks());
    for (std::size_t first = 0; first < layer.size(); first += kFetchedBlocks) {
      const std::size_t end = std::min(first + kFetchedBlocks, layer.size());
      if (tbb::this_task_arena::max_concurrency() > 1) {
        for_each_block(first, end, [&](std::size_t, std::int64_t x, std::int64_t y) {
          maker_.fetch({x, y, z}, spaces_.local());
        });
      }
      for_each_block(first, end, [&](std::size_t i, std::int64_t x, std::int64_t y) {
        layer[i] = maker_.make({x, y, z}, spaces_.local());
      });
    }
    return layer;
  }

  /// Gives the points of a layer their numbers, and hands them out.
  void number(const BlockLayer& layer) {
    for (const auto& block : layer) {
      if (!block) continue;
      constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
      if (point_count_ + block->points.size() > kMost) {
        throw Error(ErrorKind::limit_exceeded,
                    "the surface has more than " + std::to_string(kMost) +
                        " points")
            .with_field("level");
      }
      block->first_point = static_cast<std::uint32_t>(point_count_);
      point_count_ += block->points.size();
      sink_.add_points(block->points);
    }
  }

  void join(const BlockLayer& before, const BlockLayer& layer) {
    std::vector<std::vector<MeshTriangle>> triangles(layer.size());
    const bool is_mirrored = maker_.frame().is_mirrored();
    for_each_block(0, layer.size(), [&](std::size_t i, std::int64_t x, std::int64_t y) {
      if (!layer[i]) return;
      BlocksBefore blocks{};
      for (std::size_t dz = 0; dz < 2; ++dz) {
        for (std::size_t dy = 0; dy < 2; ++dy) {
          for (std::size_t dx = 0; dx < 2; ++dx) {
            if ((dx == 1 && x == 0) || (dy == 1 && y == 0)) continue;
            const std::size_t at = i - dx - dy * static_cast<std::size_t>(grid_.x);
            blocks[dz][dy][dx] = (dz == 0 ? layer : before)[at].get();
          }
        }
      }
      MeshRoom<MeshTriangle>& room = rooms_.local();
      room.clear();
      join_triangles(blocks, is_mirrored, room);
      triangles[i].assign(room.all().begin(), room.all().end());
    });
    for (const auto& some : triangles) {
      if (!some.empty()) sink_.add_triangles(some);
    }
  }

  BlockMaker<T> maker_;
  SurfaceSink& sink_;
  Progress& progress_;
  Size3 grid_;  // of blocks
  std::uint64_t point_count_ = 0;
  tbb::enumerable_thread_specific<BlockSpace<T>> spaces_;
  tbb::enumerable_thread_specific<MeshRoom<MeshTriangle>> rooms_;
};

}  // namespace

void MeshCollector::add_points(std::span<const MeshPoint> points) {
  mesh_.points.insert(mesh_.points.end(), points.begin(), points.end());
}

void MeshCollector::add_triangles(std::span<const MeshTriangle> triangles) {
  mesh_.triangles.insert(mesh_.triangles.end(), triangles.begin(), triangles.end());
}

void MeshCollector::finish_layer() {
  require_memory_within(mesh_.memory_bytes(), max_bytes_, "the surface",
                        "raise the limit, or take a coarser level");
}

void extract_surface(const FileReader& reader, int level, const SurfaceField& field,
                     SurfaceSink& sink, Progress& progress) {
  if (level < 0 || level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  with_voxel_type(reader.description().type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    Extraction<T>(reader, level, field, sink, progress).run();
  });
}

}  // namespace octavo
