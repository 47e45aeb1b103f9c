#include "octavo/mesh/decimation_steps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "octavo/mesh/extraction.h"
#include "octavo/mesh/measured_deviation.h"
#include "octavo/mesh/mesh_check.h"
#include "support/built_file.h"

namespace octavo {
namespace {

/// The surface of a ball with bumps, 0.5 mm from voxel to voxel.
class BumpyBall : public ::testing::Test {
 protected:
  void SetUp() override {
    testing::Volume volume;
    volume.description.size = {52, 52, 52};
    volume.description.type = VoxelType::int16;
    volume.description.geometry.spacing_mm = {0.5, 0.5, 0.5};
    std::vector<std::int16_t> voxels;
    for (std::int64_t z = 0; z < 52; ++z) {
      for (std::int64_t y = 0; y < 52; ++y) {
        for (std::int64_t x = 0; x < 52; ++x) voxels.push_back(value_at(x, y, z));
      }
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
    volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(std::int16_t));
    testing::ScratchFolder folder;
    testing::build_volume(volume, folder.file("v.8vo"), 1);
    MeshCollector collector;
    extract_surface(*testing::open_file(folder.file("v.8vo")), 0,
                    SurfaceField::of_grey(0, false, VoxelType::int16), collector, progress_);
    full_ = collector.take();
    options_.geometry = volume.description.geometry;
  }

  static std::int16_t value_at(std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto at = [](std::int64_t i) { return static_cast<double>(i); };
    const double bumps = std::sin(0.9 * at(x)) + std::sin(0.8 * at(y)) + std::sin(0.7 * at(z));
    const double from = std::hypot(at(x) - 26, at(y) - 26, at(z) - 26);
    return static_cast<std::int16_t>(100 * (17 - from) + 120 * bumps);
  }

  NoProgress progress_;
  TriangleMesh full_;
  DecimationOptions options_;
};

TEST_F(BumpyBall, HasNoMoreTrianglesWhereMoreDeviationIsAllowed) {
  std::size_t last = full_.triangles.size();
  for (const double deviation : {0.1, 0.25, 0.5, 1.0, 1.5, 3.0, 10.0}) {
    options_.max_deviation_mm = deviation;
    const Decimated reduced = decimate_in_steps(full_, options_, progress_);
    EXPECT_LE(reduced.mesh.triangles.size(), last * 11 / 10) << deviation;
    last = std::min(last, reduced.mesh.triangles.size());
    EXPECT_TRUE(check_mesh(reduced.mesh).is_closed());
    EXPECT_EQ(check_mesh(reduced.mesh).euler_number, check_mesh(full_).euler_number);
    EXPECT_EQ(reduced.crossing_triangles, 0u);
    EXPECT_LE(measured_deviation(full_, reduced.mesh, deviation, 1e-4, progress_), deviation);
  }
  EXPECT_LT(last, full_.triangles.size() / 20);
}

TEST_F(BumpyBall, IsReducedOnceWithinHalfAVoxel) {
  options_.max_deviation_mm = 0.2;
  const Decimated once = decimate(full_, options_, progress_);
  const Decimated stepped = decimate_in_steps(full_, options_, progress_);
  EXPECT_TRUE(once.mesh.points == stepped.mesh.points);
  EXPECT_TRUE(once.mesh.triangles == stepped.mesh.triangles);
}

}  // namespace
}  // namespace octavo
