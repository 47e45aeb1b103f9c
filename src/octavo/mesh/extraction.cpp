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
#include "octavo/mesh/block_maker.h"

namespace octavo {

namespace {

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
