// Small volumes for rays, and one way to cast them.
#pragma once

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "octavo/render/rays/dense_samples.h"
#include "octavo/render/rays/ray_camera.h"
#include "octavo/render/rays/ray_caster.h"
#include "octavo/render/rays/ray_meshes.h"
#include "octavo/render/rays/ray_picture.h"
#include "octavo/render/rays/ray_regions.h"
#include "octavo/render/rays/transfer_function.h"

namespace octavo::testing {

template <class T>
struct RayVolume {
  Size3 size;
  Geometry geometry;
  std::vector<T> samples;

  T at(const Index3& p) const {
    return samples[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)];
  }
};

/// The values of value_of(x, y, z).
template <class T, class F>
RayVolume<T> ray_volume(const Size3& size, F&& value_of) {
  RayVolume<T> volume{size, {}, {}};
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        volume.samples.push_back(static_cast<T>(value_of(x, y, z)));
      }
    }
  }
  return volume;
}

/// Noise in a ball, as a scan has it, nothing around it.
inline RayVolume<std::int16_t> noisy_ball(std::int64_t side) {
  return ray_volume<std::int16_t>({side, side, side}, [&](auto x, auto y, auto z) {
    const double middle = 0.5 * static_cast<double>(side - 1);
    const double r = std::hypot(static_cast<double>(x) - middle, static_cast<double>(y) - middle,
                                static_cast<double>(z) - middle);
    const auto noise = static_cast<double>((x * 73 + y * 151 + z * 283) * 2654435761 >> 7 & 127);
    return r < 0.4 * static_cast<double>(side) ? 300 + noise : noise - 64;
  });
}

struct RaySetup {
  RayMode mode = RayMode::volume;
  TransferFunction transfer = {{{150, {255, 255, 255}, 0}, {400, {200, 150, 100}, 0.3}}, {}, false};
  double isovalue = 225.5;
  float sign = 1;
  bool skips = true;
  float enough = 0.995f;
  float gradient_begin = 0;
  float gradient_rise = 0;
  bool has_cell_gradients = false;
  int brick_shift = 6;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  int threads = 2;
  FollowRays follow = follow_rays_function();
  Viewpoint viewpoint = viewpoint_at(30, 20);
  ViewFrame frame = {96, 80, 1, {}};
  double angle_degrees = 0;
  std::optional<Box> shown;
  std::vector<Box> removed;
  std::vector<RayMesh> meshes;
  std::vector<RayRegion> regions;  ///< in place of `shown`, in any order
  bool keeps_order = false;        ///< of regions
  const TileLayers* layers = nullptr;  ///< in place of those of meshes; then regions may be none
  ShadeTable shade;
  const LookSource* looks = nullptr;
  LookTable look_table;
  std::vector<TransferFunction> look_functions;  ///< besides `transfer`
};

struct CastScene {
  RayField field;
  RayFrame frame;
  View view;
  PooledScale scale;
  std::int64_t loaded = 0;
};

