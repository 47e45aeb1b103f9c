#include "octavo/ops/morphometry/surface_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "octavo/core/vectors.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

template <class Inside>
DenseMask filled(const Size3& size, const Point3& spacing, Inside inside) {
  DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  for_each_voxel(size, [&](const Index3& p) {
    mask.at(p) = inside((static_cast<double>(p.x) + 0.5) * spacing[0],
                        (static_cast<double>(p.y) + 0.5) * spacing[1],
                        (static_cast<double>(p.z) + 0.5) * spacing[2]) ? 1 : 0;
  });
  return mask;
}

template <class Inside>
SurfaceShape shape_of(const Size3& size, const Point3& spacing, Inside inside) {
  NoProgress progress;
  const MaskTree tree = testing::tree_of(filled(size, spacing, inside));
  return surface_shape(tree, nullptr, spacing, progress);
}

/// Of what lies in a region.
template <class Inside, class InRegion>
SurfaceShape shape_of(const Size3& size, const Point3& spacing, Inside inside,
                      InRegion in_region) {
  NoProgress progress;
  const MaskTree tree = testing::tree_of(filled(size, spacing, inside));
  const MaskTree region = testing::tree_of(filled(size, spacing, in_region));
  return surface_shape(tree, &region, spacing, progress);
}

TEST(SurfaceShape, OfSpheresIsTheirAreaAndItsGrowth) {
  const auto is_in = [](double x, double y, double z) {
    return (x - 25.1) * (x - 25.1) + (y - 24.8) * (y - 24.8) + (z - 25.4) * (z - 25.4) <= 20 * 20;
  };
  for (const Point3& spacing : {Point3{1, 1, 1}, Point3{0.8, 0.8, 1.2}}) {
    const Size3 size = {static_cast<std::int64_t>(50 / spacing[0]),
                        static_cast<std::int64_t>(50 / spacing[1]),
                        static_cast<std::int64_t>(50 / spacing[2])};
    const SurfaceShape shape = shape_of(size, spacing, is_in);
    EXPECT_NEAR(shape.area_mm2 / (4 * std::numbers::pi * 400), 1, 0.012);
    EXPECT_NEAR(shape.growth_mm / (8 * std::numbers::pi * 20), 1, 0.02);
    EXPECT_EQ(shape.cut_mm2, 0);
  }
}

TEST(SurfaceShape, OfPlatesDoesNotGrowAndEndsAreCut) {
  const SurfaceShape shape =
      shape_of({30, 40, 50}, {0.5, 0.5, 0.5}, [](double, double, double z) {
        return z > 10 && z < 14;
      });
  EXPECT_NEAR(shape.area_mm2, 2 * 15 * 20, 1e-6);
  EXPECT_NEAR(shape.growth_mm, 0, 1e-6);
  EXPECT_NEAR(shape.cut_mm2, 2 * 4 * (15 + 20), 1e-6);
}

/// The structure model index of a mask in a cube of voxels, without what its borders cut.
template <class Inside>
double model_index(std::int64_t side, const Point3& spacing, Inside inside) {
  DenseMask mask{{side, side, side},
                 std::vector<std::uint8_t>(static_cast<std::size_t>(side * side * side))};
  double voxels = 0;
  for_each_voxel(mask.size, [&](const Index3& p) {
    mask.at(p) = inside(p) ? 1 : 0;
    voxels += mask.at(p);
  });
  NoProgress progress;
  const SurfaceShape shape =
      surface_shape(testing::tree_of(mask), nullptr, spacing, progress);
  const double volume = voxels * spacing[0] * spacing[1] * spacing[2];
  return 6 * volume * shape.growth_mm / (shape.area_mm2 * shape.area_mm2);
}

const std::vector<Point3> kShapeSpacings = {{1, 1, 1}, {1, 1, 3}, {5, 1, 1}, {0.1, 1, 7}};

TEST(SurfaceShape, OfFlatPlatesAndGapsDoesNotGrowHoweverThinTheyAre) {
  for (const Point3& spacing : kShapeSpacings) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::int64_t thick : {1, 2, 3, 4, 5}) {
        EXPECT_NEAR(model_index(18, spacing, [&](const Index3& p) {
                      return p[axis] >= 6 && p[axis] < 6 + thick;
                    }), 0, 1e-9) << thick << " voxels along axis " << axis;
        EXPECT_NEAR(model_index(18, spacing, [&](const Index3& p) {
                      return p[axis] < 6 || p[axis] >= 6 + thick;
                    }), 0, 1e-9) << "gap of " << thick << " voxels along axis " << axis;
        EXPECT_NEAR(model_index(18, spacing, [&](const Index3& p) {
                      return p[axis] % (2 * thick) < thick;
                    }), 0, 1e-9) << "many of " << thick << " voxels along axis " << axis;
      }
    }
  }
}

TEST(SurfaceShape, OfThinRodsAndVoxelsAloneGrowsAsOfRodsAndBalls) {
  for (const std::int64_t thick : {1, 2, 3}) {
    for (int axis = 0; axis < 3; ++axis) {
      const int first = (axis + 1) % 3;
      const int second = (axis + 2) % 3;
      EXPECT_NEAR(model_index(18, {1, 1, 1}, [&](const Index3& p) {
                    return p[first] >= 7 && p[first] < 7 + thick && p[second] >= 7 &&
                           p[second] < 7 + thick;
                  }), 3, 0.35) << thick << " voxels along axis " << axis;
    }
    EXPECT_NEAR(model_index(18, {1, 1, 1}, [&](const Index3& p) {
                  return std::min({p.x, p.y, p.z}) >= 7 && std::max({p.x, p.y, p.z}) < 7 + thick;
                }), 4, 0.4) << thick << " voxels";
  }
}

