// Modes of render that cast rays, from files.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/mesh/formats/mesh_reader.h"
#include "octavo/tasks/files/decoding_memory.h"
#include "octavo/tasks/pictures/render.h"
#include "octavo/tasks/pictures/transfer_file.h"
#include "octavo/tasks/surface.h"
#include "support/built_file.h"
#include "support/read_png.h"

namespace octavo {
namespace {

constexpr RenderMode kRayModes[] = {RenderMode::volume, RenderMode::mip, RenderMode::minip,
                                    RenderMode::mean, RenderMode::iso};

class RayScenes : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = std::make_unique<testing::ScratchFolder>();
    build(shared_->file("ball.8vo"), VolumeKind::grey, {-1, 1000});
  }
  static void TearDownTestSuite() { shared_.reset(); }

  void SetUp() override {
    options_.input = shared_->file("ball.8vo");
    options_.output = {folder_.file("p.png"), true};
    options_.width = 120;
    options_.height = 100;
    options_.has_legend = options_.has_scale_bar = options_.has_sides = false;
    context_.threads = 2;
    context_.on_warning = [this](const Warning& warning) { warnings_.push_back(warning.text); };
  }

  /// Values that rise from 100 with the distance from the middle of a ball, or the label 1 in it.
  static void build(const std::string& path, VolumeKind kind, const Rescale& rescale) {
    testing::Volume volume;
    volume.description.kind = kind;
    volume.description.size = {150, 140, 130};
    volume.description.type = VoxelType::int16;
    volume.description.rescale = rescale;
    volume.description.geometry.spacing_mm = {1, 1, 1.2};
    volume.description.metadata =
        Metadata::read(R"({"spacing_known":true,"place_known":true,"unit":"HU"})");
    for (std::int64_t z = 0; z < 130; ++z) {
      for (std::int64_t y = 0; y < 140; ++y) {
        for (std::int64_t x = 0; x < 150; ++x) {
          const double r = std::hypot(static_cast<double>(x) - 60, static_cast<double>(y) - 70,
                                      static_cast<double>(z) - 65);
          const bool is_grey = kind == VolumeKind::grey;
          const auto value = static_cast<std::int16_t>(is_grey ? 10 * r + 100 : r < 50 ? 1 : 0);
          const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
          volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof value);
        }
      }
    }
    testing::build_volume(volume, path, 1);
  }

  Picture draw(RenderMode mode) {
    options_.mode = mode;
    options_.isovalue.reset();
    if (mode == RenderMode::iso) options_.isovalue = 400;
    result_ = render(options_, context_);
    const std::string bytes = testing::bytes_of_file(options_.output.path);
    return testing::read_png(Bytes(bytes.begin(), bytes.end()));
  }

  void expect_rejected(const char* text, const std::function<void(RenderOptions&)>& change) {
    RenderOptions options = options_;
    options.mode = RenderMode::volume;
    change(options);
    try {
      render(options, context_);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::invalid_argument) << text;
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  }

  static inline std::unique_ptr<testing::ScratchFolder> shared_;
  testing::ScratchFolder folder_;
  std::vector<std::string> warnings_;
  RenderOptions options_;
  RenderResult result_;
  TaskContext context_;
};

TEST_F(RayScenes, ThreadsAndMemoryChangeNoPixel) {
  for (const RenderMode mode : kRayModes) {
    context_.threads = 1;
    context_.max_memory_bytes = 0;
    options_.level = 0;
    const Picture first = draw(mode);
    const std::int64_t decoded = result_.counts.decoded_bricks;
    EXPECT_GT(result_.counts.rays.samples, 0);
    context_.threads = 3;
    // Three quarters of which are not the reader's.
    context_.max_memory_bytes = (decoding_bytes(result_.volume, context_) + (5 << 20)) * 4 / 3;
    EXPECT_EQ(draw(mode).pixels, first.pixels) << static_cast<int>(mode);
    EXPECT_GE(result_.counts.decoded_bricks, decoded);
  }
}

