#include "octavo/render/slice/overlay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "octavo/core/error.h"
#include "octavo/render/color_scale.h"
#include "octavo/render/label_color.h"
#include "octavo/render/slice/isolines.h"
#include "octavo/render/slice/montage.h"
#include "octavo/render/slice/outline.h"
#include "support/built_file.h"
#include "support/memory_reader.h"
#include "support/read_png.h"

namespace octavo {
namespace {

using testing::pixel;

SectionSamples random_labels(std::int64_t width, std::int64_t height, std::mt19937& random) {
  SectionSamples labels{width, height,
                        std::vector<double>(static_cast<std::size_t>(width * height))};
  for (int i = 0; i < 12; ++i) {
    const auto x = static_cast<std::int64_t>(random()) % width;
    const auto y = static_cast<std::int64_t>(random()) % height;
    const auto label = static_cast<double>(random() % 4);
    for (std::int64_t v = y; v < std::min(height, y + 9); ++v) {
      for (std::int64_t u = x; u < std::min(width, x + 14); ++u) {
        labels.values[static_cast<std::size_t>(v * width + u)] = label == 3 ? std::nan("") : label;
      }
    }
  }
  return labels;
}

double label_at(const SectionSamples& labels, std::int64_t x, std::int64_t y) {
  const double label = labels.at(x, y);
  return std::isnan(label) ? 0 : label;
}

bool is_border(const SectionSamples& labels, std::int64_t x, std::int64_t y) {
  if (label_at(labels, x, y) == 0) return false;
  for (std::int64_t v = 0; v < labels.height; ++v) {
    for (std::int64_t u = 0; u < labels.width; ++u) {
      const bool is_beside = std::abs(u - x) + std::abs(v - y) == 1;
      if (is_beside && label_at(labels, u, v) != label_at(labels, x, y)) return true;
    }
  }
  return false;
}

TEST(Outline, IsTheBorderOfEachLabel) {
  std::mt19937 random(8);
  for (int round = 0; round < 8; ++round) {
    const SectionSamples labels = random_labels(40, 30, random);
    for (const std::int64_t thickness : {1, 2, 4}) {
      const std::vector<std::uint8_t> found = label_outlines(labels, thickness);
      for (std::int64_t y = 0; y < labels.height; ++y) {
        for (std::int64_t x = 0; x < labels.width; ++x) {
          bool expected = false;
          for (std::int64_t v = 0; v < labels.height && !expected; ++v) {
            for (std::int64_t u = 0; u < labels.width && !expected; ++u) {
              const auto reach = static_cast<double>(thickness - 1);
              expected = std::hypot(u - x, v - y) <= reach + 1e-9 &&
                         label_at(labels, u, v) == label_at(labels, x, y) &&
                         is_border(labels, u, v);
            }
          }
          ASSERT_EQ(found[static_cast<std::size_t>(y * labels.width + x)] != 0, expected);
        }
      }
    }
  }
}

/// A grid of 60 x 50 x 4 voxels of 1 mm under a picture, and overlays on grids of their own.
class Overlays : public ::testing::Test {
 protected:
  static constexpr Size3 kSize = {60, 50, 4};

  /// value(world) at the voxels of a grid that covers the picture.
  template <class F>
  std::shared_ptr<const FileReader> volume(const std::string& name, VolumeKind kind, double spacing,
                                           F value) {
    testing::Volume v;
    v.description.kind = kind;
    v.description.type = kind == VolumeKind::labels ? VoxelType::uint8 : VoxelType::int16;
    v.description.geometry.spacing_mm = {spacing, spacing, spacing};
    v.description.geometry.origin_mm = {-3, -3, -3};
    const auto side = [&](std::int64_t mm) {
      return static_cast<std::int64_t>(std::ceil(static_cast<double>(mm + 6) / spacing)) + 1;
    };
    v.description.size = {side(kSize.x), side(kSize.y), side(kSize.z)};
    const Size3& size = v.description.size;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          const Point3 world = v.description.geometry.to_world(
              {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
          const auto number = static_cast<std::int16_t>(std::lround(value(world)));
          const auto* bytes = reinterpret_cast<const std::byte*>(&number);
          v.voxels.insert(v.voxels.end(), bytes, bytes + (kind == VolumeKind::labels ? 1 : 2));
        }
      }
    }
    testing::build_volume(v, folder_.file(name), 1);
    return testing::open_file(folder_.file(name));
  }

