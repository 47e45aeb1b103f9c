#include "octavo/mesh/octree_decimation/octree_decimation.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/certificate.h"
#include "octavo/mesh/memory_surface.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/triangle_tree.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

/// Surfaces of voxels that are not cubes, on a grid far from the origin.
class CellDecimations : public ::testing::Test {
 protected:
  using Value = std::function<double(double, double, double)>;

  TriangleMesh surface(const Size3& size, const Value& value) {
    std::vector<std::uint8_t> voxels;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          const double own = value(static_cast<double>(x), static_cast<double>(y),
                                   static_cast<double>(z));
          voxels.push_back(static_cast<std::uint8_t>(std::clamp(own, 0.0, 255.0)));
        }
      }
    }
    return surface_of({voxels.data(), VoxelType::uint8, size, geometry_},
                      SurfaceField::of_grey(128, false, VoxelType::uint8), progress_);
  }

  void expect_sound(const TriangleMesh& full, const TriangleMesh& mesh, double deviation) {
    const MeshCheck before = check_mesh(full);
    const MeshCheck after = check_mesh(mesh);
    EXPECT_TRUE(after.is_closed());
    EXPECT_TRUE(after.is_manifold());
    EXPECT_EQ(after.components, before.components);
    EXPECT_EQ(after.euler_number, before.euler_number);
    EXPECT_TRUE(crossing_triangles(TriangleTree(mesh), progress_).empty());
    EXPECT_TRUE(unproven_triangles(mesh, TriangleTree(full), deviation, progress_).empty());
    EXPECT_TRUE(unproven_triangles(full, TriangleTree(mesh), deviation, progress_).empty());
  }

  /// A ring, and a ball that the border cuts.
  static double bodies(double x, double y, double z) {
    const double ring = 4 - std::hypot(std::hypot(x - 34, y - 20) - 11, z - 14);
    const double ball = 11 - std::hypot(x - 2, y - 18, z - 12);
    return 128 + 20 * std::max(ring, ball);
  }

  NoProgress progress_;
  Geometry geometry_{{-500, 80, 1200}, {0.5, 0.75, 1}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
};

TEST_F(CellDecimations, KeepTheTopologyOfSmoothBodiesWithinTheDeviation) {
  const TriangleMesh full = surface({54, 40, 28}, bodies);
  const Decimated reduced = decimate_by_cells(full, {0.25, geometry_}, progress_);
  EXPECT_LT(5 * reduced.mesh.triangles.size(), full.triangles.size());
  EXPECT_EQ(reduced.crossing_triangles, 0u);
  EXPECT_EQ(check_mesh(full).components, 2u);
  expect_sound(full, reduced.mesh, 0.25);
}

TEST_F(CellDecimations, KeepTheTopologyOfNoise) {
  std::mt19937 random(3);
  for (const std::int64_t side : {6, 14}) {
    const TriangleMesh full = surface({side, side, side}, [&](double, double, double) {
      return static_cast<double>(random() % 256);
    });
    for (const double deviation : {0.1, 0.5, 5.0}) {
      const Decimated reduced = decimate_by_cells(full, {deviation, geometry_}, progress_);
      EXPECT_LT(reduced.mesh.triangles.size(), full.triangles.size());
      expect_sound(full, reduced.mesh, deviation);
    }
  }
}

TEST_F(CellDecimations, MergeFlatSidesFarMoreThanCurvedOnes) {
  const auto box = [](double x, double y, double z) {
    return x > 3 && x < 60 && y > 3 && y < 60 && z > 3 && z < 30 ? 255.0 : 0.0;
  };
  const TriangleMesh full = surface({64, 64, 34}, box);
  const Decimated reduced = decimate_by_cells(full, {0.25, geometry_}, progress_);
  EXPECT_LT(15 * reduced.mesh.triangles.size(), full.triangles.size());
  expect_sound(full, reduced.mesh, 0.25);
}

TEST_F(CellDecimations, DoNotDependOnThreads) {
  const TriangleMesh full = surface({130, 40, 28}, [](double x, double y, double z) {
    return bodies(std::fmod(x, 54), y, z);
  });
  const auto with = [&](int threads) {
    TriangleMesh mesh;
    tbb::task_arena(threads).execute(
        [&] { mesh = decimate_by_cells(full, {0.25, geometry_}, progress_).mesh; });
    return mesh;
  };
  const TriangleMesh one = with(1);
  EXPECT_EQ(with(2), one);
  EXPECT_EQ(with(7), one);
}

TEST_F(CellDecimations, StopWhenAskedTo) {
  const TriangleMesh full = surface({54, 40, 28}, bodies);
  testing::StoppingProgress watching(std::numeric_limits<int>::max());
  decimate_by_cells(full, {0.25, geometry_}, watching);
  EXPECT_EQ(watching.done_, watching.total_);
  for (const int answered : {0, 1, watching.questions_ - 1}) {
    testing::StoppingProgress stopping(answered);
    EXPECT_THROW(decimate_by_cells(full, {0.25, geometry_}, stopping), Error);
  }
}

}  // namespace
}  // namespace octavo