TEST_F(RayScenes, TheScaleOfValuesCountsNotThatOfTheFile) {
  // Real values are highest in the middle of the ball, 900, and 200 where the ray leaves.
  options_.window = Window{-50, 1900};
  options_.view.side = "front";
  const auto middle = [&](const Picture& picture) {
    return picture.pixels[static_cast<std::size_t>(3 * (50 * picture.width + 51))];
  };
  const Picture highest = draw(RenderMode::mip);
  EXPECT_GT(middle(highest), 200);
  EXPECT_NEAR(middle(draw(RenderMode::minip)), 255 * (200 + 1000) / 1900, 4);
  EXPECT_GT(middle(draw(RenderMode::mean)), middle(draw(RenderMode::minip)));
}

TEST_F(RayScenes, AnIsosurfaceHasTheOutlineOfTheMesh) {
  options_.view.side = "front";
  const Picture picture = draw(RenderMode::iso);
  // Stored values up to 600 lie inside, so the mesh cuts at 600.5: 50.05 voxels from the middle.
  double lowest = 1e9;
  double highest = -1e9;
  for (std::int64_t x = 0; x < picture.width; ++x) {
    for (std::int64_t y = 0; y < picture.height; ++y) {
      if (picture.pixels[static_cast<std::size_t>(3 * (y * picture.width + x))] == 0) continue;
      lowest = std::min(lowest, static_cast<double>(x));
      highest = std::max(highest, static_cast<double>(x) + 1);
    }
  }
  EXPECT_NEAR((highest - lowest) * result_.pixel_mm, 2 * 50.05, 2 * result_.pixel_mm);
}

/// Pixels whose middles triangles cover.
/// middle  of the grid, world space
std::vector<bool> covered_pixels(const TriangleMesh& mesh, const View& view,
                                 const Point3& middle) {
  std::vector<bool> covered(static_cast<std::size_t>(view.width * view.height));
  for (const MeshTriangle& triangle : mesh.triangles) {
    std::array<std::array<double, 2>, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) {
      const MeshPoint& p = mesh.points[triangle[i]];
      const Point3 off = difference({p[0], p[1], p[2]}, middle);
      at[i] = {static_cast<double>(view.width) / 2 + dot(off, view.right) / view.pixel_mm,
               static_cast<double>(view.height) / 2 - dot(off, view.up) / view.pixel_mm};
    }
    const auto [left, right] = std::minmax({at[0][0], at[1][0], at[2][0]});
    const auto [top, bottom] = std::minmax({at[0][1], at[1][1], at[2][1]});
    for (auto y = static_cast<std::int64_t>(top); y <= static_cast<std::int64_t>(bottom); ++y) {
      for (auto x = static_cast<std::int64_t>(left); x <= static_cast<std::int64_t>(right); ++x) {
        std::array<double, 3> sides{};
        for (std::size_t i = 0; i < 3; ++i) {
          const auto& a = at[i];
          const auto& b = at[(i + 1) % 3];
          sides[i] = (b[0] - a[0]) * (static_cast<double>(y) + 0.5 - a[1]) -
                     (b[1] - a[1]) * (static_cast<double>(x) + 0.5 - a[0]);
        }
        const auto [lowest, highest] = std::minmax({sides[0], sides[1], sides[2]});
        if (lowest >= 0 || highest <= 0) {
          covered.at(static_cast<std::size_t>(y * view.width + x)) = true;
        }
      }
    }
  }
  return covered;
}

/// How many pixels of one have none of the other within one pixel.
int pixels_far_from(const std::vector<bool>& of, const std::vector<bool>& other,
                    const View& view) {
  int far = 0;
  for (std::int64_t y = 1; y + 1 < view.height; ++y) {
    for (std::int64_t x = 1; x + 1 < view.width; ++x) {
      bool is_near = !of[static_cast<std::size_t>(y * view.width + x)];
      for (std::int64_t around = 0; around < 9; ++around) {
        const std::int64_t at = (y - 1 + around / 3) * view.width + x - 1 + around % 3;
        is_near = is_near || other[static_cast<std::size_t>(at)];
      }
      if (!is_near) ++far;
    }
  }
  return far;
}

