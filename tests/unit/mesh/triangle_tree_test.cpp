#include "octavo/mesh/triangle_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "octavo/core/error.h"
#include "octavo/mesh/point_distance.h"
#include "support/square_meshes.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using testing::fine_square;

TEST(TriangleTree, FindsTheNearestTriangleAndThoseThatCross) {
  TriangleMesh mesh = fine_square(0, false);
  EXPECT_TRUE(crossing_triangles(TriangleTree(mesh), NoProgress()).empty());
  {
    const TriangleTree tree(mesh);
    const TriangleTree::Nearest nearest = tree.nearest({3.75, 4.25, 2}, 10);
    EXPECT_DOUBLE_EQ(nearest.distance, 2);
    EXPECT_EQ(nearest.triangle, 2u * (4 * 8 + 3));
    EXPECT_EQ(tree.nearest({3.75, 4.25, 2}, 1.9).triangle, TriangleTree::kNone);
  }
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), {{3.5f, 4.25f, -1}, {3.75f, 4.25f, 1}, {3.5f, 4.5f, 1}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const auto last = static_cast<std::uint32_t>(mesh.triangles.size() - 1);
  const std::vector<std::uint32_t> crossing =
      crossing_triangles(TriangleTree(mesh), NoProgress());
  ASSERT_GE(crossing.size(), 2u);
  EXPECT_EQ(crossing.back(), last);
}

TEST(TriangleTree, FindsThoseThatCrossSomeTriangles) {
  TriangleMesh mesh = fine_square(0, false);
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), {{3.5f, 4.25f, -1}, {3.75f, 4.25f, 1}, {3.5f, 4.5f, 1}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const TriangleTree tree(mesh);
  const std::vector<std::uint32_t> all = crossing_triangles(tree, NoProgress());
  const auto with = [&](const std::vector<std::uint32_t>& some) {
    return crossing_triangles(tree, some, NoProgress());
  };
  EXPECT_EQ(with({static_cast<std::uint32_t>(mesh.triangles.size() - 1)}), all);
  EXPECT_EQ(with({all.front()}), (std::vector<std::uint32_t>{all.front(), all.back()}));
  EXPECT_TRUE(with({}).empty());
  EXPECT_TRUE(with({0, 1}).empty());
}

TEST(TriangleTree, TheNearestIsThatOfAllTriangles) {
  std::mt19937 random(7);
  const auto number = [&](float side) {
    return side * static_cast<float>(random() % (1 << 20)) / (1 << 20);
  };
  for (const int count : {0, 1, 7, 8, 9, 500}) {
    TriangleMesh mesh;
    for (int i = 0; i < count; ++i) {
      const MeshPoint corner = {number(100), number(60), number(20)};
      const auto first = static_cast<std::uint32_t>(mesh.points.size());
      for (int k = 0; k < 3; ++k) {
        mesh.points.push_back(
            {corner[0] + number(9), corner[1] + number(9), corner[2] + number(9)});
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    const TriangleTree tree(mesh);
    for (int i = 0; i < 300; ++i) {
      const Point3 place = {number(120) - 10, number(80) - 10, number(40) - 10};
      const double limit = i % 4 == 0 ? 3 : 1000;
      double squared = limit * limit;
      for (const MeshTriangle& t : mesh.triangles) {
        squared = std::min(squared, squared_distance(place, places_of(mesh, t)));
      }
      const TriangleTree::Nearest nearest = tree.nearest(place, limit);
      EXPECT_DOUBLE_EQ(nearest.distance, std::sqrt(squared));
      ASSERT_EQ(nearest.triangle == TriangleTree::kNone, squared == limit * limit);
      if (nearest.triangle == TriangleTree::kNone) continue;
      EXPECT_EQ(squared_distance(place, places_of(mesh, mesh.triangles[nearest.triangle])),
                squared);
    }
  }
}

TEST(TriangleTree, StopsWhenAskedTo) {
  const TriangleMesh mesh = fine_square(0, false);
  const testing::StoppingProgress stopping;
  try {
    crossing_triangles(TriangleTree(mesh), stopping);
    FAIL() << "was not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::cancelled);
  }
}

}  // namespace
}  // namespace octavo
