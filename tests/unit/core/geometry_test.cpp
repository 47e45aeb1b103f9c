#include "octavo/core/geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace octavo {
namespace {

// Turned by a quarter around z, then flipped along z: x runs to world y, y to world -x.
Geometry turned() {
  return {{10, -20, 5.5}, {0.5, 2, 3}, {0, -1, 0, 1, 0, 0, 0, 0, -1}};
}

TEST(Geometry, WorldIsOriginPlusDirectionTimesSpacedIndex) {
  EXPECT_EQ(turned().to_world({0, 0, 0}), (Point3{10, -20, 5.5}));
  EXPECT_EQ(turned().to_world({1, 0, 0}), (Point3{10, -19.5, 5.5}));
  EXPECT_EQ(turned().to_world({0, 1, 0}), (Point3{8, -20, 5.5}));
  EXPECT_EQ(turned().to_world({2, 4, 0.5}), (Point3{2, -19, 4}));
}

TEST(Geometry, IndexLeadsBackAlsoWhereAxesAreSkewed) {
  Geometry skewed = turned();
  skewed.direction = {0.8, -0.6, 0.1, 0.6, 0.8, 0, 0, 0.2, 1};
  for (const Geometry& geometry : {turned(), skewed}) {
    for (const Point3& index : {Point3{0, 0, 0}, Point3{3, -1, 2.25}, Point3{100, 511, 47}}) {
      const Point3 back = geometry.to_index(geometry.to_world(index));
      for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(back[axis], index[axis], 1e-9);
    }
  }
}

TEST(Geometry, OfACropPutsItsVoxelsWhereTheyWere) {
  const Geometry crop = cropped(turned(), {3, 5, 7});
  EXPECT_EQ(crop.to_world({0, 0, 0}), turned().to_world({3, 5, 7}));
  EXPECT_EQ(crop.to_world({1, 2, 3}), turned().to_world({4, 7, 10}));
}

TEST(Geometry, WhatNoVoxelCanHaveIsInvalid) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(is_valid(turned()));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double bad : {0.0, -1.0, kInf, std::nan("")}) {
      Geometry geometry = turned();
      geometry.spacing_mm[axis] = bad;
      EXPECT_FALSE(is_valid(geometry)) << axis << ' ' << bad;
    }
    for (const double bad : {kInf, -kInf, std::nan("")}) {
      Geometry geometry = turned();
      geometry.origin_mm[axis] = bad;
      EXPECT_FALSE(is_valid(geometry)) << axis << ' ' << bad;
    }
  }
  for (std::size_t i = 0; i < 9; ++i) {
    Geometry geometry = turned();
    geometry.direction[i] = std::nan("");
    EXPECT_FALSE(is_valid(geometry)) << i;
  }
  Geometry flat = turned();
  flat.direction = {1, 0, 1, 0, 1, 0, 1, 0, 1};
  EXPECT_FALSE(is_valid(flat));
}

TEST(Geometry, AxesCountAsUnitVectorsWithinAThousandth) {
  for (const auto& [length, is_unit] : std::vector<std::pair<double, bool>>{
           {1, true}, {0.9995, true}, {1.0005, true}, {0.998, false}, {1.002, false}, {2, false},
           {0, false}}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Geometry geometry = turned();
      for (std::size_t row = 0; row < 3; ++row) geometry.direction[row * 3 + axis] *= length;
      EXPECT_EQ(has_unit_axes(geometry), is_unit) << axis << ' ' << length;
      EXPECT_NEAR(axis_length(geometry, axis), length, 1e-12);
    }
  }
}

TEST(Geometry, TheCosineOfTwoAxesIsZeroWhereTheyArePerpendicular) {
  Geometry geometry = turned();
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      EXPECT_DOUBLE_EQ(axis_cosine(geometry, a, b), a == b ? 1 : 0);
    }
  }
  geometry.direction = {2, 3, 0, 0, 3, 0, 0, 0, 1};
  EXPECT_NEAR(axis_cosine(geometry, 0, 1), std::sqrt(0.5), 1e-12);
  geometry.direction = {0, 3, 0, 0, 3, 0, 0, 0, 1};
  EXPECT_TRUE(std::isnan(axis_cosine(geometry, 0, 1)));
}

TEST(Box, UnitedIsTheSmallestAroundBothAndNothingAddsNothing) {
  const Box a{{1, 5, 3}, {2, 6, 9}};
  const Box b{{0, 7, 4}, {1, 8, 5}};
  EXPECT_EQ(united(a, b), (Box{{0, 5, 3}, {2, 8, 9}}));
  for (const Box& empty : {Box{}, Box{{4, 4, 4}, {4, 9, 9}}, Box{{4, 4, 4}, {9, 3, 9}},
                           Box{{4, 4, 4}, {9, 9, 4}}}) {
    EXPECT_TRUE(empty.is_empty());
    EXPECT_EQ(united(a, empty), a);
    EXPECT_EQ(united(empty, a), a);
  }
}

TEST(Box, ContainsIsHalfOpenOnEveryAxis) {
  const Box box{{1, 2, 3}, {5, 6, 7}};
  EXPECT_TRUE(box.contains(Index3{1, 2, 3}));
  EXPECT_TRUE(box.contains(Index3{4, 5, 6}));
  EXPECT_TRUE(box.contains(box));
  for (int axis = 0; axis < 3; ++axis) {
    Index3 below = box.lo;
    --below[axis];
    EXPECT_FALSE(box.contains(below));
    Index3 beyond = box.lo;
    beyond[axis] = box.hi[axis];
    EXPECT_FALSE(box.contains(beyond));
    Box wider = box;
    --wider.lo[axis];
    EXPECT_FALSE(box.contains(wider));
    wider = box;
    ++wider.hi[axis];
    EXPECT_FALSE(box.contains(wider));
    EXPECT_TRUE(wider.contains(box));
  }
}

TEST(VisitCells, VisitsThoseTheBoxMeetsUntilToldToStop) {
  std::vector<Index3> met;
  const Box box{{3, 0, 4}, {5, 4, 6}};
  visit_cells(box, {4, 4, 2}, [&](const Index3& cell) {
    met.push_back(cell);
    return true;
  });
  EXPECT_EQ(met, (std::vector<Index3>{{0, 0, 2}, {1, 0, 2}}));
  met.clear();
  visit_cells(box, {4, 1, 1}, [&](const Index3& cell) {
    met.push_back(cell);
    return met.size() < 3;
  });
  EXPECT_EQ(met, (std::vector<Index3>{{0, 0, 4}, {1, 0, 4}, {0, 1, 4}}));
}

}  // namespace
}  // namespace octavo
