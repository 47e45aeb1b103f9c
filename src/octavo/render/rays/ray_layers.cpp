#include "octavo/render/rays/ray_layers.h"

#include <algorithm>

namespace octavo {

namespace {

/// Rays stop a step behind the first layer that hides all: where they hit is found between samples.
constexpr float kBehindOpaque = 1;
constexpr float kOpaqueLayer = 0.999f;

float layer_channel(std::uint32_t color, int bits) {
  return static_cast<float>(color >> bits & 255) * (1 / 255.0f);
}

void add_layer(RayTile& tile, std::size_t ray, const RayLayer& layer) {
  const float weight = layer.opacity * (1 - tile.gathered[ray]);
  tile.red[ray] += weight * layer_channel(layer.color, 0);
  tile.green[ray] += weight * layer_channel(layer.color, 8);
  tile.blue[ray] += weight * layer_channel(layer.color, 16);
  tile.gathered[ray] += weight;
}

/// The rays of a tile from layer to layer.
class LayerFollower {
 public:
  LayerFollower(const RayFrame& frame, RayTile& tile, const TileLayers& layers, RayStops& stops)
      : frame_(frame), tile_(tile), layers_(layers), stops_(stops) {}

  void start() {
    stops_.from.fill(-kRayDone);
    for (std::size_t ray = 0; ray < kTileRays; ++ray) {
      stops_.next[ray] = layers_.begins[ray];
      set_stop(ray);
    }
    stops_.has_started = true;
  }

  /// Layers that rays have come to; true where one has to go on.
  bool pass_layers() {
    bool goes_on = false;
    for (std::size_t ray = 0; ray < kTileRays; ++ray) {
      if (tile_.waits_for[ray] < 0 && pass(ray)) goes_on = true;
    }
    return goes_on;
  }

  /// Iso: what lies behind a layer that hides all is not seen.
  void stop_at_opaque() {
    stops_.from.fill(-kRayDone);
    for (std::size_t ray = 0; ray < kTileRays; ++ray) {
      const std::uint32_t end = layers_.begins[ray + 1];
      std::uint32_t at = layers_.begins[ray];
      while (at < end && layers_.layers[at].opacity < kOpaqueLayer) ++at;
      stops_.stop[ray] = at < end ? layers_.layers[at].k + kBehindOpaque : kRayDone;
    }
    stops_.has_started = true;
  }

  void end_stopped() {
    for (std::size_t ray = 0; ray < kTileRays; ++ray) {
      if (tile_.waits_for[ray] < 0) tile_.k[ray] = kRayDone;
    }
  }

 private:
  void set_stop(std::size_t ray) {
    const bool has_layer = stops_.next[ray] < layers_.begins[ray + 1];
    stops_.stop[ray] = has_layer ? layers_.layers[stops_.next[ray]].k : kRayDone;
  }

  bool pass(std::size_t ray) {
    std::uint32_t& next = stops_.next[ray];
    const std::uint32_t end = layers_.begins[ray + 1];
    const bool is_done = tile_.k[ray] >= kRayDone;
    if (next == end) return false;
    // Rays go on in the next region, which may lie before the layer.
    if (is_done && !frame_.is_last_region) return false;
    const float here = stops_.stop[ray];
    while (next < end && (is_done || layers_.layers[next].k <= here) &&
           tile_.gathered[ray] < frame_.enough) {
      add_layer(tile_, ray, layers_.layers[next++]);
    }
    stops_.from[ray] = here;
    if (tile_.gathered[ray] >= frame_.enough) {
      next = end;
      tile_.k[ray] = kRayDone;
    }
    set_stop(ray);
    return tile_.k[ray] < kRayDone;
  }

  const RayFrame& frame_;
  RayTile& tile_;
  const TileLayers& layers_;
  RayStops& stops_;
};

}  // namespace

std::array<double, 3> seen_through(const TileLayers& layers, std::size_t ray, double k,
                                   const std::array<double, 3>& behind) {
  std::array<double, 3> seen{};
  double left = 1;
  if (!layers.is_empty()) {
    for (std::uint32_t i = layers.begins[ray]; i < layers.begins[ray + 1]; ++i) {
      const RayLayer& layer = layers.layers[i];
      if (layer.k >= k) break;
      for (std::size_t c = 0; c < 3; ++c) {
        seen[c] += left * layer.opacity * layer_channel(layer.color, static_cast<int>(8 * c));
      }
      left *= 1 - layer.opacity;
    }
  }
  for (std::size_t c = 0; c < 3; ++c) seen[c] += left * behind[c];
  return seen;
}

std::int64_t follow_through_layers(const RayFrame& frame, RayTile& tile, const TileLayers& layers,
                                   RayStops& stops, FollowRays follow) {
  const bool has_depth = frame.mode == RayMode::volume || frame.mode == RayMode::iso;
  if (layers.is_empty() || !has_depth) return follow(frame, tile);
  LayerFollower through(frame, tile, layers, stops);
  tile.stops = &stops;
  std::int64_t taken = 0;
  if (frame.mode == RayMode::iso) {
    if (!stops.has_started) through.stop_at_opaque();
    taken = follow(frame, tile);
    through.end_stopped();
  } else {
    if (!stops.has_started) through.start();
    do {
      taken += follow(frame, tile);
    } while (through.pass_layers());
  }
  tile.stops = nullptr;
  return taken;
}

}  // namespace octavo
