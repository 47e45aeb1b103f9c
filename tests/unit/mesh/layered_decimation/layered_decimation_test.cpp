#include "octavo/mesh/layered_decimation/layered_decimation.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/certificate.h"
#include "octavo/mesh/enclosed_volumes.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/mesh_pieces.h"
#include "octavo/mesh/triangle_tree.h"
#include "support/built_file.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using LongField = std::function<double(double x, double y, double z)>;

/// Surfaces that are longer than a layer of blocks, each in a window of its own.
class LongBodies : public ::testing::Test {
 protected:
  void build(const Size3& size, const Geometry& geometry, const LongField& value) {
    testing::Volume volume;
    volume.description.size = size;
    volume.description.type = VoxelType::int16;
    volume.description.geometry = geometry;
    std::vector<std::int16_t> voxels;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          const double own = value(static_cast<double>(x), static_cast<double>(y),
                                   static_cast<double>(z));
          voxels.push_back(static_cast<std::int16_t>(std::clamp(own * 100, -3000.0, 3000.0)));
        }
      }
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
    volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(std::int16_t));
    path_ = folder_.file(std::to_string(++built_) + ".8vo");
    testing::build_volume(volume, path_, 1);
    options_ = {.geometry = geometry, .plane_count = size.z, .window_triangles = 1};
  }

  void extract(SurfaceSink& sink) {
    const auto reader = testing::open_file(path_);
    extract_surface(*reader, 0, SurfaceField::of_grey(0, false, VoxelType::int16), sink,
                    progress_);
  }

  TriangleMesh full() {
    MeshCollector collector;
    extract(collector);
    return collector.take();
  }

  LayeredSurface layered(double deviation_mm) {
    options_.max_deviation_mm = deviation_mm;
    LayeredDecimation decimation(options_, progress_);
    extract(decimation);
    return decimation.take();
  }

  /// Proves the surface of windows by what the full surface is, and that it has hardly more
  /// triangles than one that is reduced as a whole.
  void check(double deviation_mm, double most_triangles) {
    const TriangleMesh whole = full();
    const LayeredSurface surface = layered(deviation_mm);
    ASSERT_TRUE(surface.is_reduced);
    EXPECT_FALSE(surface.is_turned);
    EXPECT_EQ(surface.full_triangle_count, whole.triangles.size());
    EXPECT_EQ(surface.crossing_triangles, 0u);
    const MeshCheck before = check_mesh(whole);
    const MeshCheck after = check_mesh(surface.mesh);
    EXPECT_TRUE(after.is_closed());
    EXPECT_TRUE(after.is_manifold());
    EXPECT_EQ(after.components, before.components);
    EXPECT_EQ(after.euler_number, before.euler_number);
    const TriangleTree tree(surface.mesh);
    const TriangleTree whole_tree(whole);
    EXPECT_TRUE(unproven_triangles(whole, tree, deviation_mm, progress_).empty());
    EXPECT_TRUE(unproven_triangles(surface.mesh, whole_tree, deviation_mm, progress_).empty());
    EXPECT_TRUE(crossing_triangles(tree, progress_).empty());
    const Decimated at_once = decimate(whole, {deviation_mm, options_.geometry}, progress_);
    EXPECT_LT(static_cast<double>(surface.mesh.triangles.size()),
              most_triangles * static_cast<double>(at_once.mesh.triangles.size()));
  }

  testing::ScratchFolder folder_;
  std::string path_;
  int built_ = 0;
  LayeredOptions options_;
  NoProgress progress_;
};

/// A bar with waves through all layers, a ball that a border cuts and one beside borders.
double waves(double x, double y, double z) {
  const double bar = 9 + 2 * std::sin(z / 7) * std::cos(x / 3) - std::hypot(x - 16, y - 18);
  const double cut = 10 - std::hypot(x - 40, y - 16, z - 64);
  const double beside = 8 - std::hypot(x - 40, y - 16, z - 100);
  return std::max({bar, cut, beside});
}

TEST_F(LongBodies, AreProvenAcrossWindows) {
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  build({56, 36, 200}, {{-30, 12, 90}, {0.7, 0.8, 1.1}, {c, 0, s, 0, 1, 0, -s, 0, c}}, waves);
  check(0.35, 1.05);
}

