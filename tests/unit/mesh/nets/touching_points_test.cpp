#include "octavo/mesh/nets/touching_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/nets/interface_mesh.h"
#include "octavo/mesh/nets/net_extraction.h"
#include "octavo/mesh/triangle_tree.h"
#include "support/built_labels.h"

namespace octavo {
namespace {

InterfaceMesh interfaces_of(const testing::BuiltLabels& labels, int steps) {
  const FileReader& reader = labels.reader();
  NetCollector collector;
  NoProgress progress;
  extract_net(reader, 0, collector, progress);
  const SurfaceNet net = collector.take();
  return interface_mesh(net, smoothed_offsets(net, steps),
                        {reader.description().geometry, reader.levels().size(0)});
}

TEST(TouchingPoints, LeavesSurfacesThatAreClosedByTheirPlaces) {
  std::size_t touching = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Size3 size = {7, 8, 9};
    const int highest = static_cast<int>(1 + seed % 5);
    const testing::BuiltLabels labels(size, testing::random_labels(size, seed, highest));
    for (const int steps : {0, 5}) {
      const InterfaceMesh interfaces = interfaces_of(labels, steps);
      LabelParts parts(interfaces);
      for (const std::int64_t label : parts.labels()) {
        TriangleMesh part = parts.cut(label);
        const MeshCheck before = check_mesh(part);
        EXPECT_EQ(before.coincident_points > 0, !parts.touching().empty());
        touching += parts.touching().size();
        move_apart(parts.touching(), part);
        const MeshCheck after = check_mesh(part);
        EXPECT_EQ(after.coincident_points, 0u) << seed << ' ' << label;
        EXPECT_TRUE(after.is_closed() && after.is_manifold()) << seed << ' ' << label;
        EXPECT_EQ(after.components, before.components);
        NoProgress progress;
        if (steps == 0) {
          EXPECT_TRUE(crossing_triangles(TriangleTree(part), progress).empty())
              << seed << ' ' << label;
        }
      }
    }
  }
  EXPECT_GT(touching, 500u);
}

TEST(TouchingPoints, MovesBothNeighborsAlikeAtACorner) {
  // Two voxels that share a corner alone, in a label that lies all around them.
  const Size3 size = {4, 4, 4};
  std::vector<std::int16_t> voxels(64, 2);
  voxels[1 + 4 * (1 + 4 * 1)] = 1;
  voxels[2 + 4 * (2 + 4 * 2)] = 1;
  const testing::BuiltLabels labels(size, voxels);
  const InterfaceMesh interfaces = interfaces_of(labels, 0);
  LabelParts parts(interfaces);
  std::vector<std::vector<MeshPoint>> moved;
  for (const std::int64_t label : {1, 2}) {
    TriangleMesh part = parts.cut(label);
    move_apart(parts.touching(), part);
    ASSERT_EQ(parts.touching().size(), 2u) << label;
    std::vector<MeshPoint>& places = moved.emplace_back();
    for (const std::uint32_t point : parts.touching()) places.push_back(part.points[point]);
    std::sort(places.begin(), places.end());
  }
  EXPECT_EQ(moved[0], moved[1]);
  EXPECT_NE(moved[0][0], moved[0][1]);
}

}  // namespace
}  // namespace octavo