TEST(SurfaceShape, OfThinTurnedPlatesAndRodsIsTheirs) {
  const Point3 across = unit({1, 1, 6});
  const Point3 along = unit({1, 2, 3});
  const auto from_middle = [](double x, double y, double z) {
    return Point3{x - 20.2, y - 19.9, z - 20.1};
  };
  for (const double thick : {2.0, 3.0, 4.0}) {
    // Of a part within a ball, so that no border counts.
    const auto is_near = [&](double x, double y, double z) {
      const Point3 p = from_middle(x, y, z);
      return dot(p, p) < 14 * 14;
    };
    const SurfaceShape plate = shape_of({40, 40, 40}, {1, 1, 1}, [&](double x, double y, double z) {
      return std::abs(dot(from_middle(x, y, z), across)) < 0.5 * thick;
    }, is_near);
    EXPECT_NEAR(plate.area_mm2 / (2 * std::numbers::pi * 14 * 14), 1, 0.05) << thick;
    EXPECT_NEAR(plate.growth_mm / plate.area_mm2 * thick, 0, 0.1) << thick;
    const SurfaceShape rod = shape_of({40, 40, 40}, {1, 1, 1}, [&](double x, double y, double z) {
      const Point3 p = from_middle(x, y, z);
      const double aside = dot(p, p) - dot(p, along) * dot(p, along);
      return aside < 0.25 * thick * thick;
    }, is_near);
    EXPECT_NEAR(rod.area_mm2 / (std::numbers::pi * thick * 28), 1, 0.08) << thick;
    EXPECT_NEAR(rod.growth_mm / (2 * std::numbers::pi * 28), 1, 0.1) << thick;
  }
}

TEST(SurfaceShape, OfBallsOfAFewLongVoxelsIsTheirArea) {
  for (const double slice : {3.0, 5.0}) {
    for (const double slices : {4.0, 8.0}) {
      const double radius = 0.5 * slices * slice;
      const auto side = static_cast<std::int64_t>(2 * radius) + 10;
      const double middle = 0.5 * static_cast<double>(side);
      const SurfaceShape shape =
          shape_of({side, side, 16}, {1, 1, slice}, [&](double x, double y, double z) {
            const Point3 p = {x - middle - 0.2, y - middle, z - 8.3 * slice};
            return dot(p, p) <= radius * radius;
          });
      EXPECT_NEAR(shape.area_mm2 / (4 * std::numbers::pi * radius * radius), 1,
                  slices > 4 ? 0.02 : 0.06) << slices << " slices of " << slice;
      EXPECT_NEAR(shape.growth_mm / (8 * std::numbers::pi * radius), 1,
                  slices > 4 ? 0.1 : 0.2) << slices << " slices of " << slice;
    }
  }
}

TEST(SurfaceShape, OfThinWallsThatCrossIsThatOfTheirFaces) {
  for (const std::int64_t thick : {2, 3}) {
    const auto is_wall = [&](double x, double y, double) {
      return static_cast<std::int64_t>(x) % 16 < thick || static_cast<std::int64_t>(y) % 16 < thick;
    };
    const auto is_cell = [](double x, double y, double z) {
      return std::min({x, y, z}) > 10 && std::max({x, y, z}) < 42;
    };
    const SurfaceShape shape = shape_of({52, 52, 52}, {1, 1, 1}, is_wall, is_cell);
    // Four sides of the cells between walls, of which there are two by two.
    const double faces = 4 * 4.0 * static_cast<double>(16 - thick) * 32;
    EXPECT_NEAR(shape.area_mm2 / faces, 1, 0.05) << thick;
  }
}

/// The sum of waves of one length in directions that are spread over a sphere: thin, irregular.
double wave_sum(const Point3& place, double length) {
  constexpr int kWaves = 16;
  double sum = 0;
  for (int i = 0; i < kWaves; ++i) {
    const double z = 1 - (2 * i + 1.0) / kWaves;
    const double turn = 2.399963 * i;
    const Point3 along = {std::sqrt(1 - z * z) * std::cos(turn),
                          std::sqrt(1 - z * z) * std::sin(turn), z};
    sum += std::sin(2 * std::numbers::pi / length * dot(place, along) + 1.7 * i * i);
  }
  return sum;
}

TEST(SurfaceShape, OfThinIrregularStructuresIsThatOfFinerVoxels) {
  constexpr double kLength = 6;
  const auto is_in = [](double x, double y, double z) {
    return wave_sum({x, y, z}, kLength) > 1;
  };
  const auto is_near = [](double x, double y, double z) {
    return std::min({x, y, z}) > 5 && std::max({x, y, z}) < 21;
  };
  const SurfaceShape coarse = shape_of({26, 26, 26}, {1, 1, 1}, is_in, is_near);
  const SurfaceShape fine = shape_of({78, 78, 78}, {1. / 3, 1. / 3, 1. / 3}, is_in, is_near);
  EXPECT_NEAR(coarse.area_mm2 / fine.area_mm2, 1, 0.05);
}

TEST(SurfaceShape, OfAGyroidIsThatOfItsUnitCells) {
  constexpr double kWave = 2 * std::numbers::pi / 30;
  const SurfaceShape shape = shape_of({60, 60, 60}, {1, 1, 1}, [](double x, double y, double z) {
    return std::sin(kWave * x) * std::cos(kWave * y) + std::sin(kWave * y) * std::cos(kWave * z) +
               std::sin(kWave * z) * std::cos(kWave * x) > 0;
  });
  // The trigonometric surface has 3.0919 times the square of its cell's side.
  EXPECT_NEAR(shape.area_mm2 / (8 * 3.0919 * 30 * 30), 1, 0.015);
}

}  // namespace
}  // namespace octavo
