#include "octavo/mesh/certificate.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"
#include "support/square_meshes.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using testing::fine_square;
using testing::square;

TEST(Certificate, ProvesWhatIsNearAndNothingElse) {
  const TriangleMesh fine = fine_square(0, false);
  const TriangleMesh coarse = square(0.5f);
  const TriangleTree fine_tree(fine);
  const TriangleTree coarse_tree(coarse);
  for (const double distance : {0.51, 0.6, 1.0}) {
    EXPECT_TRUE(unproven_triangles(coarse, fine_tree, distance, NoProgress()).empty());
    EXPECT_TRUE(unproven_triangles(fine, coarse_tree, distance, NoProgress()).empty());
  }
  EXPECT_EQ(unproven_triangles(coarse, fine_tree, 0.49, NoProgress()).size(), 2u);
  EXPECT_EQ(unproven_triangles(fine, coarse_tree, 0.49, NoProgress()).size(),
            fine.triangles.size());
}

// All corners of the square are near, its middle is not.
TEST(Certificate, FindsWhatIsFarInTheMiddleOfATriangle) {
  const TriangleMesh holed = fine_square(0, true);
  const TriangleTree tree(holed);
  EXPECT_EQ(unproven_triangles(square(0), tree, 0.5, NoProgress()).size(), 2u);
  EXPECT_TRUE(unproven_triangles(square(0), tree, 2.1, NoProgress()).empty());
}

TEST(Certificate, HintsChangeNoAnswer) {
  const TriangleMesh fine = fine_square(0, false);
  const TriangleMesh coarse = square(0.5f);
  const TriangleTree tree(coarse);
  const std::vector<std::uint32_t> hints(fine.points.size(), 0);
  EXPECT_TRUE(unproven_triangles(fine, tree, 0.51, NoProgress(), hints).empty());
  EXPECT_EQ(unproven_triangles(fine, tree, 0.49, NoProgress(), hints).size(),
            fine.triangles.size());
}

/// Lists with all points of the other surface attached to one triangle; with none of them.
AttachedPoints attached_points(std::size_t triangles, std::size_t points, bool is_one) {
  AttachedPoints lists{std::vector<std::uint32_t>(triangles, TriangleTree::kNone),
                       std::vector<std::uint32_t>(points, TriangleTree::kNone)};
  if (!is_one) return lists;
  lists.first[0] = 0;
  for (std::uint32_t i = 1; i < points; ++i) lists.next[i - 1] = i;
  return lists;
}

TEST(Certificate, AttachedPointsChangeNoAnswer) {
  const TriangleMesh coarse = square(0.5f);
  const TriangleMesh fine = fine_square(0, false);
  const TriangleMesh holed = fine_square(0, true);
  const PointTriangles coarse_fans(coarse);
  const std::vector<std::uint32_t> both = {0, 1};
  const std::vector<std::uint32_t> second = {1};
  for (const bool is_one : {false, true}) {
    const AttachedPoints attached =
        attached_points(coarse.triangles.size(), fine.points.size(), is_one);
    const auto unproven = [&](const TriangleMesh& other, double distance, const auto& some) {
      const PointTriangles fans(other);
      return unproven_triangles(coarse, some, TriangleTree(other), distance,
                                {attached, coarse_fans, fans}, NoProgress());
    };
    EXPECT_TRUE(unproven(fine, 0.51, both).empty());
    EXPECT_EQ(unproven(fine, 0.49, both), both);
    EXPECT_EQ(unproven(fine, 0.49, second), second);
    EXPECT_EQ(unproven(holed, 0.51, both), both);
    EXPECT_TRUE(unproven(holed, 2.2, both).empty());
  }
}

TEST(Certificate, TakesWhatIsKnownToBeProven) {
  const TriangleMesh fine = fine_square(0, false);
  const TriangleMesh coarse = square(0.5f);
  const TriangleTree tree(coarse);
  const std::vector<std::uint32_t> hints(fine.points.size(), 0);
  std::vector<std::uint8_t> is_by_hints(fine.triangles.size());
  EXPECT_TRUE(unproven_triangles(fine, tree, 0.51, NoProgress(), hints, is_by_hints).empty());
  // Triangle 0 of the coarse square lies below the diagonal, where y <= x.
  for (std::size_t i = 0; i < fine.triangles.size(); ++i) {
    const std::size_t x = i / 2 % 8;
    const std::size_t y = i / 16;
    const bool is_below = y < x || (y == x && i % 2 == 0);
    if (is_below) EXPECT_EQ(is_by_hints[i], 1) << i;
    else EXPECT_EQ(is_by_hints[i], 0) << i;
  }
  is_by_hints.assign(is_by_hints.size(), 1);
  is_by_hints[7] = 0;
  EXPECT_EQ(unproven_triangles(fine, tree, 0.49, NoProgress(), hints, is_by_hints),
            std::vector<std::uint32_t>{7});
}

TEST(Certificate, StopsWhenAskedTo) {
  const TriangleMesh fine = fine_square(0, false);
  const TriangleTree tree(fine);
  const PointTriangles fans(fine);
  const AttachedPoints attached =
      attached_points(fine.triangles.size(), fine.points.size(), false);
  const std::vector<std::uint32_t> first = {0};
  for (const bool is_attached : {false, true}) {
    const testing::StoppingProgress stopping(0);
    try {
      if (is_attached) unproven_triangles(fine, first, tree, 0.5, {attached, fans, fans}, stopping);
      else unproven_triangles(fine, tree, 0.5, stopping);
      FAIL() << "was not stopped";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled);
    }
  }
}

}  // namespace
}  // namespace octavo