TEST_F(RayScenes, TheSilhouetteOfAnIsosurfaceIsThatOfTheSurfaceWithinAPixel) {
  // A lump with hollows, bumps and noise, on an oblique, left-handed grid of long voxels.
  testing::Volume volume;
  volume.description.size = {70, 60, 44};
  volume.description.type = VoxelType::int16;
  volume.description.geometry = {
      {5, -20, 40}, {0.8, 1, 1.5}, {0.8, 0, 0.6, 0, 1, 0, 0.6, 0, -0.8}};
  volume.description.metadata = Metadata::read(R"({"spacing_known":true,"place_known":true})");
  visit_cells(box_of(volume.description.size), {1, 1, 1}, [&](const Index3& at) {
    const auto x = static_cast<double>(at.x);
    const auto y = static_cast<double>(at.y);
    const auto z = static_cast<double>(at.z);
    const double r = std::hypot((x - 34) * 0.8, y - 30, (z - 21) * 1.5);
    const double bumps = 300 * std::sin(x / 4) * std::cos(y / 5) * std::sin(z / 3);
    const auto noise = static_cast<double>((at.x * 73 + at.y * 151 + at.z * 283) % 29);
    const auto value = static_cast<std::int16_t>(1400 - 50 * r + bumps + noise);
    const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
    volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof value);
    return true;
  });
  testing::build_volume(volume, folder_.file("lump.8vo"), 1);

  SurfaceOptions surface_options;
  surface_options.input = folder_.file("lump.8vo");
  surface_options.output = {folder_.file("lump.ply"), false};
  surface_options.isovalue = 400;
  surface(surface_options, context_);
  const std::string ply = testing::bytes_of_file(surface_options.output.path);
  const TriangleMesh mesh =
      read_mesh(Bytes(ply.begin(), ply.end()), MeshFormat::ply, 1 << 28).mesh;
  ASSERT_GT(mesh.triangles.size(), 5000u);

  options_.input = folder_.file("lump.8vo");
  options_.background = {255, 0, 255};
  for (const auto& [azimuth, elevation] : {std::pair{20.0, 15.0}, {115.0, -40.0}, {270.0, 80.0}}) {
    options_.view.azimuth_degrees = azimuth;
    options_.view.elevation_degrees = elevation;
    options_.level = 0;
    const Picture picture = draw(RenderMode::iso);
    const Size3 size = volume.description.size;
    const Geometry& geometry = volume.description.geometry;
    const View view = make_view(geometry, size, box_of(size), viewpoint_at(azimuth, elevation),
                                {options_.width, options_.height, 1, result_.pixel_mm});
    std::vector<bool> seen;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
      seen.push_back(picture.pixels[i + 1] != 0);
    }
    const std::vector<bool> covered =
        covered_pixels(mesh, view, geometry.to_world({34.5, 29.5, 21.5}));
    EXPECT_GT(std::count(seen.begin(), seen.end(), true), 1000) << azimuth;
    EXPECT_EQ(pixels_far_from(seen, covered, view), 0) << azimuth;
    EXPECT_EQ(pixels_far_from(covered, seen, view), 0) << azimuth;
  }
}

TEST_F(RayScenes, TheLevelFollowsThePixels) {
  options_.width = options_.height = 400;
  draw(RenderMode::mip);
  EXPECT_EQ(result_.level, 0);
  options_.width = options_.height = 30;
  draw(RenderMode::mip);
  EXPECT_GT(result_.level, 1);
  options_.level = 1;
  draw(RenderMode::mip);
  EXPECT_EQ(result_.level, 1);
}

TEST_F(RayScenes, BricksThatTheIndexRulesOutAreNotDecoded) {
  options_.level = 0;
  options_.cuts = {{0, true, 50}};
  draw(RenderMode::iso);
  const std::int64_t half = result_.counts.decoded_bricks;
  options_.cuts.clear();
  draw(RenderMode::iso);
  EXPECT_GT(result_.counts.decoded_bricks, half);
  EXPECT_LT(result_.counts.decoded_bricks, 3 * 3 * 3);
}

