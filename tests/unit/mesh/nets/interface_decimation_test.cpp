#include "octavo/mesh/nets/interface_decimation.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "octavo/core/error.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/nets/net_extraction.h"
#include "octavo/mesh/nets/smoothed_interfaces.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_tree.h"
#include "support/built_labels.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

/// A ball in three colors, and grains that touch at edges and corners.
class ColoredBall : public ::testing::Test {
 protected:
  static constexpr std::int64_t kSide = 40;

  void SetUp() override {
    std::vector<std::int16_t> voxels;
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) voxels.push_back(label_at(x, y, z));
      }
    }
    const testing::BuiltLabels labels({kSide, kSide, kSide}, voxels);
    NetCollector collector;
    extract_net(labels.reader(), 0, collector, progress_);
    const SurfaceFrame frame({}, {kSide, kSide, kSide});
    full_ = smoothed_interfaces(collector.take(), frame, 20, 0.01).interfaces;
  }

  static std::int16_t label_at(int x, int y, int z) {
    if (std::hypot(x - 20, y - 20, z - 20) < 16) {
      return x + y / 2 < 28 ? std::int16_t{1} : z < 18 ? std::int16_t{2} : std::int16_t{3};
    }
    if (x < 4 && y < 4 && z < 4) return (x + y + z) % 2 == 0 ? std::int16_t{4} : std::int16_t{5};
    return 0;
  }

  static double largest_distance(const TriangleMesh& from, const TriangleMesh& to) {
    const TriangleTree tree(to);
    double largest = 0;
    for (const MeshPoint& point : from.points) {
      largest = std::max(largest, tree.nearest(place_of_point(point), 100).distance);
    }
    return largest;
  }

  NoProgress progress_;
  InterfaceMesh full_;
};

TEST_F(ColoredBall, HasAsFewTrianglesAsAskedWithinWhatIsProven) {
  const std::uint64_t limit = full_.mesh.triangles.size() / 5;
  const LimitedInterfaces limited = decimate_interfaces_to(full_, limit, {}, progress_);
  ASSERT_TRUE(limited.is_reached) << limited.triangle_count;
  const TriangleMesh& mesh = limited.reduced.interfaces.mesh;
  EXPECT_LE(mesh.triangles.size(), limit);
  EXPECT_EQ(limited.triangle_count, mesh.triangles.size());
  EXPECT_LE(largest_distance(full_.mesh, mesh), limited.max_deviation_mm);
  EXPECT_LE(largest_distance(mesh, full_.mesh), limited.max_deviation_mm);
}

/// The farthest that points of the surface between two labels lie from that of other interfaces.
double largest_distance_of_pairs(const InterfaceMesh& from, const InterfaceMesh& to) {
  double largest = 0;
  for (std::uint32_t pair = 0; pair < to.pairs.size(); ++pair) {
    TriangleMesh other{to.mesh.points, {}};
    for (std::size_t i = 0; i < to.pair_of.size(); ++i) {
      if (to.pair_of[i] == pair) other.triangles.push_back(to.mesh.triangles[i]);
    }
    const TriangleTree tree(other);
    for (std::size_t i = 0; i < from.pair_of.size(); ++i) {
      if (from.pair_of[i] != pair) continue;
      for (const std::uint32_t point : from.mesh.triangles[i]) {
        const Point3 place = place_of_point(from.mesh.points[point]);
        largest = std::max(largest, tree.nearest(place, 100).distance);
      }
    }
  }
  return largest;
}

TEST_F(ColoredBall, SaysWhatCameOfALimitAndNotWhatWasAllowed) {
  const std::uint64_t fewest = decimate_interfaces_to(full_, 1, {}, progress_).triangle_count;
  const LimitedInterfaces limited = decimate_interfaces_to(full_, fewest, {}, progress_);
  ASSERT_TRUE(limited.is_reached);
  const InterfaceMesh& reduced = limited.reduced.interfaces;
  const double farthest = std::max(largest_distance_of_pairs(full_, reduced),
                                   largest_distance_of_pairs(reduced, full_));
  EXPECT_GE(limited.max_deviation_mm, farthest);
  EXPECT_LE(limited.max_deviation_mm, 1.2 * farthest);
}

TEST_F(ColoredBall, PartsStayManifoldAndNear) {
  const DecimatedInterfaces reduced = decimate_interfaces(full_, 0.5, {}, progress_);
  EXPECT_EQ(reduced.crossing_triangles, 0u);
  EXPECT_LT(2 * reduced.interfaces.mesh.triangles.size(), full_.mesh.triangles.size());
  LabelParts before(full_);
  LabelParts after(reduced.interfaces);
  ASSERT_EQ(after.labels(), before.labels());
  double volume = 0;
  for (const std::int64_t label : after.labels()) {
    const TriangleMesh part = after.cut(label);
    const TriangleMesh whole = before.cut(label);
    const MeshCheck check = check_mesh(part);
    const MeshCheck expected = check_mesh(whole);
    EXPECT_EQ(check.open_sides, 0u);
    EXPECT_EQ(check.repeated_sides, 0u);
    EXPECT_EQ(check.pinched_points, 0u);
    EXPECT_EQ(check.components, expected.components);
    EXPECT_EQ(check.euler_number, expected.euler_number);
    EXPECT_LE(largest_distance(part, whole), 0.5);
    EXPECT_LE(largest_distance(whole, part), 0.5);
    volume += measure_mesh(part).volume_mm3 - measure_mesh(whole).volume_mm3;
  }
  EXPECT_LT(std::abs(volume), 0.02 * 4 / 3 * 3.14 * 16 * 16 * 16);
}

TEST_F(ColoredBall, DoesNotDependOnThreads) {
  const DecimatedInterfaces one = decimate_interfaces(full_, 0.5, {}, progress_);
  tbb::task_arena(3).execute([&] {
    const DecimatedInterfaces other = decimate_interfaces(full_, 0.5, {}, progress_);
    EXPECT_EQ(other.interfaces.mesh, one.interfaces.mesh);
    EXPECT_EQ(other.interfaces.pair_of, one.interfaces.pair_of);
    EXPECT_EQ(other.interfaces.fans, one.interfaces.fans);
  });
}

TEST_F(ColoredBall, StopsWhenAskedTo) {
  testing::StoppingProgress stopping;
  EXPECT_THROW(decimate_interfaces(full_, 0.5, {}, stopping), Error);
}

}  // namespace
}  // namespace octavo