  Overlay overlay(std::shared_ptr<const FileReader> reader) const {
    Overlay made;
    made.reader = std::move(reader);
    made.name = "over";
    return made;
  }

  Picture drawn(const Overlay& overlay, OverlayLegend& legend, std::int64_t side = 60) const {
    const PlaneSection section = axis_section({}, kSize, 2, 2, side);
    Picture picture = make_picture(section.width, section.height, 3);
    draw_overlay(picture, {0, 0, picture.width, picture.height}, section, decided(overlay), legend);
    return picture;
  }

  testing::ScratchFolder folder_;
};

TEST_F(Overlays, AMaskOnAnotherGridLiesWhereItLies) {
  const auto is_inside = [](const Point3& p) {
    return p[0] > 10 && p[0] < 40 && p[1] > 8 && p[1] < 30;
  };
  const auto mask = volume("m.8vo", VolumeKind::labels, 0.5,
                           [&](const Point3& p) { return is_inside(p) ? 1 : 0; });
  OverlayLegend legend;
  Overlay wash = overlay(mask);
  wash.look.kind = OverlayKind::wash;
  wash.look.opacity = 1;
  wash.look.color = Color{255, 0, 0};
  const Picture picture = drawn(wash, legend);
  for (std::int64_t y = 0; y < 50; ++y) {
    for (std::int64_t x = 0; x < 60; ++x) {
      const Point3 at{static_cast<double>(x), static_cast<double>(y), 2};
      EXPECT_EQ(pixel(picture, x, y), (is_inside(at) ? Color{255, 0, 0} : Color{0, 0, 0}));
    }
  }
  ASSERT_EQ(legend.rows.size(), 1u);
  EXPECT_EQ(legend.rows[0].text, "over");
  EXPECT_EQ(legend.rows[0].color, (Color{255, 0, 0}));

  // The outline is drawn on its border alone, in the color of the overlay's number.
  const Picture outline = drawn(overlay(mask), legend);
  for (std::int64_t y = 0; y < 50; ++y) {
    for (std::int64_t x = 0; x < 60; ++x) {
      const bool is_edge =
          (x == 11 || x == 39 || y == 9 || y == 29) && x >= 11 && x <= 39 && y >= 9 && y <= 29;
      EXPECT_EQ(pixel(outline, x, y), is_edge ? overlay_color(0) : (Color{0, 0, 0}))
          << x << " " << y;
    }
  }
}

TEST_F(Overlays, LabelsHaveTheirNamesAndColorsTheLargestFirst) {
  const auto labels = volume("l.8vo", VolumeKind::labels, 1, [](const Point3& p) {
    return p[0] < 10 ? 7 : p[0] < 40 ? 3 : p[1] < 5 ? 9 : 0;
  });
  Overlay named = overlay(labels);
  named.labels.set(7, {"Putamen", LabelColor{1, 2, 3}});
  OverlayLegend legend;
  drawn(named, legend);
  ASSERT_EQ(legend.rows.size(), 3u);
  EXPECT_EQ(legend.rows[0].text, "label 3");
  EXPECT_EQ(legend.rows[0].color, label_color(3));
  EXPECT_EQ(legend.rows[1].text, "Putamen");
  EXPECT_EQ(legend.rows[1].color, (Color{1, 2, 3}));
  EXPECT_EQ(legend.rows[2].text, "label 9");

  // Of several sections together: what is small in the first is large in all.
  const auto turned = volume("t.8vo", VolumeKind::labels, 1, [](const Point3& p) {
    return p[2] < 1 ? (p[0] < 40 ? 5 : 1) : p[0] < 30 ? 1 : 5;
  });
  OverlayLegend sheet;
  for (const std::int64_t z : {0, 2, 3}) {
    const PlaneSection section = axis_section({}, kSize, 2, z, 60);
    Picture picture = make_picture(section.width, section.height, 3);
    draw_overlay(picture, {0, 0, picture.width, picture.height}, section,
                 decided(overlay(turned)), sheet);
  }
  ASSERT_EQ(sheet.rows.size(), 2u);
  const std::map<std::int64_t, std::int64_t> pixels = {{1, 80 * 50}, {5, 100 * 50}};
  EXPECT_EQ(sheet.pixels_of_label, pixels);
  EXPECT_EQ(sheet.rows[0].text, "label 5");
  EXPECT_EQ(sheet.rows[1].text, "label 1");
}

TEST_F(Overlays, AWashOfGreyValuesBeginsAtItsLowerLevel) {
  const auto dose = volume("d.8vo", VolumeKind::grey, 3, [](const Point3& p) { return 10 * p[0]; });
  Overlay wash = overlay(dose);
  wash.look.kind = OverlayKind::wash;
  wash.look.levels = {100, 500};
  wash.look.opacity = 1;
  OverlayLegend legend;
  const Picture picture = drawn(wash, legend);
  for (std::int64_t x = 0; x < 60; ++x) {
    const double value = 10 * static_cast<double>(x);
    const Color expected = value < 100 ? Color{0, 0, 0} : scale_color((value - 100) / 400);
    const Color found = pixel(picture, x, 20);
    // Between voxels 3 mm apart the values are interpolated, rounded at the voxels.
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], x == 10 ? 255 : 2) << x;
  }
  EXPECT_EQ(legend.scale_ends[0], "100");
  EXPECT_FALSE(legend.scale.empty());
}