TEST_F(RayScenes, PerspectiveAndTransferFilesChangeThePicture) {
  const Picture usual = draw(RenderMode::volume);
  std::ofstream(folder_.file("t.json"))
      << R"({"points": [{"value": 300, "color": "red", "opacity": 0},
                        {"value": 600, "color": "#102030", "opacity": 0.5}]})";
  options_.transfer = folder_.file("t.json");
  const Picture other = draw(RenderMode::volume);
  EXPECT_NE(usual.pixels, other.pixels);
  options_.angle_degrees = 40;
  EXPECT_NE(draw(RenderMode::volume).pixels, other.pixels);
}

TEST_F(RayScenes, AMeshIsSeenAmongTheRaysAndShadesDarkenThem) {
  std::ofstream(folder_.file("plate.obj"))
      << "v 0 0 60\nv 149 0 60\nv 149 139 60\nv 0 139 60\nf 1 2 3 4\n";
  for (const RenderMode mode : {RenderMode::volume, RenderMode::mip, RenderMode::iso}) {
    options_.meshes.clear();
    const Picture without = draw(mode);
    options_.meshes = {{folder_.file("plate.obj"), Color{255, 0, 0}, 1}};
    EXPECT_NE(draw(mode).pixels, without.pixels) << static_cast<int>(mode);
  }
  options_.meshes.clear();
  options_.level = 2;
  for (const RenderMode mode : {RenderMode::volume, RenderMode::iso}) {
    options_.has_ambient_shade = options_.has_shadows = false;
    const Picture bright = draw(mode);
    options_.has_shadows = true;
    const Picture shadows = draw(mode);
    options_.has_ambient_shade = true;
    EXPECT_NE(shadows.pixels, bright.pixels);
    EXPECT_NE(draw(mode).pixels, shadows.pixels);
  }
}

TEST_F(RayScenes, MeshesAndTheVolumeThrowShadowsOnEachOther) {
  // A wall behind the ball, and a plate before it.
  std::ofstream(folder_.file("wall.obj"))
      << "v -60 139 -60\nv 209 139 -60\nv 209 139 220\nv -60 139 220\nf 1 2 3 4\n";
  std::ofstream(folder_.file("plate.obj"))
      << "v 30 -30 70\nv 60 -30 70\nv 60 -30 110\nv 30 -30 110\nf 1 2 3 4\n";
  const AskedMesh wall{folder_.file("wall.obj"), Color{0, 0, 200}, 1};
  const AskedMesh plate{folder_.file("plate.obj"), Color{200, 0, 0}, 1};
  options_.view.side = "front";
  options_.level = 1;
  options_.has_shadows = true;
  const auto darker = [](const Picture& picture, const Picture& than, std::size_t channel) {
    int count = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
      if (picture.pixels[i + channel] + 20 < than.pixels[i + channel]) ++count;
    }
    return count;
  };
  for (const RenderMode mode : {RenderMode::iso, RenderMode::volume}) {
    options_.meshes = {wall};
    options_.has_shadows = false;
    const Picture bright = draw(mode);
    options_.has_shadows = true;
    const Picture behind = draw(mode);
    EXPECT_GT(darker(behind, bright, 2), 100) << static_cast<int>(mode);
    EXPECT_GT(testing::pixel(behind, 2, 2)[2], 60);
    options_.meshes = {wall, plate};
    const Picture both = draw(mode);
    // What the plate covers is red.
    Picture seen = both;
    for (std::size_t i = 0; i < seen.pixels.size(); i += 3) {
      const bool is_plate = both.pixels[i] > 2 * both.pixels[i + 1] + 20;
      if (is_plate) seen.pixels[i + 1] = seen.pixels[i + 2] = 255;
    }
    EXPECT_GT(darker(seen, behind, 1) + darker(seen, behind, 2), 100) << static_cast<int>(mode);
    context_.threads = 1;
    // Half of which is not the reader's or that of lists of layers.
    context_.max_memory_bytes = 2 * (decoding_bytes(result_.volume, context_) + (12 << 20));
    EXPECT_EQ(draw(mode).pixels, both.pixels);
    context_.threads = 2;
    context_.max_memory_bytes = 0;
  }
}

