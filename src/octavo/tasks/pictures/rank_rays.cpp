#include "octavo/tasks/pictures/rank_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/tasks/pictures/rank_layers.h"

namespace octavo {

namespace {

/// What a tile of one run of nodes has gathered; as ranks send it.
struct SentTile {
  std::uint64_t run = 0;   // its place in the order
  std::uint64_t tile = 0;  // of the picture
  std::array<float, kTileRays> red;
  std::array<float, kTileRays> green;
  std::array<float, kTileRays> blue;
  std::array<float, kTileRays> gathered;
};

bool is_anything_gathered(const RayTile& tile, RayMode mode) {
  return std::any_of(tile.gathered.begin(), tile.gathered.end(), [&](float gathered) {
    return mode == RayMode::extreme ? std::isfinite(gathered) : gathered > 0;
  });
}

SentTile sent_tile(const RayTile& tile, std::size_t run, std::size_t number) {
  return {run, number, tile.red, tile.green, tile.blue, tile.gathered};
}

/// What share of what lies behind is seen. One machine would have ended the ray somewhere between
/// what is enough and all: this ends it in the middle.
float share_behind(float gathered, float behind, const RayFrame& frame) {
  if (gathered >= frame.enough) return 0;
  if (gathered <= 0) return 1;
  const float share = 1 - gathered;
  const float most = 0.5f * (1 + frame.enough) - gathered;
  return share * behind > most ? most / behind : share;
}

/// What lies behind what a tile has gathered already.
void composite_behind(const SentTile& behind, const RayFrame& frame, RayTile& tile) {
  for (std::size_t i = 0; i < kTileRays; ++i) {
    float& gathered = tile.gathered[i];
    if (frame.mode == RayMode::extreme) {
      gathered = std::max(gathered, behind.gathered[i]);
      continue;
    }
    float share = 1;
    if (frame.mode == RayMode::volume) share = share_behind(gathered, behind.gathered[i], frame);
    if (frame.mode == RayMode::iso) share = gathered > 0 ? 0 : 1;
    tile.red[i] += share * behind.red[i];
    tile.green[i] += share * behind.green[i];
    tile.blue[i] += share * behind.blue[i];
    gathered += share * behind.gathered[i];
  }
}

void append_tile(Bytes& out, const SentTile& tile) {
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(&tile);
  out.insert(out.end(), bytes, bytes + sizeof tile);
}

std::vector<SentTile> tiles_of(ByteSpan bytes) {
  if (bytes.size() % sizeof(SentTile) != 0) {
    throw Error(ErrorKind::io, "a rank sent a part of a tile");
  }
  std::vector<SentTile> tiles(bytes.size() / sizeof(SentTile));
  if (!tiles.empty()) std::memcpy(tiles.data(), bytes.data(), bytes.size());
  return tiles;
}

/// All runs, in the order in which rays come to them.
std::vector<NodeRun> runs_in_order(const RayFrame& frame, int rank_count) {
  const BrickTables& tables = frame.bricks;
  const Size3 grid{tables.grid[0], tables.grid[1], tables.grid[2]};
  std::vector<bool> is_seen(static_cast<std::size_t>(grid.voxel_count()));
  for (std::size_t i = 0; i < is_seen.size(); ++i) {
    is_seen[i] = frame.mode == RayMode::extreme || tables.brick_bounds[i] > 0;
  }
  const std::int64_t side = std::int64_t{1} << tables.shift;
  std::vector<NodeRun> runs;
  for (const OctreeNode& node :
       nodes_in_order(share_octree(grid, is_seen, rank_count), frame, side)) {
    if (runs.empty() || runs.back().rank != node.rank) runs.push_back({node.rank, {}});
    runs.back().nodes.push_back(node);
  }
  return runs;
}

std::vector<RayRegion> regions_of(const NodeRun& run, const RankPicture& picture) {
  const std::int64_t side = std::int64_t{1} << picture.frame.bricks.shift;
  std::vector<RayRegion> inside;
  for (const OctreeNode& node : run.nodes) {
    for (const RayRegion& region : regions_in(node, picture.regions, side)) {
      inside.push_back(region);
    }
  }
  return inside;
}

/// The layers of one run after the other in a list of all tiles.
class TilesOfRun {
 public:
  TilesOfRun(RunLayers& layers, std::int64_t width, std::int64_t height) : layers_(layers) {
    if (layers.empty()) return;
    all_.resize(static_cast<std::size_t>(tiles_along(width) * tiles_along(height)));
  }

