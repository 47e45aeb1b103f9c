#include "octavo/render/rays/transfer_function.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace octavo {
namespace {

TEST(TransferFunction, ValuesBetweenPointsAreMixed) {
  const TransferFunction transfer{
      {{0, {0, 100, 200}, 0}, {10, {100, 200, 0}, 0.5}, {10, {1, 2, 3}, 1}}, {}, false};
  EXPECT_EQ(transfer.color_at(5), (Color{50, 150, 100}));
  EXPECT_EQ(transfer.opacity_at(5), 0.25);
  EXPECT_EQ(transfer.opacity_at(-100), 0);
  EXPECT_EQ(transfer.opacity_at(10), 1);
  EXPECT_EQ(transfer.color_at(1000), (Color{1, 2, 3}));
}

TEST(TransferFunction, PresetsRiseAndBeginUnseen) {
  for (const TransferPreset& preset : transfer_presets()) {
    const auto transfer = find_transfer_preset(preset.name);
    ASSERT_TRUE(transfer) << preset.name;
    EXPECT_EQ(transfer->is_relative, !preset.is_in_hu);
    EXPECT_EQ(transfer->points.front().opacity, 0) << preset.name;
    EXPECT_TRUE(std::is_sorted(
        transfer->points.begin(), transfer->points.end(),
        [](const TransferPoint& a, const TransferPoint& b) { return a.value < b.value; }));
  }
  EXPECT_FALSE(find_transfer_preset("Bone"));
}

TEST(TransferFunction, SharesOfAWindowBecomeRealValues) {
  const TransferFunction shares{{{0, {}, 0}, {1, {}, 1}}, {}, true};
  const TransferFunction real = in_real_values(shares, {100, 50});
  EXPECT_EQ(real.points[0].value, 75);
  EXPECT_EQ(real.points[1].value, 125);
  EXPECT_FALSE(real.is_relative);
  EXPECT_EQ(in_real_values(real, {0, 1}), real);
  const TransferFunction steep{{{0, {}, 0}}, {}, true, GradientRamp{0.1, 0.2}};
  EXPECT_EQ(in_real_values(steep, {100, 50}).gradient, (GradientRamp{5, 10}));
}

TEST(TransferTable, StepsOfAnyLengthComposeToOneLayer) {
  const TransferFunction transfer{{{0, {}, 0.4}, {100, {}, 0.4}}, {}, false};
  for (const double share : {0.25, 1.0, 2.0}) {
    const TransferTable table(transfer, {}, {}, {0, 100}, share);
    EXPECT_NEAR(std::pow(1 - table.table().opacities[7], 1 / share), 0.6, 1e-6);
  }
}

TEST(TransferTable, WhatLiesBetweenTheEndsOfAStepIsSeen) {
  const TransferFunction peak{
      {{100, {255, 0, 0}, 0}, {110, {255, 0, 0}, 0.5}, {120, {255, 0, 0}, 0}}, {}, false, {}};
  const TransferTable table(peak, {}, {}, {0, 1000}, 1);
  const ColorTable entries = table.table();
  const std::int32_t across = ColorTable::kSide - 1;
  // Two hundredths of a step from 0 to 1000 cross the peak, of a mean extinction of 0.307.
  EXPECT_NEAR(entries.opacities[across], 0.02 * 0.307, 0.0003);
  EXPECT_EQ(entries.colors[across], 255u);
  EXPECT_EQ(entries.opacities[0], 0);
  EXPECT_EQ(entries.opacities[across * ColorTable::kSide + across], 0);
}

TEST(TransferTable, WhatHasNoOpacityIsNotSeen) {
  const TransferFunction transfer{{{100, {}, 0}, {200, {}, 0}, {300, {}, 1}}, {}, false};
  const TransferTable table(transfer, {}, {}, {-1000, 1000}, 1);
  EXPECT_FALSE(table.is_seen(-900, 199));
  EXPECT_TRUE(table.is_seen(-900, 201));
  EXPECT_TRUE(table.is_seen(500, 600));
}

/// The opacity of a layer of one value.
double opacity_of(const TransferTable& made, float value) {
  const ColorTable table = made.table();
  float entry = 0;
  for (const ColorTable::Piece& piece : table.pieces) {
    entry += std::clamp((value - piece.begin) * piece.entries_per_value, 0.0f, piece.entries);
  }
  const std::int32_t place = std::min(static_cast<std::int32_t>(entry), ColorTable::kSide - 1);
  return table.opacities[place * (ColorTable::kSide + 1)];
}

TEST(TransferTable, TheEndsOfAllValuesHaveWhatTheFunctionSays) {
  const SampleRange range = {0, 255};
  for (const double rise : {50.0, 200.0, 255.0, 300.0}) {
    const TransferFunction rising{{{0, {}, 0}, {rise, {}, 0.2}}, {}, false};
    const TransferTable table(rising, {}, {}, range, 1);
    EXPECT_NEAR(opacity_of(table, 255), rising.opacity_at(255), 1e-3) << rise;
    EXPECT_EQ(opacity_of(table, 0), 0) << rise;
    EXPECT_TRUE(table.is_seen(255, 255));
    EXPECT_FALSE(table.is_seen(0, 0));
    const TransferFunction falling{{{255 - rise, {}, 0.2}, {255, {}, 0}}, {}, false};
    const TransferTable turned(falling, {}, {}, range, 1);
    EXPECT_NEAR(opacity_of(turned, 0), falling.opacity_at(0), 1e-3) << rise;
    EXPECT_EQ(opacity_of(turned, 255), 0) << rise;
  }
  // Alike everywhere, and of one value alone.
  const TransferFunction plain{{{100, {}, 0.3}}, {}, false};
  for (const double highest : {0.0, 100.0, 255.0}) {
    const TransferTable table(plain, {}, {}, {0, highest}, 1);
    EXPECT_NEAR(opacity_of(table, static_cast<float>(highest)), 0.3, 1e-6) << highest;
    EXPECT_NEAR(opacity_of(table, 0), 0.3, 1e-6) << highest;
  }
}

TEST(TransferTable, StepsBelongToTheValuesAbove) {
  for (const double at : {0.0, 100.0, 255.0}) {
    const TransferFunction step{{{at, {}, 0}, {at, {}, 0.5}, {300, {}, 0.5}}, {}, false};
    for (const double slope : {1.0, -1.0}) {
      const SampleRange range = slope > 0 ? SampleRange{0, 255} : SampleRange{-255, 0};
      const TransferTable table(step, {slope, 0}, {}, range, 1);
      const auto value = [&](double real) { return static_cast<float>(real * slope); };
      EXPECT_NEAR(opacity_of(table, value(at)), 0.5, 1e-3) << at << " " << slope;
      if (at > 0) {
        EXPECT_EQ(opacity_of(table, value(at - 1)), 0) << at << " " << slope;
      }
    }
  }
}

TEST(TransferTable, AFallingScaleTurnsValuesRound) {
  const TransferFunction transfer{{{-50, {}, 0}, {-10, {255, 0, 0}, 1}}, {}, false};
  const TransferTable table(transfer, {-1, 0}, {}, {0, 1000}, 1);
  EXPECT_TRUE(table.is_seen(0, 5));
  EXPECT_FALSE(table.is_seen(60, 900));
}

}  // namespace
}  // namespace octavo