TEST_F(RayScenes, ABoxThatIsCutOutIsNotSeen) {
  options_.view.side = "front";
  const Picture whole = draw(RenderMode::iso);
  AskedBox box;
  options_.removed = {box};
  expect_rejected("the cuts leave no voxel", [](auto& o) { o.isovalue.reset(); });
  box.lo[0] = 60;  // all from there on
  options_.removed = {box};
  const Picture cut = draw(RenderMode::iso);
  options_.removed.clear();
  EXPECT_NE(cut.pixels, whole.pixels);
  const auto seen_in = [](const Picture& picture, std::int64_t x) {
    return testing::pixel(picture, x, 50) != kBlack;
  };
  EXPECT_TRUE(seen_in(whole, 60));
  EXPECT_FALSE(seen_in(cut, 60));
  EXPECT_TRUE(seen_in(cut, 30));
}

TEST_F(RayScenes, CoarseLevelsComeFirstAndATimeBudgetEndsThem) {
  options_.width = options_.height = 300;
  const Picture whole = draw(RenderMode::volume);
  ASSERT_EQ(result_.level, 0);
  EXPECT_TRUE(result_.passes.empty());
  options_.is_progressive = true;
  EXPECT_EQ(draw(RenderMode::volume).pixels, whole.pixels);
  ASSERT_GE(result_.passes.size(), 3u);
  EXPECT_EQ(result_.passes.front().shrink, 2);
  EXPECT_GT(result_.passes.front().level, 1);
  EXPECT_EQ(result_.passes.back().level, 0);
  EXPECT_TRUE(result_.is_complete);
  options_.is_progressive = false;
  options_.time_budget_s = 1e-9;
  const Picture first = draw(RenderMode::volume);
  EXPECT_EQ(first.width, whole.width);
  EXPECT_FALSE(result_.is_complete);
  ASSERT_EQ(result_.passes.size(), 1u);
  EXPECT_EQ(result_.level, result_.passes[0].level);
  options_.time_budget_s = 1e6;
  EXPECT_EQ(draw(RenderMode::volume).pixels, whole.pixels);
  EXPECT_TRUE(result_.is_complete);
}

TEST_F(RayScenes, ATurntableGrowsToTheWhole) {
  options_.mode = RenderMode::iso;
  options_.isovalue = 400;
  const auto picture = [&](const std::string& path) {
    const std::string bytes = testing::bytes_of_file(path);
    return testing::read_png(Bytes(bytes.begin(), bytes.end()));
  };
  options_.turntable = 3;
  render(options_, context_);
  const Picture whole = picture(folder_.file("p-002.png"));
  const Picture first = picture(folder_.file("p-000.png"));
  options_.is_growing = true;
  render(options_, context_);
  EXPECT_EQ(picture(folder_.file("p-002.png")).pixels, whole.pixels);
  EXPECT_NE(picture(folder_.file("p-000.png")).pixels, first.pixels);
  options_.output.path = folder_.file("p.apng");
  const RenderResult animation = render(options_, context_);
  EXPECT_EQ(animation.outputs, std::vector<std::string>{folder_.file("p.apng")});
  EXPECT_EQ(picture(folder_.file("p.apng")).width, options_.width);
}