  /// Takes them out of the run, until the next call; none where it has no layers.
  const TileLayers* take(std::size_t run) {
    for (const std::size_t tile : filled_) all_[tile] = {};
    filled_.clear();
    const auto found = layers_.find(run);
    if (found == layers_.end()) return nullptr;
    RunTiles tiles = std::move(found->second);
    layers_.erase(found);
    for (std::size_t i = 0; i < tiles.numbers.size(); ++i) {
      all_.at(tiles.numbers[i]) = std::move(tiles.layers[i]);
    }
    filled_ = std::move(tiles.numbers);
    return all_.data();
  }

  /// The list after the last call of `take`.
  std::vector<TileLayers> all() { return std::move(all_); }

 private:
  RunLayers& layers_;
  std::vector<TileLayers> all_;
  std::vector<std::size_t> filled_;
};

void start_field(RayField& field, std::int64_t width, std::int64_t height, RayMode mode) {
  field.width = width;
  field.height = height;
  field.tiles.resize(ray_field_bytes(width, height) / sizeof(RayTile));
  if (mode != RayMode::extreme) return;
  for (RayTile& tile : field.tiles) {
    tile.gathered.fill(-std::numeric_limits<float>::infinity());
  }
}

}  // namespace

RayField cast_by_ranks(RayBricks& bricks, const RayFrame& frame,
                       std::span<const RayRegion> regions, std::int64_t width,
                       std::int64_t height, Communicator& ranks, const TaskContext& context) {
  // Whose nodes lie where, and the layers of meshes in them.
  const RankPicture picture{frame, regions, width, height};
  const std::vector<NodeRun> runs = runs_in_order(frame, ranks.size());
  RunLayers layers;
  if (frame.meshes) layers = layers_of_runs(picture, runs, ranks, context.watcher());
  TilesOfRun tiles_of_run(layers, width, height);
  const bool has_depth = frame.mode == RayMode::volume;

  // Own nodes, and what each rank is to composite of them.
  const auto count = static_cast<std::size_t>(ranks.size());
  const std::int64_t loaded_before = bricks.loaded_count();
  std::vector<Bytes> outgoing(count);
  RayField result;
  for (std::size_t run = 0; run < runs.size(); ++run) {
    if (runs[run].rank != ranks.rank()) continue;
    RayFrame of_run = frame;
    of_run.meshes = nullptr;
    if (has_depth) of_run.layers = tiles_of_run.take(run);
    const std::vector<RayRegion> inside = regions_of(runs[run], picture);
    if (inside.empty() && of_run.layers == nullptr) continue;
    const RayField field = cast_rays(bricks, of_run, inside, width, height,
                                     follow_rays_function(), context.watcher());
    for (std::size_t i = 0; i < field.tiles.size(); ++i) {
      if (!is_anything_gathered(field.tiles[i], frame.mode)) continue;
      append_tile(outgoing[i % count], sent_tile(field.tiles[i], run, i));
    }
    result.samples += field.samples;
    result.cast_seconds += field.cast_seconds;
  }
  const auto loaded = static_cast<std::uint64_t>(bricks.loaded_count() - loaded_before);
  const std::uint64_t done[] = {static_cast<std::uint64_t>(result.samples), loaded};
  const RankSums sums = ranks.sum_before(done);

  // Tiles in order.
  std::vector<SentTile> tiles;
  for (const Bytes& bytes : ranks.exchange(std::move(outgoing))) {
    for (const SentTile& tile : tiles_of(bytes)) tiles.push_back(tile);
  }
  std::sort(tiles.begin(), tiles.end(), [](const SentTile& a, const SentTile& b) {
    return a.tile != b.tile ? a.tile < b.tile : a.run < b.run;
  });
  RayField composed;
  start_field(composed, width, height, frame.mode);
  Bytes finished;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    RayTile& tile = composed.tiles.at(tiles[i].tile);
    composite_behind(tiles[i], frame, tile);
    const bool is_last = i + 1 == tiles.size() || tiles[i + 1].tile != tiles[i].tile;
    if (is_last) append_tile(finished, sent_tile(tile, 0, tiles[i].tile));
  }

  // The picture.
  const std::vector<Bytes> all = ranks.collect(finished);
  result.width = width;
  result.height = height;
  if (!ranks.is_first()) return result;
  start_field(result, width, height, frame.mode);
  if (!has_depth && tiles_of_run.take(0) != nullptr) result.layers = tiles_of_run.all();
  for (const Bytes& bytes : all) {
    for (const SentTile& tile : tiles_of(bytes)) {
      composite_behind(tile, frame, result.tiles.at(tile.tile));
    }
  }
  result.samples = static_cast<std::int64_t>(sums.all[0]);
  result.loaded_elsewhere = static_cast<std::int64_t>(sums.all[1] - loaded);
  return result;
}

}  // namespace octavo
