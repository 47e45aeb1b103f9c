#include "octavo/mesh/decimation.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <string>

#include "octavo/core/error.h"
#include "octavo/mesh/certificate.h"
#include "octavo/mesh/extraction.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/octree_decimation/octree_decimation.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_tree.h"
#include "support/built_file.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

/// Two balls and a ring around one of them, on a grid that is oblique and far from the origin.
class Bodies : public ::testing::Test {
 protected:
  void SetUp() override {
    const double c = std::cos(0.3);
    const double s = std::sin(0.3);
    extract({72, 40, 40}, {{-300, 120, 900}, {0.5, 0.75, 1}, {c, -s, 0, s, c, 0, 0, 0, 1}},
            value_at);
    options_.max_deviation_mm = 0.25;
  }

  /// Makes the surface at 0 the one that is reduced.
  template <class Value>
  void extract(const Size3& size, const Geometry& geometry, Value value) {
    testing::Volume volume;
    volume.description.size = size;
    volume.description.type = VoxelType::int16;
    volume.description.geometry = geometry;
    std::vector<std::int16_t> voxels;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) voxels.push_back(value(x, y, z));
      }
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
    volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(std::int16_t));
    const std::string path = folder_.file(std::to_string(size.x) + ".8vo");
    testing::build_volume(volume, path, 1);
    const auto reader = testing::open_file(path);
    MeshCollector collector;
    extract_surface(*reader, 0, SurfaceField::of_grey(0, false, VoxelType::int16), collector,
                    progress_);
    full_ = collector.take();
    options_.geometry = geometry;
  }

  static std::int16_t value_at(std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto from = [&](double cx) {
      return std::hypot(static_cast<double>(x) - cx, static_cast<double>(y) - 20,
                        static_cast<double>(z) - 20);
    };
    const double ring = std::hypot(
        std::hypot(static_cast<double>(x) - 20, static_cast<double>(y) - 20) - 16,
        static_cast<double>(z) - 20);
    const double inside = std::max({9 - from(20), 13 - from(55), 2.5 - ring});
    return static_cast<std::int16_t>(std::clamp(inside * 100, -2000.0, 2000.0));
  }

  /// The largest distance of corners, middles of sides and middles of triangles.
  static double largest_distance(const TriangleMesh& from, const TriangleMesh& to) {
    const TriangleTree tree(to);
    double largest = 0;
    for (const MeshTriangle& t : from.triangles) {
      const TrianglePlaces p = places_of(from, t);
      const Point3 middle = scaled(sum(sum(p[0], p[1]), p[2]), 1.0 / 3);
      for (const Point3& place : {p[0], p[1], p[2], middle, scaled(sum(p[0], p[1]), 0.5)}) {
        largest = std::max(largest, tree.nearest(place, 100).distance);
      }
    }
    return largest;
  }

  testing::ScratchFolder folder_;
  NoProgress progress_;
  TriangleMesh full_;
  DecimationOptions options_;
};

TEST_F(Bodies, KeepTheirTopologyWithinTheDeviation) {
  const Decimated reduced = decimate(full_, options_, progress_);
  const MeshCheck before = check_mesh(full_);
  const MeshCheck after = check_mesh(reduced.mesh);
  EXPECT_LT(10 * reduced.mesh.triangles.size(), full_.triangles.size());
  EXPECT_TRUE(after.is_closed());
  EXPECT_TRUE(after.is_manifold());
  EXPECT_EQ(after.components, before.components);
  EXPECT_EQ(after.euler_number, before.euler_number);
  EXPECT_EQ(after.components, 3u);
  EXPECT_EQ(after.euler_number, 4);
  EXPECT_EQ(reduced.crossing_triangles, 0u);
  EXPECT_TRUE(crossing_triangles(TriangleTree(reduced.mesh), progress_).empty());
  EXPECT_LE(largest_distance(full_, reduced.mesh), options_.max_deviation_mm);
  EXPECT_LE(largest_distance(reduced.mesh, full_), options_.max_deviation_mm);
  EXPECT_NEAR(measure_mesh(reduced.mesh).volume_mm3, measure_mesh(full_).volume_mm3,
              0.03 * measure_mesh(full_).volume_mm3);
}