TEST_F(RayScenes, WhatDoesNotGoTogetherIsRejected) {
  expect_rejected("meshes and marks are of", [](auto& o) {
    o.mode = RenderMode::cubes;
    o.marks = {{{0, 0, 0}, "here", std::nullopt}};
  });
  expect_rejected("shadows are of modes volume and iso", [](auto& o) {
    o.mode = RenderMode::mip;
    o.has_shadows = true;
  });
  expect_rejected("in the pictures of a turntable", [](auto& o) { o.is_growing = true; });
  expect_rejected("of the pictures of a turntable", [](auto& o) { o.output.path = "p.apng"; });
  expect_rejected("in one picture of rays", [](auto& o) {
    o.turntable = 3;
    o.time_budget_s = 3;
  });
  expect_rejected("above 0 seconds", [](auto& o) { o.time_budget_s = 0; });
  expect_rejected("has no boxes cut out", [](auto& o) {
    o.mode = RenderMode::transparency;
    o.removed = {AskedBox()};
  });
  expect_rejected("mode iso needs a value", [](auto& o) { o.mode = RenderMode::iso; });
  expect_rejected("is of mode iso", [](auto& o) { o.isovalue = 3; });
  expect_rejected("of modes volume and iso", [](auto& o) {
    o.mode = RenderMode::mip;
    o.transfer = "bone";
  });
  expect_rejected("no voxel is at or above 5000; values run from -405 to 900", [](auto& o) {
    o.mode = RenderMode::iso;
    o.isovalue = 5000;
  });
  expect_rejected("do not fade", [](auto& o) { o.fade = 0.5; });
  expect_rejected("not ranges or tissues", [](auto& o) { o.tissues = {"bone"}; });
  expect_rejected("a window is of", [](auto& o) { o.window = Window{0, 1}; });
  expect_rejected("perspective is of", [](auto& o) {
    o.mode = RenderMode::cubes;
    o.angle_degrees = 30;
  });
  build(folder_.file("labels.8vo"), VolumeKind::labels, {});
  expect_rejected("this is a label map",
                  [&](auto& o) { o.input = folder_.file("labels.8vo"); });
}

TEST_F(RayScenes, RaysBesideAThinAxisEnd) {
  testing::Volume volume;
  volume.description.size = {9, 9, 9};
  volume.description.type = VoxelType::uint8;
  volume.description.geometry.spacing_mm = {1e-6, 1, 1};
  volume.description.metadata = Metadata::read(R"({"spacing_known":true})");
  for (int i = 0; i < 9 * 9 * 9; ++i) volume.voxels.push_back(static_cast<std::byte>(i % 251));
  testing::build_volume(volume, folder_.file("thin.8vo"), 1);
  options_.input = folder_.file("thin.8vo");
  options_.width = options_.height = 8;
  draw(RenderMode::mip);
  EXPECT_GT(result_.counts.rays.samples, 0);
}

TEST_F(RayScenes, MeansOfOneValueHaveOneGrey) {
  testing::Volume volume;
  volume.description.size = {23, 19, 21};
  volume.description.type = VoxelType::uint8;
  volume.description.metadata = Metadata::read(R"({"spacing_known":true})");
  volume.voxels.assign(23 * 19 * 21, static_cast<std::byte>(7));
  testing::build_volume(volume, folder_.file("even.8vo"), 1);
  options_.input = folder_.file("even.8vo");
  const Picture picture = draw(RenderMode::mean);
  const auto white = std::count(picture.pixels.begin(), picture.pixels.end(), 255);
  const auto black = std::count(picture.pixels.begin(), picture.pixels.end(), 0);
  EXPECT_GT(white, black / 4);
  EXPECT_EQ(static_cast<std::size_t>(white + black), picture.pixels.size());
}

TEST_F(RayScenes, ASurfaceOfNoFiniteValueIsRejected) {
  testing::Volume volume;
  volume.description.size = {4, 4, 4};
  volume.description.type = VoxelType::float32;
  const float none = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 4 * 4 * 4; ++i) {
    const auto* const bytes = reinterpret_cast<const std::byte*>(&none);
    volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof none);
  }
  testing::build_volume(volume, folder_.file("none.8vo"), 1);
  expect_rejected("no voxel has a finite value", [&](auto& o) {
    o.input = folder_.file("none.8vo");
    o.mode = RenderMode::iso;
    o.isovalue = 1;
  });
}

