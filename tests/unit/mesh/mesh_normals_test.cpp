#include "octavo/mesh/mesh_normals.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/mesh/extraction.h"
#include "octavo/mesh/point_distance.h"
#include "support/built_file.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

constexpr Size3 kBallSize = {70, 66, 68};
constexpr Point3 kBallCenter = {34.3, 32.6, 33.1};
constexpr double kBallRadius = 25;

/// A turned, mirrored grid with a different spacing along each axis.
Geometry turned_grid() {
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  return {{-20, 30, 5}, {0.5, 0.75, 1.25}, {c, -s, 0, s, c, 0, 0, 0, -1}};
}

/// A ball, brightest in the middle, and the file made of it.
class Ball {
 public:
  explicit Ball(const Geometry& geometry, bool is_falling = false) {
    testing::Volume volume;
    volume.description.size = kBallSize;
    volume.description.type = VoxelType::float32;
    volume.description.geometry = geometry;
    std::vector<float> voxels;
    for (std::int64_t z = 0; z < kBallSize.z; ++z) {
      for (std::int64_t y = 0; y < kBallSize.y; ++y) {
        for (std::int64_t x = 0; x < kBallSize.x; ++x) {
          const Point3 out = difference({double(x), double(y), double(z)}, kBallCenter);
          const double value = kBallRadius - std::sqrt(dot(out, out));
          voxels.push_back(static_cast<float>(is_falling ? -value : value));
        }
      }
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
    volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(float));
    testing::build_volume(volume, folder_.file("v.8vo"), 1);
    reader_ = testing::open_file(folder_.file("v.8vo"));
    field_ = SurfaceField::of_grey(0, is_falling, VoxelType::float32);
    MeshCollector collector;
    extract_surface(*reader_, 0, field_, collector, progress_);
    mesh_ = collector.take();
  }

  const TriangleMesh& mesh() const { return mesh_; }

  std::vector<MeshPoint> normals(int threads = 1) {
    std::vector<MeshPoint> normals;
    tbb::task_arena(threads).execute(
        [&] { normals = gradient_normals(mesh_, *reader_, 0, field_, progress_); });
    return normals;
  }

  const FileReader& reader() const { return *reader_; }
  const SurfaceField& field() const { return field_; }

 private:
  testing::ScratchFolder folder_;
  std::shared_ptr<FileReader> reader_;
  SurfaceField field_;
  TriangleMesh mesh_;
  NoProgress progress_;
};

/// The largest distance between normals and those of the true surface.
double worst_of(const std::vector<MeshPoint>& normals, const TriangleMesh& mesh,
                const Geometry& geometry) {
  double worst = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Point3 out = difference(geometry.to_index(place_of_point(mesh.points[i])), kBallCenter);
    // The index gradient, per mm along the axes of the grid.
    Point3 expected{};
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        expected[row] +=
            geometry.direction[3 * row + axis] * out[axis] / geometry.spacing_mm[axis];
      }
    }
    const Point3 apart = difference(unit(expected), place_of_point(normals[i]));
    worst = std::max(worst, std::sqrt(dot(apart, apart)));
  }
  return worst;
}

TEST(MeshNormals, PointAwayFromTheInsideAlongTheGradient) {
  for (const bool is_falling : {false, true}) {
    for (const Geometry& geometry : {Geometry{}, turned_grid()}) {
      Ball ball(geometry, is_falling);
      ASSERT_GT(ball.mesh().points.size(), 10'000u);
      const double of_gradient = worst_of(ball.normals(), ball.mesh(), geometry);
      const double of_triangles = worst_of(area_normals(ball.mesh()), ball.mesh(), geometry);
      EXPECT_LT(of_gradient, 0.01);
      EXPECT_LT(of_gradient, of_triangles / 5);
      EXPECT_LT(of_triangles, 0.2);
    }
  }
}

TEST(MeshNormals, DoNotDependOnThreads) {
  Ball ball(turned_grid());
  EXPECT_EQ(ball.normals(1), ball.normals(3));
}

TEST(MeshNormals, OfFewerPointsAreThoseAtTheirPlaces) {
  Ball ball({});
  TriangleMesh one;
  const MeshTriangle& t = ball.mesh().triangles[77];
  for (const std::uint32_t point : t) one.points.push_back(ball.mesh().points[point]);
  one.triangles = {{0, 1, 2}};
  NoProgress progress;
  const auto few = gradient_normals(one, ball.reader(), 0, ball.field(), progress);
  const auto all = ball.normals();
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(few[k], all[t[k]]);
}

TEST(MeshNormals, AtTheBorderOfTheVolumeAreThoseOfTriangles) {
  testing::ScratchFolder folder;
  testing::Volume volume;
  volume.description.size = {5, 4, 3};
  volume.description.type = VoxelType::uint8;
  volume.voxels.assign(60, std::byte{100});
  testing::build_volume(volume, folder.file("v.8vo"), 1);
  const auto reader = testing::open_file(folder.file("v.8vo"));
  const SurfaceField field = SurfaceField::of_grey(50, false, VoxelType::uint8);
  MeshCollector collector;
  NoProgress progress;
  extract_surface(*reader, 0, field, collector, progress);
  const TriangleMesh mesh = collector.take();
  EXPECT_EQ(gradient_normals(mesh, *reader, 0, field, progress), area_normals(mesh));
}

TEST(MeshNormals, OfTrianglesAreWeightedByArea) {
  const TriangleMesh mesh = {{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 1}, {9, 9, 9}},
                             {{0, 1, 2}, {0, 2, 3}}};
  const auto normals = area_normals(mesh);
  const float root = std::sqrt(5.0f);
  EXPECT_NEAR(normals[0][0], 1 / root, 1e-6);
  EXPECT_NEAR(normals[0][2], 2 / root, 1e-6);
  EXPECT_EQ(normals[1], (MeshPoint{0, 0, 1}));
  EXPECT_EQ(normals[3], (MeshPoint{1, 0, 0}));
  EXPECT_EQ(normals[4], (MeshPoint{0, 0, 1}));
}

TEST(MeshNormals, StopWhenAskedTo) {
  Ball ball({});
  testing::StoppingProgress progress;
  EXPECT_THROW(gradient_normals(ball.mesh(), ball.reader(), 0, ball.field(), progress), Error);
}

}  // namespace
}  // namespace octavo
