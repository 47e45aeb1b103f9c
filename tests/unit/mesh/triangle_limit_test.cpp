#include "octavo/mesh/triangle_limit.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <random>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/certificate.h"
#include "octavo/mesh/decimation_steps.h"
#include "octavo/mesh/measured_deviation.h"
#include "octavo/mesh/memory_surface.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_tree.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

/// Two balls with noise on them, one cut by the border, of voxels that are not cubes.
class Limited : public ::testing::Test {
 protected:
  void SetUp() override {
    std::mt19937 random(5);
    std::vector<std::uint8_t> voxels;
    for (std::int64_t z = 0; z < kSize.z; ++z) {
      for (std::int64_t y = 0; y < kSize.y; ++y) {
        for (std::int64_t x = 0; x < kSize.x; ++x) {
          const auto from = [&](double cx) {
            return std::hypot(static_cast<double>(x) - cx, static_cast<double>(y) - 14,
                              static_cast<double>(z) - 12);
          };
          const double inside = std::max(12 - from(2), 9 - from(30));
          const double value = 128 + 20 * inside + static_cast<double>(random() % 31) - 15;
          voxels.push_back(static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)));
        }
      }
    }
    geometry_.spacing_mm = {0.5, 0.75, 1};
    full_ = surface_of({voxels.data(), VoxelType::uint8, kSize, geometry_},
                       SurfaceField::of_grey(128, false, VoxelType::uint8), progress_);
  }

  bool is_within(const TriangleMesh& mesh, const TriangleMesh& other, double distance) {
    return unproven_triangles(mesh, TriangleTree(other), distance, progress_).empty();
  }

  static constexpr Size3 kSize = {44, 28, 24};
  NoProgress progress_;
  Geometry geometry_;
  TriangleMesh full_;
};

TEST_F(Limited, HasAsFewTrianglesAsAskedWithinWhatIsProven) {
  const MeshCheck before = check_mesh(full_);
  double last = 0;
  for (const std::size_t limit : {full_.triangles.size() / 2, std::size_t{300}, std::size_t{100}}) {
    const LimitedSurface limited = decimate_to(full_, limit, geometry_, progress_);
    ASSERT_TRUE(limited.is_reached) << limited.triangle_count;
    EXPECT_LE(limited.mesh.triangles.size(), limit);
    EXPECT_EQ(limited.triangle_count, limited.mesh.triangles.size());
    EXPECT_EQ(limited.crossing_triangles, 0u);
    const MeshCheck after = check_mesh(limited.mesh);
    EXPECT_TRUE(after.is_closed());
    EXPECT_TRUE(after.is_manifold());
    EXPECT_EQ(after.components, before.components);
    EXPECT_EQ(after.euler_number, before.euler_number);
    EXPECT_TRUE(is_within(full_, limited.mesh, limited.max_deviation_mm));
    EXPECT_TRUE(is_within(limited.mesh, full_, limited.max_deviation_mm));
    EXPECT_GT(limited.max_deviation_mm, last);
    last = limited.max_deviation_mm;
  }
}

TEST_F(Limited, KeepsHalfAVoxelWhereThatHasFewerTriangles) {
  const LimitedSurface limited =
      decimate_to(full_, full_.triangles.size(), geometry_, progress_);
  EXPECT_LE(limited.max_deviation_mm, 0.25);
  EXPECT_LT(3 * limited.mesh.triangles.size(), full_.triangles.size());
}

TEST_F(Limited, IsFoundFromWhatHalfAVoxelLeft) {
  const TriangleMesh first = decimate(full_, {first_step_mm(geometry_), geometry_}, progress_).mesh;
  const std::uint64_t count = full_.triangles.size();
  for (const std::size_t limit : {first.triangles.size(), first.triangles.size() / 3}) {
    const LimitedSurface limited = decimate_to(first, count, limit, geometry_, progress_);
    ASSERT_TRUE(limited.is_reached);
    EXPECT_LE(limited.mesh.triangles.size(), limit);
    EXPECT_TRUE(is_within(full_, limited.mesh, limited.max_deviation_mm));
    EXPECT_TRUE(is_within(limited.mesh, full_, limited.max_deviation_mm));
  }
}

TEST_F(Limited, SaysWhatPiecesNeed) {
  EXPECT_EQ(fewest_possible(full_), 4 * check_mesh(full_).components);
  const LimitedSurface limited = decimate_to(full_, 7, geometry_, progress_);
  EXPECT_FALSE(limited.is_reached);
  EXPECT_GE(limited.triangle_count, 8u);
  EXPECT_TRUE(limited.mesh.triangles.empty());
}

TEST_F(Limited, DoesNotDependOnThreads) {
  const auto with = [&](int threads) {
    LimitedSurface limited;
    tbb::task_arena(threads).execute(
        [&] { limited = decimate_to(full_, 200, geometry_, progress_); });
    return limited;
  };
  const LimitedSurface one = with(1);
  const LimitedSurface three = with(3);
  EXPECT_EQ(one.mesh, three.mesh);
  EXPECT_EQ(one.max_deviation_mm, three.max_deviation_mm);
}

TEST_F(Limited, StopsWhenAskedTo) {
  testing::StoppingProgress stopping(3);
  EXPECT_THROW(decimate_to(full_, 40, geometry_, stopping), Error);
}

TEST_F(Limited, IsMeasuredCloselyAndNeverBeyondWhatIsKnown) {
  TriangleMesh moved = full_;
  for (MeshPoint& point : moved.points) point[2] += 0.3f;
  const double measured = measured_deviation(full_, moved, 5, 1e-6, progress_);
  EXPECT_LE(measured, 0.34);
  EXPECT_GT(measured, 0.25);
  EXPECT_TRUE(is_within(full_, moved, measured));
  EXPECT_TRUE(is_within(moved, full_, measured));
  EXPECT_EQ(measured_deviation(full_, moved, 0.301, 1e-6, progress_), 0.301);
}

}  // namespace
}  // namespace octavo