TEST_F(RayScenes, WhatHasNoValueIsEmptySpace) {
  std::ofstream(folder_.file("fog.json"))
      << R"({"points": [{"value": -90, "color": "red", "opacity": 0.5}]})";
  options_.transfer = folder_.file("fog.json");
  int built = 0;
  const auto seen_pixels = [&](float around, double slope) {
    testing::Volume volume;
    volume.description.size = {24, 24, 24};
    volume.description.type = VoxelType::float32;
    volume.description.rescale = {slope, 0};
    for (int i = 0; i < 24 * 24 * 24; ++i) {
      const std::array at{i % 24, i / 24 % 24, i / (24 * 24)};
      const bool is_inside = std::ranges::all_of(at, [](int n) { return n / 6 % 3 != 0; });
      const float value = is_inside ? static_cast<float>(i % 2) : around;
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof value);
    }
    options_.input = folder_.file("fog" + std::to_string(built++) + ".8vo");
    testing::build_volume(volume, options_.input, 1);
    const Picture picture = in_colors(draw(RenderMode::volume));
    std::int64_t seen = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
      seen += std::equal(&picture.pixels[i], &picture.pixels[i] + 3, &picture.pixels[0]) ? 0 : 1;
    }
    return seen;
  };
  for (const double slope : {1.0, -1.0}) {
    const std::int64_t inside = seen_pixels(std::numeric_limits<float>::quiet_NaN(), slope);
    const std::int64_t all = seen_pixels(0, slope);
    EXPECT_GT(inside, all / 5) << slope;
    EXPECT_LT(inside, all * 2 / 5) << slope;
  }
}

TEST(TransferFile, WhatIsWrongIsSaid) {
  const struct {
    const char* text;
    const char* said;
  } cases[] = {
      {"[]", "it is not an object"},
      {"{}", "it has no points"},
      {R"({"points": 3})", "points is not a list"},
      {R"({"points": [3]})", "point 1 is not an object"},
      {R"({"points": [{"value": 1, "color": "red"}]})", "point 1 needs"},
      {R"({"points": [{"value": 1, "color": "reddish", "opacity": 0}]})", "the color"},
      {R"({"points": [{"value": 1, "color": "red", "opacity": 2}]})", "expected 0 to 1"},
      {R"({"points": [{"value": -1e39, "color": "red", "opacity": 0}]})", "expected -1e38 to"},
      {R"({"points": [{"value": "1", "color": "red", "opacity": 0}]})", "is not a finite number"},
      {R"({"points": [{"value": 2, "color": "red", "opacity": 0},
                      {"value": 1, "color": "red", "opacity": 0}]})", "point 2 is below"},
      {R"({"points": [{"value": 1, "color": "red", "opacity": 0, "alpha": 1}]})", "\"alpha\""},
      {R"({"points": [{"value": 1, "color": "red", "opacity": 0}], "layer_mm": 0})", "layer_mm"},
      {R"({"points": [{"value": 1, "color": "red", "opacity": 0}], "relative": 1})", "relative"},
      {R"({"points": [{"value": 1, "color": "red", "opacity": 0}], "gradient": [2, 1]})",
       "gradient does not rise"},
      {R"({"points": [{"value": 1, "color": "red", "opacity": 0}], "gradient": 1})",
       "gradient is not a list"},
      {R"({"points": [)", "no transfer function"}};
  for (const auto& one : cases) {
    try {
      parse_transfer(one.text);
      ADD_FAILURE() << one.text;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
      EXPECT_NE(std::string(error.what()).find(one.said), std::string::npos)
          << one.text << ": " << error.what();
    }
  }
}

TEST(TransferFile, PointsAndPresetsAreRead) {
  const TransferFunction read = parse_transfer(
      R"({"relative": true, "layer_mm": 2.5, "gradient": [1, 2],
          "points": [{"value": 0.5, "color": "#0a0b0c", "opacity": 0.25}]})");
  EXPECT_EQ(read, (TransferFunction{{{0.5, {10, 11, 12}, 0.25}}, 2.5, true,
                                    GradientRamp{1, 2}}));
  EXPECT_EQ(read_transfer("bone"), *find_transfer_preset("bone"));
  try {
    read_transfer("no-such-file");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("presets are bone, skin"), std::string::npos);
  }
}

}  // namespace
}  // namespace octavo
