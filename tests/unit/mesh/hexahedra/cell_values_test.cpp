#include "octavo/mesh/hexahedra/cell_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace octavo {
namespace {

TEST(CellValues, DensitiesAreTheLineAlsoBelow0) {
  const std::vector<float> means = {-100, 0, 200, NAN};
  const std::vector<float> densities = densities_of(means, {0.01, 0.5});
  ASSERT_EQ(densities.size(), 4u);
  EXPECT_FLOAT_EQ(densities[0], -0.5f);
  EXPECT_FLOAT_EQ(densities[1], 0.5f);
  EXPECT_FLOAT_EQ(densities[2], 2.5f);
  EXPECT_TRUE(std::isnan(densities[3]));
  EXPECT_TRUE(std::isinf(densities_of(means, {1e300, 0})[2]));
}

TEST(CellValues, ModuliOfDensitiesBelow0AreThatOf0) {
  const std::vector<float> densities = {-2, 0, 2};
  EXPECT_EQ(moduli_of(densities, {1000, 2, 5}), (std::vector<float>{5, 5, 4000}));
  EXPECT_EQ(moduli_of(densities, {1000, 0, 5}), (std::vector<float>{1000, 1000, 1000}));
  EXPECT_TRUE(std::isinf(moduli_of(densities, {1e300, 50, 5})[2]));
}

TEST(CellValues, TheDensityOfAMaterialTakesThoseBelow0As0) {
  std::vector<HexCell> cells(2);
  CellValues values = {{-100, 100}, {-1, 3}, {1, 1}};
  const std::vector<HexGroup> groups = group_by_modulus(cells, values, 4);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_DOUBLE_EQ(groups[0].material->density_g_cm3, 1.5);
}

}  // namespace
}  // namespace octavo
