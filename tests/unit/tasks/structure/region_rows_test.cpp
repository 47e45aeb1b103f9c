#include "octavo/tasks/structure/region_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace octavo {
namespace {

MeasureResult one_region(bool is_in_mm) {
  MeasureResult result;
  result.percentiles = {5, 99.5};
  MeasuredRegion& one = result.regions.emplace_back();
  one.region.label = 7;
  one.region.voxel_count = 12;
  one.region.box = {{1, 2, 3}, {4, 5, 6}};
  one.region.centroid = {2, 3, 4};
  one.region.grey.emplace().percentiles = {-3, 40};
  if (is_in_mm) {
    RegionInMm& mm = one.in_mm.emplace();
    mm.centroid = {0.5, 1.5, 2.5};
    mm.axes = {{3, 2, 1}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  }
  return result;
}

const FactValue* find(const Facts& facts, const std::string& name) {
  for (const Fact& fact : facts) {
    if (fact.name == name) return &fact.value;
  }
  return nullptr;
}

double number(const Facts& facts, const std::string& name) {
  return std::get<double>(find(facts, name)->held());
}

TEST(RegionRows, ColumnsAreTheNumbersOfTheFacts) {
  const MeasureResult result = one_region(true);
  const Facts columns = columns_of(region_row(result.regions.front(), result));
  EXPECT_EQ(number(columns, "centroid_y_mm"), 1.5);
  EXPECT_EQ(number(columns, "centroid_z_voxel"), 4);
  EXPECT_EQ(std::get<std::int64_t>(find(columns, "box_y_hi")->held()), 5);
  EXPECT_EQ(std::get<std::int64_t>(find(columns, "box_z_lo")->held()), 3);
  EXPECT_EQ(number(columns, "principal_moment_2_mm2"), 2);
  EXPECT_EQ(number(columns, "principal_axis_3_z"), 1);
  EXPECT_EQ(number(columns, "principal_axis_3_x"), 0);
  EXPECT_EQ(number(columns, "p5"), -3);
  EXPECT_EQ(number(columns, "p99.5"), 40);
}

TEST(RegionRows, NamesOfColumnsDiffer) {
  MeasureResult result = one_region(true);
  result.percentiles = {50, 50.0000001, 99.99999};
  result.regions.front().region.grey->percentiles = {1, 2, 3};
  std::set<std::string> names;
  for (const Fact& column : columns_of(region_row(result.regions.front(), result))) {
    EXPECT_TRUE(names.insert(column.name).second) << column.name;
  }
}

TEST(RegionRows, WhatIsNotKnownHasItsColumnsAllTheSame) {
  const MeasureResult known = one_region(true);
  const MeasureResult unknown = one_region(false);
  const Facts with_mm = columns_of(region_row(known.regions.front(), known));
  const RegionRow row = region_row(unknown.regions.front(), unknown);
  const Facts without = columns_of(row);
  ASSERT_EQ(with_mm.size(), without.size());
  for (std::size_t i = 0; i < without.size(); ++i) EXPECT_EQ(with_mm[i].name, without[i].name);
  for (const char* name : {"mm3", "centroid_y_mm", "principal_axis_2_y", "integrated_mm3"}) {
    EXPECT_TRUE(std::holds_alternative<std::monostate>(find(without, name)->held())) << name;
  }
  EXPECT_EQ(number(without, "centroid_y_voxel"), 3);
  const Facts facts = facts_of(row);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(find(facts, "principal_axes")->held()));
}

TEST(RegionRows, WhatIsNoNumberStaysSo) {
  MeasureResult result = one_region(true);
  result.regions.front().region.grey->mean = std::nan("");
  const Facts columns = columns_of(region_row(result.regions.front(), result));
  EXPECT_TRUE(std::isnan(number(columns, "mean")));
}

TEST(RegionRows, ComponentsShareTheColumnsOfRegions) {
  const MeasureResult result = one_region(true);
  const Facts measured = columns_of(region_row(result.regions.front(), result));
  for (const Fact& column : columns_of(region_row(ComponentRow()))) {
    EXPECT_NE(find(measured, column.name), nullptr) << column.name;
  }
}

}  // namespace
}  // namespace octavo