// Sheets along the border of two layers, as near to it as sheets can be on both sides.
TEST_F(LongBodies, DoNotCrossBeyondABorder) {
  build({60, 50, 140}, {}, [](double x, double y, double z) {
    if (x < 4 || y < 4 || x > 55 || y > 45) return -30.0;
    if (z == 63) return -0.2 - std::fmod(x * 7 + y * 3, 5.0) / 40;
    return (z > 58 && z < 69) || std::hypot(x - 30, y - 25) < 8 ? 30.0 : -30.0;
  });
  check(0.5, 1.1);
}

TEST_F(LongBodies, AreProvenWhereTheyAreNoise) {
  std::uint32_t state = 7;
  std::vector<double> noise(28 * 24 * 140);
  for (double& value : noise) {
    state = state * 1664525 + 1013904223;
    value = static_cast<double>(state >> 8) / (1 << 24) - 0.5;
  }
  build({28, 24, 140}, {}, [&](double x, double y, double z) {
    const auto at = static_cast<std::size_t>((z * 24 + y) * 28 + x);
    return 8 - std::hypot(x - 14, y - 12) + 5 * noise[at];
  });
  check(0.5, 1.05);
}

// Needles of a 128th of a voxel, which windows share: what they enclosed is summed up to the sign.
TEST_F(LongBodies, KeepTheirInsideWhereItIsThin) {
  build({42, 14, 140}, {}, [](double x, double y, double z) {
    const double bent = std::round(2 * std::sin(z / 5)) + 3;
    const double next = std::round(2 * std::sin((z + 1) / 5)) + 3;
    const double own = std::fmod(x, 7);
    const bool is_needle = std::fmod(y, 2) == 0 && z > 5 && z < 135 && y > 0 &&
                           own >= std::min(bent, next) && own <= std::max(bent, next);
    return is_needle ? 0.0 : -30.0;
  });
  const LayeredSurface surface = layered(0.5);
  const MeshPieces pieces = mesh_pieces(surface.mesh);
  const std::vector<double> volumes =
      volumes_of_groups(surface.mesh, pieces.count, [&](std::size_t i) {
        return pieces.of_point[surface.mesh.triangles[i][0]];
      });
  const bool is_any_turned =
      std::any_of(volumes.begin(), volumes.end(), [](double volume) { return volume <= 0; });
  EXPECT_EQ(pieces.count, 36u);
  EXPECT_FALSE(is_any_turned);
  EXPECT_FALSE(surface.is_turned);
}

TEST_F(LongBodies, DoNotDependOnThreads) {
  build({56, 36, 140}, {}, waves);
  const auto with = [&](int threads) {
    TriangleMesh mesh;
    tbb::task_arena(threads).execute([&] { mesh = layered(0.4).mesh; });
    return mesh;
  };
  EXPECT_EQ(with(1), with(5));
}

TEST_F(LongBodies, StayFullWithinOneWindow) {
  build({56, 36, 140}, {}, waves);
  options_.window_triangles = 1 << 20;
  const LayeredSurface surface = layered(0.4);
  EXPECT_FALSE(surface.is_reduced);
  EXPECT_EQ(surface.mesh, full());
}

TEST_F(LongBodies, HoldHardlyMoreThanAWindow) {
  build({56, 36, 600}, {}, waves);
  const std::uint64_t full_bytes = 600 * full().points.size();
  options_.max_bytes = full_bytes / 3;
  EXPECT_TRUE(layered(0.4).is_reduced);
  options_.max_bytes = full_bytes / 40;
  try {
    layered(0.4);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
}

TEST_F(LongBodies, HoldTheirLastWindowWithinTheLimit) {
  // A mushroom: the cap, in the last window, has nearly all points.
  build({100, 100, 126}, {}, [](double x, double y, double z) {
    return (z < 66 ? 4.0 : 40.0) - std::hypot(x - 50, y - 50);
  });
  const std::uint64_t points = full().points.size();
  options_.max_bytes = 1200 * points;
  EXPECT_TRUE(layered(0.4).is_reduced);
  options_.max_bytes = 300 * points;
  try {
    layered(0.4);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
}

TEST_F(LongBodies, EndWhenAsked) {
  build({56, 36, 140}, {}, waves);
  options_.max_deviation_mm = 0.4;
  testing::StoppingProgress stopping(0);
  LayeredDecimation decimation(options_, stopping);
  EXPECT_THROW(extract(decimation), Error);
}

}  // namespace
}  // namespace octavo
