#include "octavo/tasks/structure/thickness_picture.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace octavo {
namespace {

ThicknessSummary summary_of(std::vector<std::uint64_t> bins) {
  ThicknessSummary summary;
  for (const std::uint64_t bin : bins) summary.voxels += bin;
  summary.bin_mm = 0.1;
  summary.mean_mm = 0.05 * static_cast<double>(bins.size());
  summary.bins = std::move(bins);
  return summary;
}

/// Rows that a bar of a share of the width covers, at most.
std::int64_t blue_rows(const Picture& picture, std::int64_t x) {
  std::int64_t rows = 0;
  for (std::int64_t y = 0; y < picture.height; ++y) {
    const auto at = static_cast<std::size_t>(3 * (y * picture.width + x));
    if (picture.pixels[at + 2] > picture.pixels[at] + 60) ++rows;
  }
  return rows;
}

TEST(ThicknessPicture, BarsAreAsHighAsTheirShares) {
  const Picture picture = thickness_picture(summary_of({10, 40, 20, 0}), {});
  const auto bar = [&](double middle) {
    return blue_rows(picture, 24 + static_cast<std::int64_t>(middle / 4 * 512));
  };
  EXPECT_EQ(bar(1.5), 220);
  EXPECT_EQ(bar(0.5), 55);
  EXPECT_EQ(bar(2.5), 110);
  EXPECT_EQ(bar(3.5), 0);
}

TEST(ThicknessPicture, WordsEndBeforeTheBorder) {
  ThicknessSummary tiny = summary_of({1, 1'000'000'000});
  tiny.mean_mm = 1.23456e-7;
  tiny.deviation_mm = 1.23456e-9;
  tiny.bin_mm = 1.2e-7;
  const Picture picture = thickness_picture({}, tiny);
  for (std::int64_t y = 0; y < 60; ++y) {
    for (std::int64_t x = picture.width - 12; x < picture.width; ++x) {
      const auto at = static_cast<std::size_t>(3 * (y * picture.width + x));
      ASSERT_GT(picture.pixels[at], 200) << x << ", " << y;
    }
  }
}

TEST(ThicknessPicture, HasAPanelForEachThatWasMeasured) {
  const ThicknessSummary some = summary_of(std::vector<std::uint64_t>(500, 7));
  const std::int64_t one = thickness_picture(some, {}).height;
  EXPECT_EQ(thickness_picture(some, some).height, 2 * one);
  EXPECT_EQ(thickness_picture({}, some).height, one);
  EXPECT_EQ(thickness_picture({}, {}).height, one);
}

}  // namespace
}  // namespace octavo