// As where distances are 0 at the surface: its points lie near one another at grid points.
TEST_F(Bodies, HaveFewTrianglesWhereTheyPassThroughGridPoints) {
  extract({44, 40, 38}, {}, [](std::int64_t x, std::int64_t y, std::int64_t z) {
    const double from = std::hypot(static_cast<double>(x) - 22, static_cast<double>(y) - 20,
                                   static_cast<double>(z) - 18);
    return static_cast<std::int16_t>(1000 * (15 - from));
  });
  options_.max_deviation_mm = 0.5;
  for (const auto reduce : {decimate, decimate_by_cells}) {
    const Decimated reduced = reduce(full_, options_, progress_);
    EXPECT_LT(reduced.mesh.triangles.size(), full_.triangles.size() * 6 / 100);
    EXPECT_TRUE(check_mesh(reduced.mesh).is_closed());
    EXPECT_EQ(check_mesh(reduced.mesh).euler_number, 2);
    EXPECT_EQ(reduced.crossing_triangles, 0u);
    EXPECT_LE(largest_distance(full_, reduced.mesh), options_.max_deviation_mm);
    EXPECT_LE(largest_distance(reduced.mesh, full_), options_.max_deviation_mm);
  }
}

TEST_F(Bodies, HaveFewerTrianglesWhereMoreDeviationIsAllowed) {
  std::size_t last = full_.triangles.size();
  for (const double deviation : {0.02, 0.1, 0.5}) {
    options_.max_deviation_mm = deviation;
    const std::size_t count = decimate(full_, options_, progress_).mesh.triangles.size();
    EXPECT_LT(count, last);
    last = count;
  }
}

TEST_F(Bodies, DoNotDependOnThreads) {
  const auto with = [&](int threads) {
    TriangleMesh mesh;
    tbb::task_arena(threads).execute([&] { mesh = decimate(full_, options_, progress_).mesh; });
    return mesh;
  };
  const TriangleMesh one = with(1);
  EXPECT_EQ(with(2), one);
  EXPECT_EQ(with(7), one);
}

// Thin sheets with holes, close to each other: proofs fail at first, and later rounds keep what
// they can of earlier ones.
TEST_F(Bodies, AreProvenAfterSeveralRounds) {
  testing::Volume volume;
  const Size3 size = {48, 40, 16};
  volume.description.size = size;
  volume.description.type = VoxelType::uint8;
  volume.description.kind = VolumeKind::labels;
  std::uint32_t state = 1;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        state = state * 1664525 + 1013904223;
        const bool is_sheet = (z + x / 5 + y / 7) % 4 == 0;
        volume.voxels.push_back(std::byte{is_sheet && (state >> 28) != 0});
      }
    }
  }
  testing::build_volume(volume, folder_.file("sheets.8vo"), 1);
  const auto reader = testing::open_file(folder_.file("sheets.8vo"));
  MeshCollector collector;
  extract_surface(*reader, 0, SurfaceField::of_labels({}), collector, progress_);
  const TriangleMesh full = collector.take();
  const Decimated reduced = decimate(full, {0.6, volume.description.geometry}, progress_);
  EXPECT_GE(reduced.rounds, 3);
  EXPECT_LT(reduced.mesh.triangles.size(), full.triangles.size() / 2);
  EXPECT_EQ(reduced.crossing_triangles, 0u);
  const TriangleTree full_tree(full);
  const TriangleTree reduced_tree(reduced.mesh);
  EXPECT_TRUE(crossing_triangles(reduced_tree, progress_).empty());
  EXPECT_TRUE(unproven_triangles(full, reduced_tree, 0.6, progress_).empty());
  EXPECT_TRUE(unproven_triangles(reduced.mesh, full_tree, 0.6, progress_).empty());
  const MeshCheck before = check_mesh(full);
  const MeshCheck after = check_mesh(reduced.mesh);
  EXPECT_EQ(after.is_closed(), before.is_closed());
  EXPECT_EQ(after.components, before.components);
  EXPECT_EQ(after.euler_number, before.euler_number);
}

