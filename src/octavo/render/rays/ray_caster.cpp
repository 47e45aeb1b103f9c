#include "octavo/render/rays/ray_caster.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>

#include "octavo/core/error.h"
#include "octavo/render/rays/occupied_spans.h"
#include "octavo/render/rays/ray_camera.h"
#include "octavo/render/rays/ray_meshes.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

using RayClock = std::chrono::steady_clock;

double seconds_since(RayClock::time_point start) {
  return std::chrono::duration<double>(RayClock::now() - start).count();
}

bool is_in_picture(const RayField& field, std::size_t number, std::size_t ray) {
  const std::int64_t left = static_cast<std::int64_t>(number) % field.tile_columns() * kRayTileSide;
  const std::int64_t top = static_cast<std::int64_t>(number) / field.tile_columns() * kRayTileSide;
  return left + static_cast<std::int64_t>(kTileOrder.column[ray]) < field.width &&
         top + static_cast<std::int64_t>(kTileOrder.row[ray]) < field.height;
}

void start_tile(RayTile& tile, const RayFrame& frame, const RayField& field, std::size_t number) {
  const auto [u, v] = first_pixel_of(number, field.width, field.height);
  tile.u = u;
  tile.v = v;
  if (frame.mode == RayMode::extreme) {
    tile.gathered.fill(-std::numeric_limits<float>::infinity());
  }
}

bool is_chosen(const RayFrame& frame, std::size_t number, std::size_t ray) {
  return frame.chosen == nullptr || (frame.chosen[number] >> (ray / 16) & 1) != 0;
}

/// Whether all rays of a tile are in the picture, and cast.
bool is_whole(const RayFrame& frame, const RayField& field, std::size_t number) {
  return frame.chosen == nullptr && is_in_picture(field, number, kTileRays - 1);
}

/// Sets the rays that are not done to the begin of a region.
void enter_region(RayTile& tile, const RayFrame& frame, const RayField& field,
                  std::size_t number) {
  tile.waits_for.fill(-1);
  const float full = frame.mode == RayMode::volume ? frame.enough
                     : frame.mode == RayMode::iso  ? kSmallestStep
                                                   : kRayDone;
  for (std::size_t i = 0; i < kTileRays; ++i) {
    tile.k[i] = tile.gathered[i] >= full ? kRayDone : 0;
  }
  if (is_whole(frame, field, number)) return;
  for (std::size_t i = 0; i < kTileRays; ++i) {
    const bool is_cast = is_in_picture(field, number, i) && is_chosen(frame, number, i);
    if (!is_cast) tile.k[i] = kRayDone;
  }
}

/// Layers by tile of the picture, and the stops of the rays of each tile cast that has some.
struct LayeredTiles {
  const TileLayers* layers = nullptr;
  std::vector<std::unique_ptr<RayStops>> stops;
};

LayeredTiles make_stops(const RayField& field, const TileLayers* layers) {
  LayeredTiles tiles{layers, {}};
  tiles.stops.resize(field.tiles.size());
  if (layers == nullptr) return tiles;
  for (std::size_t i = 0; i < tiles.stops.size(); ++i) {
    if (!layers[field.number_of(i)].is_empty()) tiles.stops[i] = std::make_unique<RayStops>();
  }
  return tiles;
}

bool is_waiting(const RayTile& tile) {
  return std::any_of(tile.waits_for.begin(), tile.waits_for.end(),
                     [](std::int32_t brick) { return brick >= 0; });
}

