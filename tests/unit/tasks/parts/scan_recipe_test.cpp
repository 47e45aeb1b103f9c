#include "octavo/tasks/parts/scan_recipe.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"

namespace octavo {
namespace {

ScanRecipe full_recipe() {
  ScanRecipe recipe;
  SourceOptions& source = recipe.scan.source;
  source.raw = RawLayout{{7, 8, 9}, WideType::int64, true, 512};
  source.spacing_mm = Point3{0.1, 1.0 / 3, 7};
  source.series = "1.2.840";
  source.on_gap = GapPolicy::resample;
  source.drop_duplicates = true;
  source.untilt = true;
  source.segment = "left \"lung\"";
  source.channel = "red";
  source.time = 3;
  source.keep_identity = true;
  recipe.scan.is_isolated = false;
  recipe.between = PlaneInterpolation::cubic;
  recipe.has_given_names = true;
  recipe.words = {"transform", "a.8vo", "--rotate", "z:30"};
  recipe.root = "/data/";
  return recipe;
}

TEST(ScanRecipe, ReadBackItIsTheSame) {
  const ScanRecipe again = parse_recipe(recipe_text(full_recipe()));
  const SourceOptions& source = again.scan.source;
  ASSERT_TRUE(source.raw);
  EXPECT_EQ(source.raw->size, (Size3{7, 8, 9}));
  EXPECT_EQ(source.raw->type, StoredType(WideType::int64));
  EXPECT_TRUE(source.raw->big_endian);
  EXPECT_EQ(source.raw->header_bytes, 512u);
  EXPECT_EQ(source.spacing_mm, (Point3{0.1, 1.0 / 3, 7}));
  EXPECT_EQ(source.on_gap, GapPolicy::resample);
  EXPECT_EQ(source.segment, "left \"lung\"");
  EXPECT_EQ(source.time, 3);
  EXPECT_FALSE(again.scan.is_isolated);
  EXPECT_EQ(again.between, PlaneInterpolation::cubic);
  EXPECT_EQ(again.words, full_recipe().words);
  EXPECT_EQ(recipe_text(again), recipe_text(full_recipe()));
}

TEST(ScanRecipe, TheDefaultIsEmpty) {
  EXPECT_EQ(recipe_text(ScanRecipe()), "{}");
  EXPECT_TRUE(parse_recipe("{}").scan.is_isolated);
}

TEST(ScanRecipe, WhatIsNotUnderstoodIsRejected) {
  for (const char* const text :
       {R"({"new_option":1})", R"({"scan.on_gap":"leap"})", R"({"raw":[1,2]})", R"({"untilt":1})",
        R"({"spacing_mm":[1]})", R"({"between":"spline"})", R"({"words":[1]})", R"({"series":)",
        R"({"raw":[1,2,3,0],"raw_type":"int3"})", "[]", ""}) {
    EXPECT_THROW(parse_recipe(text), Error) << text;
  }
}

TEST(ScanRecipe, EveryShortenedTextIsRejected) {
  const std::string text = recipe_text(full_recipe());
  for (std::size_t length = 0; length < text.size(); ++length) {
    EXPECT_THROW(parse_recipe(text.substr(0, length)), Error) << length;
  }
}

}  // namespace
}  // namespace octavo