template <class T>
CastScene cast_scene(const RayVolume<T>& volume, const RaySetup& setup) {
  const DenseSamples source(volume.samples.data(), voxel_type_of<T>(), volume.size, 32);
  RayBricks bricks(source, {setup.brick_shift, setup.memory_bytes, setup.looks});
  CastScene scene;
  scene.scale = bricks.scale();
  const Box shown = setup.shown.value_or(box_of(volume.size));
  scene.view = make_view(volume.geometry, volume.size, shown, setup.viewpoint, setup.frame);
  const Point3& spacing = volume.geometry.spacing_mm;
  const double step_mm = std::min({spacing[0], spacing[1], spacing[2]});
  RayFrame& frame = scene.frame;
  frame.mode = setup.mode;
  frame.bricks = bricks.tables();
  frame.sign = setup.sign;
  frame.enough = setup.enough;
  frame.has_cell_gradients = setup.has_cell_gradients;
  frame.isovalue = static_cast<float>(scene.scale.pooled(setup.isovalue)) * setup.sign;
  set_camera(frame, {scene.view, shown, setup.angle_degrees, step_mm, setup.frame.zoom});
  std::vector<SteppedTransfer> transfers = {{setup.transfer, 1}};
  for (const TransferFunction& transfer : setup.look_functions) transfers.push_back({transfer, 1});
  const TransferTable table(transfers, {}, bricks.scale(), bricks.range());
  frame.table = table.table();
  frame.looks = setup.look_table;
  frame.shade = setup.shade;
  frame.table.gradient_begin = setup.gradient_begin;
  frame.table.gradient_rise = setup.gradient_rise;
  bricks.set_bounds([&](float lowest, float highest, LookSet looks) {
    const float sign = setup.sign;
    const float most = sign > 0 ? highest : -lowest;
    if (!setup.skips || setup.mode == RayMode::mean) return std::numeric_limits<float>::max();
    if (looks == 0) return -std::numeric_limits<float>::infinity();
    if (setup.mode == RayMode::extreme) return most;
    if (setup.mode == RayMode::iso) return most >= frame.isovalue ? 1.0f : 0.0f;
    for (std::size_t i = 0; i < transfers.size(); ++i) {
      if ((looks >> i & 1) != 0 && table.is_seen(lowest, highest, i)) return 1.0f;
    }
    return 0.0f;
  });
  const KeptVoxels kept(shown, setup.removed, volume.size);
  frame.cuts = kept.cuts();
  const RayMeshes meshes(setup.meshes, {volume.geometry, scene.view, setup.memory_bytes});
  if (!setup.meshes.empty()) frame.meshes = &meshes;
  frame.layers = setup.layers;
  NoProgress silent;
  tbb::task_arena arena(setup.threads);
  arena.execute([&] {
    std::vector<RayRegion> regions = setup.regions;
    if (regions.empty() && setup.layers == nullptr) {
      for (const Box& box : without_boxes(shown, setup.removed)) regions.push_back(region_of(box));
    }
    if (!setup.keeps_order) regions = front_to_back(regions, frame);
    scene.field = cast_rays(bricks, frame, regions, scene.view.width, scene.view.height,
                            setup.follow, silent);
  });
  scene.loaded = bricks.loaded_count();
  return scene;
}

/// What all rays gathered, bit for bit.
inline std::vector<float> gathered(const RayField& field) {
  std::vector<float> all;
  for (const RayTile& tile : field.tiles) {
    all.insert(all.end(), tile.red.begin(), tile.red.end());
    all.insert(all.end(), tile.green.begin(), tile.green.end());
    all.insert(all.end(), tile.blue.begin(), tile.blue.end());
    all.insert(all.end(), tile.gathered.begin(), tile.gathered.end());
  }
  return all;
}

/// Each set of instructions of this machine gathers the bits of `expected`. Rays that go together
/// take samples that some of them would skip, rays one by one none; those of colors and surfaces
/// leave others out where the samples around them show nothing.
template <class T>
void expect_levels_alike(const RayVolume<T>& volume, RaySetup setup, const CastScene& expected) {
  std::int64_t single_samples = 0;
  for (const char* level : {"scalar", "sse4", "avx2", "avx512", "neon"}) {
    const auto follow = follow_rays_function_of(level);
    if (!follow) continue;
    setup.follow = *follow;
    const CastScene scene = cast_scene(volume, setup);
    EXPECT_EQ(gathered(scene.field), gathered(expected.field))
        << level << ' ' << static_cast<int>(setup.mode) << ' ' << setup.angle_degrees;
    const bool has_ranges = setup.mode == RayMode::volume || setup.mode == RayMode::iso;
    if (!has_ranges) {
      EXPECT_GE(scene.field.samples, single_samples) << level;
    }
    if (setup.follow == follow_rays_portable) single_samples = scene.field.samples;
  }
}

/// Where a ray is after k steps, in samples.
inline Point3 place_of_hit(const CastScene& scene, std::int64_t column, std::int64_t row,
                           double k) {
  const RayFrame& f = scene.frame;
  const double u = static_cast<double>(column) + 0.5 - static_cast<double>(scene.view.width) / 2;
  const double v = static_cast<double>(row) + 0.5 - static_cast<double>(scene.view.height) / 2;
  Point3 place;
  for (std::size_t i = 0; i < 3; ++i) {
    place[i] = f.origin[i] + u * f.origin_across[i] + v * f.origin_down[i] + k * f.direction[i];
  }
  return place;
}

}  // namespace octavo::testing
