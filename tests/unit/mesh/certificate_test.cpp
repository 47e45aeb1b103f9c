#include "octavo/mesh/certificate.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

/// A square of two triangles at height z, of side 8.
TriangleMesh square(float z) {
  return {{{0, 0, z}, {8, 0, z}, {8, 8, z}, {0, 8, z}}, {{0, 1, 2}, {0, 2, 3}}};
}

/// The same of 8 x 8 squares, each of two triangles.
TriangleMesh fine_square(float z, bool has_hole) {
  TriangleMesh mesh;
  for (int y = 0; y <= 8; ++y) {
    for (int x = 0; x <= 8; ++x) {
      mesh.points.push_back({static_cast<float>(x), static_cast<float>(y), z});
    }
  }
  for (std::uint32_t y = 0; y < 8; ++y) {
    for (std::uint32_t x = 0; x < 8; ++x) {
      if (has_hole && x > 1 && x < 6 && y > 1 && y < 6) continue;
      const std::uint32_t a = y * 9 + x;
      mesh.triangles.push_back({a, a + 1, a + 10});
      mesh.triangles.push_back({a, a + 10, a + 9});
    }
  }
  return mesh;
}

TEST(Certificate, ProvesWhatIsNearAndNothingElse) {
  const TriangleMesh fine = fine_square(0, false);
  const TriangleMesh coarse = square(0.5f);
  const TriangleTree fine_tree(fine);
  const TriangleTree coarse_tree(coarse);
  for (const double distance : {0.51, 0.6, 1.0}) {
    EXPECT_TRUE(unproven_triangles(coarse, fine_tree, distance).empty());
    EXPECT_TRUE(unproven_triangles(fine, coarse_tree, distance).empty());
  }
  EXPECT_EQ(unproven_triangles(coarse, fine_tree, 0.49).size(), 2u);
  EXPECT_EQ(unproven_triangles(fine, coarse_tree, 0.49).size(), fine.triangles.size());
}

// All corners of the square are near, its middle is not.
TEST(Certificate, FindsWhatIsFarInTheMiddleOfATriangle) {
  const TriangleMesh holed = fine_square(0, true);
  const TriangleTree tree(holed);
  EXPECT_EQ(unproven_triangles(square(0), tree, 0.5).size(), 2u);
  EXPECT_TRUE(unproven_triangles(square(0), tree, 2.1).empty());
}

TEST(Certificate, HintsChangeNoAnswer) {
  const TriangleMesh fine = fine_square(0, false);
  const TriangleMesh coarse = square(0.5f);
  const TriangleTree tree(coarse);
  const std::vector<std::uint32_t> hints(fine.points.size(), 0);
  EXPECT_TRUE(unproven_triangles(fine, tree, 0.51, hints).empty());
  EXPECT_EQ(unproven_triangles(fine, tree, 0.49, hints).size(), fine.triangles.size());
}

TEST(TriangleTree, FindsTheNearestTriangleAndThoseThatCross) {
  TriangleMesh mesh = fine_square(0, false);
  EXPECT_TRUE(crossing_triangles(TriangleTree(mesh)).empty());
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
  const std::vector<std::uint32_t> crossing = crossing_triangles(TriangleTree(mesh));
  ASSERT_GE(crossing.size(), 2u);
  EXPECT_EQ(crossing.back(), last);
}

}  // namespace
}  // namespace octavo