/// The bricks that rays wait for, the nearest first, as many as fit.
std::vector<std::int32_t> awaited(const RayField& field, const RayFrame& frame,
                                  const RayBricks& bricks,
                                  const std::vector<std::size_t>& waiting) {
  std::vector<std::int32_t> all;
  for (const std::size_t number : waiting) {
    std::int32_t last = -1;
    for (const std::int32_t brick : field.tiles[number].waits_for) {
      if (brick >= 0 && brick != last) all.push_back(last = brick);
    }
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  std::stable_sort(all.begin(), all.end(), [&](std::int32_t a, std::int32_t b) {
    return brick_nearness(frame, bricks.place_of(a)) < brick_nearness(frame, bricks.place_of(b));
  });
  if (all.size() > bricks.capacity()) all.resize(bricks.capacity());
  return all;
}

struct RayFollowing {
  FollowRays follow;
  const Progress& watcher;
};

void cross_region(RayBricks& bricks, RayFrame& frame, RayField& field,
                  const LayeredTiles& layered, const OccupiedSpans* spans,
                  const RayFollowing& how) {
  const auto& stops = layered.stops;
  std::vector<std::size_t> waiting;
  for (std::size_t i = 0; i < field.tiles.size(); ++i) {
    const bool is_empty = spans != nullptr && !stops[i] && !spans->is_any_in(field.number_of(i));
    if (!is_empty) waiting.push_back(i);
  }
  bool has_entered = false;
  while (true) {
    // Follow.
    const RayClock::time_point began = RayClock::now();
    frame.bricks = bricks.tables();
    std::atomic<std::int64_t> samples = 0;
    parallel_for(std::size_t{0}, waiting.size(), [&](std::size_t i) {
      if (how.watcher.is_cancelled()) return;
      const std::size_t number = waiting[i];
      RayTile& tile = field.tiles[number];
      if (!has_entered) enter_region(tile, frame, field, field.number_of(number));
      if (stops[number]) {
        samples += follow_through_layers(frame, tile, layered.layers[field.number_of(number)],
                                         *stops[number], how.follow);
      } else {
        if (spans != nullptr) tile.spans = spans->of_tile(field.number_of(number));
        samples += how.follow(frame, tile);
        tile.spans = nullptr;
      }
    });
    has_entered = true;
    if (how.watcher.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    field.samples += samples;
    field.cast_seconds += seconds_since(began);

    // Load what is waited for.
    std::erase_if(waiting, [&](std::size_t i) { return !is_waiting(field.tiles[i]); });
    if (waiting.empty()) return;
    bricks.load(awaited(field, frame, bricks, waiting));
  }
}

/// Of rays that cross nothing else.
void pass_all_layers(const RayFrame& frame, RayField& field, const LayeredTiles& layered) {
  const auto stay = [](const RayFrame&, RayTile&) { return std::int64_t{0}; };
  for (std::size_t i = 0; i < field.tiles.size(); ++i) {
    if (!layered.stops[i]) continue;
    field.tiles[i].waits_for.fill(-1);
    field.tiles[i].k.fill(kRayDone);
    follow_through_layers(frame, field.tiles[i], layered.layers[field.number_of(i)],
                          *layered.stops[i], stay);
  }
}

}  // namespace

std::array<float, 2> first_pixel_of(std::size_t tile, std::int64_t width, std::int64_t height) {
  const auto along = [](std::int64_t tile_place, std::int64_t pixels) {
    return static_cast<float>(static_cast<double>(tile_place * kRayTileSide) + 0.5 -
                              static_cast<double>(pixels) / 2);
  };
  const auto number = static_cast<std::int64_t>(tile);
  return {along(number % tiles_along(width), width), along(number / tiles_along(width), height)};
}

std::uint64_t ray_field_bytes(std::int64_t width, std::int64_t height) {
  return static_cast<std::uint64_t>(tiles_along(width) * tiles_along(height)) * sizeof(RayTile);
}

RayField cast_rays(RayBricks& bricks, RayFrame frame, std::int64_t width, std::int64_t height,
                   FollowRays follow, const Progress& watcher) {
  const RayRegion whole{frame.low, frame.high, frame.low, frame.high};
  return cast_rays(bricks, frame, {&whole, 1}, width, height, follow, watcher);
}

RayField cast_rays(RayBricks& bricks, RayFrame frame, std::span<const RayRegion> regions,
                   std::int64_t width, std::int64_t height, FollowRays follow,
                   const Progress& watcher) {
  RayField field;
  field.width = width;
  field.height = height;
  const std::size_t tile_count = ray_field_bytes(width, height) / sizeof(RayTile);
  for (std::size_t i = 0; frame.chosen != nullptr && i < tile_count; ++i) {
    if (frame.chosen[i] != 0) field.numbers.push_back(i);
  }
  if (frame.chosen != nullptr && field.numbers.empty()) return field;
  field.tiles = RayTiles(KeptAllocator<RayTile>(bricks.field_pages()));
  field.tiles.resize(frame.chosen != nullptr ? field.numbers.size() : tile_count);
  for (std::size_t i = 0; i < field.tiles.size(); ++i) {
    start_tile(field.tiles[i], frame, field, field.number_of(i));
  }
  if (frame.meshes && !frame.layers) {
    field.layers = frame.meshes->layers(frame, width, height, watcher);
    frame.layers = field.layers.data();
  }
  const LayeredTiles layered = make_stops(field, frame.layers);
  std::optional<OccupiedSpans> spans;
  if (frame.mode == RayMode::volume || frame.mode == RayMode::iso) {
    frame.bricks = bricks.tables();
    spans.emplace(frame, width, height);
  }
  for (std::size_t i = 0; i < regions.size(); ++i) {
    frame.low = regions[i].low;
    frame.high = regions[i].high;
    frame.whole_low = regions[i].whole_low;
    frame.whole_high = regions[i].whole_high;
    frame.is_last_region = i + 1 == regions.size();
    cross_region(bricks, frame, field, layered, spans ? &*spans : nullptr, {follow, watcher});
  }
  if (regions.empty()) pass_all_layers(frame, field, layered);
  return field;
}

}  // namespace octavo
