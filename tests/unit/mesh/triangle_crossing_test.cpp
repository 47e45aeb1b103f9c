#include "octavo/mesh/triangle_crossing.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(TriangleCrossing, TellsCrossingTouchingAndApart) {
  const TrianglePlaces flat = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const MeshTriangle one = {0, 1, 2};
  const MeshTriangle other = {3, 4, 5};
  const TrianglePlaces through = {{{1, 1, -1}, {1, 1, 1}, {9, 9, 1}}};
  const TrianglePlaces touching = {{{1, 1, 0}, {1, 1, 1}, {9, 9, 1}}};
  const TrianglePlaces above = {{{1, 1, 0.5}, {1, 2, 1}, {2, 1, 1}}};
  const TrianglePlaces beside = {{{5, 5, -1}, {5, 5, 1}, {9, 9, 1}}};
  const TrianglePlaces on_it = {{{1, 1, 0}, {2, 1, 0}, {1, 2, 0}}};
  const TrianglePlaces in_plane = {{{5, 5, 0}, {6, 5, 0}, {5, 6, 0}}};
  const TrianglePlaces in_line = {{{5, 0, 0}, {6, 0, 0}, {6, -1, 0}}};
  EXPECT_TRUE(do_cross(flat, one, through, other));
  EXPECT_TRUE(do_cross(flat, one, touching, other));
  EXPECT_TRUE(do_cross(flat, one, on_it, other));
  EXPECT_FALSE(do_cross(flat, one, above, other));
  EXPECT_FALSE(do_cross(flat, one, beside, other));
  EXPECT_FALSE(do_cross(flat, one, in_plane, other));
  EXPECT_FALSE(do_cross(flat, one, in_line, other));
}

TEST(TriangleCrossing, SharedCornersAndEdgesAreNoCrossing) {
  const TrianglePlaces flat = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const MeshTriangle one = {0, 1, 2};
  // At an edge: upright, flat beside it, folded onto it.
  EXPECT_FALSE(do_cross(flat, one, {{{4, 0, 0}, {0, 0, 0}, {0, 0, 4}}}, {1, 0, 3}));
  EXPECT_FALSE(do_cross(flat, one, {{{4, 0, 0}, {0, 0, 0}, {0, -4, 0}}}, {1, 0, 3}));
  EXPECT_TRUE(do_cross(flat, one, {{{4, 0, 0}, {0, 0, 0}, {1, 1, 0}}}, {1, 0, 3}));
  // At a corner: away from it, through it.
  EXPECT_FALSE(do_cross(flat, one, {{{0, 0, 0}, {-1, 0, 1}, {-1, 0, -1}}}, {0, 3, 4}));
  EXPECT_TRUE(do_cross(flat, one, {{{0, 0, 0}, {2, 2, 1}, {2, 2, -1}}}, {0, 3, 4}));
}

}  // namespace
}  // namespace octavo
