#include "octavo/tasks/pictures/rank_layers.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/render/rays/layer_bricks.h"
#include "octavo/render/rays/ray_caster.h"

namespace octavo {

namespace {

/// A layer, as ranks send it.
struct SentLayer {
  std::uint32_t run = 0;
  std::uint32_t tile = 0;  // of the picture
  std::uint32_t ray = 0;   // of the tile
  RayLayer layer;
};

/// The run of each brick, x fastest.
std::vector<std::uint32_t> runs_of_bricks(const std::vector<NodeRun>& runs,
                                          const BrickTables& tables) {
  const Size3 grid{tables.grid[0], tables.grid[1], tables.grid[2]};
  std::vector<std::uint32_t> of_bricks(static_cast<std::size_t>(grid.voxel_count()));
  for (std::size_t run = 0; run < runs.size(); ++run) {
    for (const OctreeNode& node : runs[run].nodes) {
      const Box bricks{node.lo, {node.lo.x + node.side, node.lo.y + node.side,
                                 node.lo.z + node.side}};
      visit_cells(intersection(bricks, box_of(grid)), {1, 1, 1}, [&](const Index3& at) {
        of_bricks[static_cast<std::size_t>((at.z * grid.y + at.y) * grid.x + at.x)] =
            static_cast<std::uint32_t>(run);
        return true;
      });
    }
  }
  return of_bricks;
}

/// What the layers of this rank's tiles are to each rank.
std::vector<Bytes> sorted_layers(const RankPicture& picture, const std::vector<NodeRun>& runs,
                                 const Communicator& ranks, const Progress& watcher) {
  const auto count = static_cast<std::size_t>(ranks.size());
  const TileShare share{static_cast<std::size_t>(ranks.rank()), count};
  const std::vector<TileLayers> tiles = picture.frame.meshes->layers(
      picture.frame, picture.width, picture.height, watcher, share);
  const bool has_depth = picture.frame.mode == RayMode::volume;
  const LayerBricks bricks(picture.frame, picture.regions);
  const std::vector<std::uint32_t> of_bricks = runs_of_bricks(runs, picture.frame.bricks);
  std::vector<Bytes> outgoing(count);
  for (std::size_t tile = share.first; tile < tiles.size(); tile += count) {
    const TileLayers& layers = tiles[tile];
    if (layers.is_empty()) continue;
    std::vector<std::int32_t> taken_in(layers.layers.size());
    if (has_depth) {
      taken_in = bricks.of_tile(layers, first_pixel_of(tile, picture.width, picture.height));
    }
    for (std::uint32_t ray = 0; ray < kTileRays; ++ray) {
      for (std::uint32_t i = layers.begins[ray]; i < layers.begins[ray + 1]; ++i) {
        const std::uint32_t run =
            has_depth ? of_bricks[static_cast<std::size_t>(taken_in[i])] : 0;
        const SentLayer sent{run, static_cast<std::uint32_t>(tile), ray, layers.layers[i]};
        const auto* const bytes = reinterpret_cast<const std::uint8_t*>(&sent);
        Bytes& out = outgoing[has_depth ? static_cast<std::size_t>(runs[run].rank) : 0];
        out.insert(out.end(), bytes, bytes + sizeof sent);
      }
    }
  }
  return outgoing;
}

/// Adds the layer behind those of its ray that are there. Rays come in order.
void append_layer(const SentLayer& sent, TileLayers& tile) {
  const auto count = static_cast<std::uint32_t>(tile.layers.size());
  while (tile.begins.size() <= sent.ray) tile.begins.push_back(count);
  tile.layers.push_back(sent.layer);
}

}  // namespace

RunLayers layers_of_runs(const RankPicture& picture, const std::vector<NodeRun>& runs,
                         Communicator& ranks, const Progress& watcher) {
  RunLayers own;
  for (const Bytes& bytes : ranks.exchange(sorted_layers(picture, runs, ranks, watcher))) {
    if (bytes.size() % sizeof(SentLayer) != 0) {
      throw Error(ErrorKind::io, "a rank sent a part of a layer");
    }
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(SentLayer)) {
      SentLayer sent;
      std::memcpy(&sent, bytes.data() + at, sizeof sent);
      // A rank sends tile by tile, and no other has the same tiles.
      RunTiles& tiles = own[sent.run];
      if (tiles.numbers.empty() || tiles.numbers.back() != sent.tile) {
        tiles.numbers.push_back(sent.tile);
        tiles.layers.emplace_back();
      }
      append_layer(sent, tiles.layers.back());
    }
  }
  for (auto& [run, tiles] : own) {
    for (TileLayers& tile : tiles.layers) {
      tile.begins.resize(kTileRays + 1, static_cast<std::uint32_t>(tile.layers.size()));
    }
  }
  return own;
}

}  // namespace octavo