TEST_F(Overlays, IsolinesAreDrawnAlongTheirLevels) {
  const auto dose = volume("d.8vo", VolumeKind::grey, 2, [](const Point3& p) {
    return 1000 - 20 * std::hypot(p[0] - 30, p[1] - 25);
  });
  Overlay lines = overlay(dose);
  lines.look.levels = {700, 900};
  lines.unit = "cGy";
  OverlayLegend legend;
  const Picture picture = drawn(lines, legend, 240);
  const PlaneSection section = axis_section({}, kSize, 2, 2, 240);
  const SectionSamples samples = sample_section(*dose, 0, section, SampleInterpolation::linear);
  // Pixels of the color of a level are those near a line of it.
  for (std::size_t i = 0; i < 2; ++i) {
    const Color color = scale_colors(2)[i];
    StrokeMask near({0, 0, picture.width, picture.height}, 1.4);
    for (const Isoline& line : isolines(samples, lines.look.levels[i])) near.add(line);
    std::int64_t colored = 0;
    std::int64_t on_line = 0, colored_on_line = 0;
    for (std::int64_t y = 0; y < picture.height; ++y) {
      for (std::int64_t x = 0; x < picture.width; ++x) {
        const bool is_colored = pixel(picture, x, y) == color;
        colored += is_colored ? 1 : 0;
        if (near.coverage(x, y) != 255) continue;
        ++on_line;
        colored_on_line += is_colored ? 1 : 0;
      }
    }
    // All but those under the value that stands on the line.
    EXPECT_GT(colored, 20);
    EXPECT_GT(colored_on_line, on_line * 3 / 4);
  }
  ASSERT_EQ(legend.rows.size(), 2u);
  EXPECT_EQ(legend.rows[0].text, "900 cGy");
  EXPECT_EQ(legend.rows[1].text, "700 cGy");
}