TEST_F(Bodies, AreNotTurnedInsideOut) {
  // A piece of a mask that passed through itself as a whole where 2 mm are allowed.
  testing::Volume volume;
  volume.description.size = {5, 5, 5};
  volume.description.type = VoxelType::uint8;
  volume.description.kind = VolumeKind::labels;
  volume.voxels.resize(125);
  for (const std::size_t voxel : {38u, 41u, 42u, 62u, 63u, 66u, 67u, 88u, 92u}) {
    volume.voxels[voxel] = std::byte{1};
  }
  testing::build_volume(volume, folder_.file("turned.8vo"), 1);
  const auto reader = testing::open_file(folder_.file("turned.8vo"));
  MeshCollector collector;
  extract_surface(*reader, 0, SurfaceField::of_labels({}), collector, progress_);
  const TriangleMesh full = collector.take();
  for (const double deviation : {0.5, 2.0, 20.0}) {
    const Decimated reduced =
        decimate(full, {deviation, volume.description.geometry}, progress_);
    EXPECT_GT(measure_mesh(reduced.mesh).volume_mm3, 0) << deviation;
  }
}

TEST_F(Bodies, KeepTheirRimWhereItIsLocked) {
  TriangleMesh open;
  open.points = full_.points;
  std::vector<int> uses(full_.points.size());
  for (const MeshTriangle& t : full_.triangles) {
    for (const std::uint32_t point : t) ++uses[point];
    if (full_.points[t[0]][2] < 920) open.triangles.push_back(t);
  }
  for (const MeshTriangle& t : open.triangles) {
    for (const std::uint32_t point : t) --uses[point];
  }
  std::vector<bool> is_open(open.points.size());
  for (const MeshTriangle& t : open.triangles) {
    for (const std::uint32_t point : t) is_open[point] = true;
  }
  std::vector<std::uint32_t> rim;
  for (std::uint32_t point = 0; point < uses.size(); ++point) {
    if (is_open[point] && uses[point] > 0) rim.push_back(point);
  }
  options_.locked = rim;
  const Decimated reduced = decimate(open, options_, progress_);
  EXPECT_LT(5 * reduced.mesh.triangles.size(), open.triangles.size());
  EXPECT_GT(check_mesh(open).open_sides, 100u);
  EXPECT_EQ(check_mesh(reduced.mesh).open_sides, check_mesh(open).open_sides);
  ASSERT_EQ(reduced.locked.size(), rim.size());
  for (std::size_t i = 0; i < rim.size(); ++i) {
    EXPECT_EQ(reduced.mesh.points[reduced.locked[i]], open.points[rim[i]]);
  }
}

TEST_F(Bodies, StopWhenAskedTo) {
  testing::StoppingProgress watching(std::numeric_limits<int>::max());
  const Decimated whole = decimate(full_, options_, watching);
  EXPECT_EQ(watching.ends_, whole.rounds);
  EXPECT_EQ(watching.done_, watching.total_);
  const int last = watching.questions_ - 1;
  for (const int answered : {0, 1, last / 2, last}) {
    testing::StoppingProgress stopping(answered);
    try {
      decimate(full_, options_, stopping);
      ADD_FAILURE() << "was not stopped at question " << answered << " of " << last;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled);
    }
  }
}

TEST(Decimation, NumbersTrianglesWith32Bits) {
  EXPECT_NO_THROW(require_numbered(0xffffffff));
  try {
    require_numbered(std::uint64_t{1} << 32);
    FAIL() << "more triangles than numbers";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
}

}  // namespace
}  // namespace octavo
