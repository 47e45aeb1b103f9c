#include "octavo/mesh/mesh_pieces.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

/// Two pieces whose triangles take turns, and a point that no triangle has.
const TriangleMesh kTwoPieces = {
    {{0, 0, 0}, {1, 0, 0}, {9, 9, 9}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {1, 1, 0}},
    {{4, 5, 6}, {0, 1, 3}, {1, 7, 3}}};

TEST(MeshPieces, AreNumberedByTheirFirstPoints) {
  const MeshPieces pieces = mesh_pieces(kTwoPieces);
  EXPECT_EQ(pieces.count, 2u);
  EXPECT_EQ(pieces.of_point,
            (std::vector<std::uint32_t>{0, 0, MeshPieces::kNone, 0, 1, 1, 1, 0}));
  EXPECT_EQ(mesh_pieces({}).count, 0u);
}

TEST(MeshPieces, HangTogetherAtASinglePoint) {
  TriangleMesh mesh = kTwoPieces;
  mesh.triangles.push_back({6, 7, 2});
  const MeshPieces pieces = mesh_pieces(mesh);
  EXPECT_EQ(pieces.count, 1u);
  EXPECT_EQ(pieces.of_point, std::vector<std::uint32_t>(8, 0));
}

TEST(MeshPieces, APieceKeepsTheOrderOfPointsAndTriangles) {
  const TriangleMesh first = piece_of_point(kTwoPieces, 7);
  EXPECT_EQ(first.points,
            (std::vector<MeshPoint>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_EQ(first.triangles, (std::vector<MeshTriangle>{{0, 1, 2}, {1, 3, 2}}));
  const TriangleMesh second = piece_of_point(kTwoPieces, 4);
  EXPECT_EQ(second.points.size(), 3u);
  EXPECT_EQ(second.triangles, (std::vector<MeshTriangle>{{0, 1, 2}}));
}

TEST(MeshPieces, TheNearestTriangleOfAPlaceIsFound) {
  const NearestTriangle nearest = nearest_triangle(kTwoPieces, {5.25, 0.25, 2});
  EXPECT_EQ(nearest.triangle, 0u);
  EXPECT_DOUBLE_EQ(nearest.distance_mm, 2);
  EXPECT_EQ(nearest_triangle(kTwoPieces, {0.9, 0.9, -1}).triangle, 2u);
}

}  // namespace
}  // namespace octavo