TEST_F(Overlays, LevelsAreRoundWhereNoneAreAsked) {
  const auto dose =
      volume("d.8vo", VolumeKind::grey, 2, [](const Point3& p) { return p[0] < 20 ? 0 : p[0]; });
  Overlay lines = overlay(dose);
  EXPECT_EQ(decided(lines).look.levels, (std::vector<double>{10, 20, 30, 40, 50, 60}));
  lines.look.kind = OverlayKind::wash;
  EXPECT_EQ(decided(lines).look.levels, (std::vector<double>{10, 70}));
}

TEST_F(Overlays, LevelsEndWithMostVoxelsWhereNobodyKnowsTheHighest) {
  const Size3 size{70, 20, 20};
  std::vector<float> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<float>(i % 70);
  voxels[7] = 1e30f;
  const auto dose = std::make_shared<testing::MemoryReader>(
      testing::reader_of_unbounded(size, voxels));
  EXPECT_EQ(decided(overlay(dose)).look.levels, (std::vector<double>{10, 20, 30, 40, 50, 60}));
}

TEST_F(Overlays, WhatDoesNotGoTogetherIsRejected) {
  const auto mask = volume("m.8vo", VolumeKind::labels, 1, [](const Point3&) { return 1; });
  const auto dose = volume("d.8vo", VolumeKind::grey, 1, [](const Point3& p) { return p[0]; });
  const auto rejects = [&](const auto& reader, auto change) {
    Overlay bad = overlay(reader);
    change(bad.look);
    EXPECT_THROW(decided(bad), Error);
  };
  rejects(mask, [](OverlayLook& look) { look.kind = OverlayKind::isolines; });
  rejects(mask, [](OverlayLook& look) { look.levels = {1}; });
  rejects(mask, [](OverlayLook& look) { look.opacity = 1.5; });
  rejects(dose, [](OverlayLook& look) { look.kind = OverlayKind::outline; });
  rejects(dose, [](OverlayLook& look) { look.levels = {3, 2}; });
  rejects(dose, [](OverlayLook& look) { look.levels = {std::nan("")}; });
  rejects(dose, [](OverlayLook& look) { look.kind = OverlayKind::wash, look.levels = {1}; });
  rejects(dose, [](OverlayLook& look) { look.kind = OverlayKind::wash, look.color = Color{}; });
}

TEST(Montage, SlicesAreSpreadOrSpaced) {
  EXPECT_EQ(spread_slices(12, 3), (std::vector<std::int64_t>{2, 6, 10}));
  EXPECT_EQ(spread_slices(5, 5), (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  EXPECT_THROW(spread_slices(5, 6), Error);
  EXPECT_EQ(spaced_slices(100, 3, 10, 50), (std::vector<std::int64_t>{40, 50, 60}));
  EXPECT_EQ(spaced_slices(100, 3, 10, 2), (std::vector<std::int64_t>{0, 10, 20}));
  EXPECT_EQ(spaced_slices(100, 3, 10, 98), (std::vector<std::int64_t>{79, 89, 99}));
  EXPECT_THROW(spaced_slices(100, 3, 50, 50), Error);
  EXPECT_THROW(spaced_slices(100, 3, 0, 50), Error);
}

TEST(Montage, CellsFillAPictureWithoutOverlap) {
  for (std::int64_t count = 1; count < 30; ++count) {
    const MontageGrid grid = montage_grid(count, montage_columns(count, 40, 30), 40, 30);
    EXPECT_GE(grid.columns * grid.rows, count);
    EXPECT_LT(grid.columns * (grid.rows - 1), count);
    const PixelArea last = grid.cell(grid.columns * grid.rows - 1);
    EXPECT_EQ(last.x + last.width, grid.width());
    EXPECT_EQ(last.y + last.height, grid.height());
  }
  EXPECT_EQ(montage_columns(12, 100, 100), 4);
}

}  // namespace
}  // namespace octavo
