// A grid of blocks taken a layer at a time: each block is made of the bricks that it reads, and
// joined to those before it, so that no more than two layers are in memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/error.h"
#include "octavo/core/progress.h"
#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/surface_block.h"
#include "octavo/threads/arena.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

/// Block  has points, and first_point: the number of the first of them among those of all blocks
/// Work   what is done with blocks; on any thread
///            void fetch(const Index3& place)                          decodes what make reads
///            std::unique_ptr<Block> make(const Index3& place)         null where nothing is in it
///            void join(std::size_t i, Block& block, const Before& before)   of the layer
///        on one thread, block after block and layer after layer
///            void number(Block& block)                                first_point is set
///            void finish(Layer& layer)                                all of it is joined
template <class Block>
class BlockLayers {
 public:
  /// The blocks of one layer, [y][x].
  using Layer = std::vector<std::unique_ptr<Block>>;
  /// [1][0][0] is the block before along z, [0][0][0] the block itself.
  using Before = std::array<std::array<std::array<const Block*, 2>, 2>, 2>;

  /// One block more than the voxels fill, along each axis: surfaces end outside.
  BlockLayers(const Size3& size, Progress& progress)
      : size_(size),
        grid_{size.x / kSurfaceSide + 1, size.y / kSurfaceSide + 1, size.z / kSurfaceSide + 1},
        progress_(progress) {}

  std::size_t layer_blocks() const { return static_cast<std::size_t>(grid_.x * grid_.y); }

  /// Uses the threads of the calling task arena.
  /// Throws  what `work` throws; Error{cancelled}; Error{limit_exceeded} for 2^32 points or more
  template <class Work>
  void visit(Work& work) {
    Layer before(layer_blocks());
    for (std::int64_t z = 0; z < grid_.z; ++z) {
      Layer layer = make_layer(z, work);
      number(layer, work);
      for_each_block(0, layer.size(), [&](std::size_t i, std::int64_t x, std::int64_t y) {
        if (layer[i]) work.join(i, *layer[i], blocks_before(layer, before, i, x, y));
      });
      work.finish(layer);
      before = std::move(layer);
      progress_.advance(std::clamp<std::int64_t>(size_.z - z * kSurfaceSide, 0, kSurfaceSide));
    }
  }

 private:
  static constexpr std::size_t kFetchedBlocks = 128;

  template <class Each>
  void for_each_block(std::size_t first, std::size_t end, Each each) const {
    parallel_for(first, end, [&](std::size_t i) {
      stop_if_cancelled(progress_);
      const auto at = static_cast<std::int64_t>(i);
      each(i, at % grid_.x, at / grid_.x);
    });
  }

  /// Blocks overlap in the bricks that they read. So that no two threads decode the same one, those
  /// of some blocks are all fetched before these are made.
  template <class Work>
  Layer make_layer(std::int64_t z, Work& work) const {
    Layer layer(layer_blocks());
    for (std::size_t first = 0; first < layer.size(); first += kFetchedBlocks) {
      const std::size_t end = std::min(first + kFetchedBlocks, layer.size());
      if (arena_threads() > 1) {
        for_each_block(first, end, [&](std::size_t, std::int64_t x, std::int64_t y) {
          work.fetch({x, y, z});
        });
      }
      for_each_block(first, end, [&](std::size_t i, std::int64_t x, std::int64_t y) {
        layer[i] = work.make({x, y, z});
      });
    }
    return layer;
  }

  template <class Work>
  void number(const Layer& layer, Work& work) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
    for (const auto& block : layer) {
      if (!block) continue;
      if (point_count_ + block->points.size() > kMost) {
        throw Error(ErrorKind::limit_exceeded,
                    "the surface has more than " + std::to_string(kMost) + " points")
            .with_field("level");
      }
      block->first_point = static_cast<std::uint32_t>(point_count_);
      point_count_ += block->points.size();
      work.number(*block);
    }
  }

  Before blocks_before(const Layer& layer, const Layer& before, std::size_t i, std::int64_t x,
                       std::int64_t y) const {
    Before blocks{};
    for (std::size_t dz = 0; dz < 2; ++dz) {
      for (std::size_t dy = 0; dy < 2; ++dy) {
        for (std::size_t dx = 0; dx < 2; ++dx) {
          if ((dx == 1 && x == 0) || (dy == 1 && y == 0)) continue;
          const std::size_t at = i - dx - dy * static_cast<std::size_t>(grid_.x);
          blocks[dz][dy][dx] = (dz == 0 ? layer : before)[at].get();
        }
      }
    }
    return blocks;
  }

  Size3 size_;  // in voxels
  Size3 grid_;  // of blocks
  Progress& progress_;
  std::uint64_t point_count_ = 0;
};

}  // namespace octavo
