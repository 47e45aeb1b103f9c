#include "octavo/io/source/length_unit.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace octavo {
namespace {

TEST(LengthUnit, IsThatOfItsNamesWhateverTheirCase) {
  const std::vector<std::pair<std::string, double>> units = {
      {"mm", 1},          {"Micrometer", 1e-3}, {"\xc2\xb5m", 1e-3}, {"inch", 25.4},
      {"angstrom", 1e-7}, {"picometer", 1e-9},  {"ft", 304.8},       {"yard", 914.4},
      {"mile", 1609344},  {"kilometer", 1e6},   {"fm", 1e-12},
      {"\xc3\x85", 1e-7}, {"\xe2\x84\xab", 1e-7}, {"\xc5", 1e-7},     {"mi", 1609344}};
  for (const auto& [name, mm] : units) EXPECT_EQ(unit_in_mm(name), mm) << name;
  EXPECT_EQ(unit_in_mm("furlong"), std::nullopt);
}

}  // namespace
}  // namespace octavo
