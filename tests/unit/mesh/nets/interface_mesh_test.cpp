#include "octavo/mesh/nets/interface_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/nets/net_extraction.h"
#include "support/built_labels.h"

namespace octavo {
namespace {

/// Surfaces between the labels of a file.
struct Interfaces {
  explicit Interfaces(const FileReader& reader, int steps = 0)
      : frame(reader.description().geometry, reader.levels().size(0)) {
    NetCollector collector;
    NoProgress progress;
    extract_net(reader, 0, collector, progress);
    net = collector.take();
    made = interface_mesh(net, smoothed_offsets(net, steps), frame);
  }

  SurfaceFrame frame;
  SurfaceNet net;
  InterfaceMesh made;
};

void expect_manifold(const TriangleMesh& part) {
  const MeshCheck check = check_mesh(part);
  EXPECT_EQ(check.open_sides, 0u);
  EXPECT_EQ(check.repeated_sides, 0u);
  EXPECT_EQ(check.pinched_points, 0u);
}

/// Places of the corners of a triangle, the lowest first.
using CornerPlaces = std::array<MeshPoint, 3>;

CornerPlaces corner_places(const TriangleMesh& mesh, const MeshTriangle& t) {
  CornerPlaces places = {mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
  std::rotate(places.begin(), std::min_element(places.begin(), places.end()), places.end());
  return places;
}

TEST(InterfaceMesh, PartsAreClosedAndManifoldAndFillTheBox) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Size3 size = {8, 8, 8};
    const int highest = static_cast<int>(1 + seed % 6);
    std::vector<std::int16_t> voxels = testing::random_labels(size, seed, highest);
    const bool is_full = seed % 2 == 0;
    for (std::int16_t& voxel : voxels) voxel = static_cast<std::int16_t>(voxel + (is_full ? 1 : 0));
    const testing::BuiltLabels labels(size, voxels);
    for (const int steps : {0, 5}) {
      const Interfaces interfaces(labels.reader(), steps);
      LabelParts parts(interfaces.made);
      const auto counts = voxel_counts(interfaces.net, false);
      double volume = 0;
      for (const std::int64_t label : parts.labels()) {
        const TriangleMesh part = parts.cut(label);
        expect_manifold(part);
        const double own = measure_mesh(part).volume_mm3;
        const auto expected = std::count(voxels.begin(), voxels.end(), label);
        EXPECT_EQ(counts.at(label), expected);
        if (steps == 0) {
          EXPECT_NEAR(own, static_cast<double>(expected), 1e-3);
        }
        volume += own;
      }
      if (is_full && steps == 0) {
        EXPECT_NEAR(volume, 512, 1e-3);
      }
    }
  }
}

TEST(InterfaceMesh, NeighborsShareTheirTriangles) {
  const Size3 size = {9, 8, 7};
  const testing::BuiltLabels labels(size, testing::random_labels(size, 4, 5));
  const Interfaces interfaces(labels.reader(), 8);
  std::multiset<CornerPlaces> open;
  LabelParts parts(interfaces.made);
  std::size_t shared = 0;
  for (const std::int64_t label : parts.labels()) {
    const TriangleMesh part = parts.cut(label);
    for (MeshTriangle t : part.triangles) {
      std::swap(t[1], t[2]);
      const auto twin = open.find(corner_places(part, t));
      if (twin != open.end()) {
        open.erase(twin);
        ++shared;
        continue;
      }
      std::swap(t[1], t[2]);
      open.insert(corner_places(part, t));
    }
  }
  // Those left lie beside 0.
  std::size_t outer = 0;
  for (const std::uint32_t pair : interfaces.made.pair_of) {
    outer += interfaces.made.pairs[pair][1] == 0 ? 1u : 0u;
  }
  EXPECT_EQ(open.size(), outer);
  EXPECT_EQ(shared + outer, interfaces.made.mesh.triangles.size());
}

TEST(InterfaceMesh, TellsPartsThatTouchApart) {
  // Two voxels at an edge and one at a corner of the second.
  const Size3 size = {3, 3, 3};
  std::vector<std::int16_t> voxels(27);
  for (const std::size_t voxel : {0u, 4u, 17u}) voxels[voxel] = 1;
  const testing::BuiltLabels labels(size, voxels);
  const Interfaces interfaces(labels.reader());
  const TriangleMesh part = LabelParts(interfaces.made).cut(1);
  expect_manifold(part);
  const MeshCheck check = check_mesh(part);
  EXPECT_EQ(check.components, 3u);
  EXPECT_EQ(check.euler_number, 6);
  EXPECT_EQ(check.coincident_points, 4u);
}

TEST(InterfaceMesh, IsTurnedOutwardOnEveryGrid) {
  const Size3 size = {6, 5, 4};
  const auto voxels = testing::random_labels(size, 8, 3);
  const double c = std::cos(0.5);
  const double s = std::sin(0.5);
  const Geometry turned{{100, -200, 50}, {0.5, 0.75, 2}, {c, -s, 0, s, c, 0, 0, 0, 1}};
  const Geometry mirrored{{-7, 8, 9}, {0.5, 0.75, 2}, {1, 0, 0, 0, 1, 0, 0, 0, -1}};
  for (const Geometry& geometry : {turned, mirrored}) {
    const testing::BuiltLabels labels(size, voxels, geometry);
    const Interfaces interfaces(labels.reader());
    LabelParts parts(interfaces.made);
    for (const std::int64_t label : parts.labels()) {
      const auto count = static_cast<double>(std::count(voxels.begin(), voxels.end(), label));
      EXPECT_NEAR(measure_mesh(parts.cut(label)).volume_mm3, 0.75 * count, 1e-3);
      EXPECT_EQ(voxel_counts(interfaces.net, interfaces.frame.is_mirrored()).at(label),
                std::count(voxels.begin(), voxels.end(), label));
    }
  }
}

}  // namespace
}  // namespace octavo
