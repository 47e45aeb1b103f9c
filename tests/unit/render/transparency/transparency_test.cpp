#include "octavo/render/transparency/transparency.h"

#include <gtest/gtest.h>
#include <png.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>

#include "octavo/core/error.h"
#include "octavo/planes/phantom.h"
#include "support/built_file.h"
#include "support/memory_reader.h"
#include "support/source_folder.h"

namespace octavo {
namespace {

using testing::ScratchFolder;
using testing::Volume;

/// A tilted, anisotropic grid.
Geometry tilted() {
  Geometry geometry;
  geometry.origin_mm = {-20, 7, 3};
  geometry.spacing_mm = {0.5, 0.8, 1.3};
  const double c = std::cos(0.3), s = std::sin(0.3);
  geometry.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  return geometry;
}

/// Random boxes of value 1 to 9 in nothing.
Volume boxes_volume(const Size3& size, const Geometry& geometry) {
  Volume volume;
  volume.description.type = VoxelType::uint8;
  volume.description.size = size;
  volume.description.geometry = geometry;
  volume.voxels.resize(static_cast<std::size_t>(size.voxel_count()));
  std::mt19937 random(11);
  for (int i = 0; i < 8; ++i) {
    Index3 lo, hi;
    for (int a = 0; a < 3; ++a) {
      lo[a] = static_cast<std::int64_t>(random() % static_cast<unsigned>(size[a] / 2));
      hi[a] = lo[a] + 3 + static_cast<std::int64_t>(random() % 9);
      hi[a] = std::min(hi[a], size[a]);
    }
    for (std::int64_t z = lo.z; z < hi.z; ++z) {
      for (std::int64_t y = lo.y; y < hi.y; ++y) {
        for (std::int64_t x = lo.x; x < hi.x; ++x) {
          volume.voxels[static_cast<std::size_t>((z * size.y + y) * size.x + x)] =
              static_cast<std::byte>(i + 1);
        }
      }
    }
  }
  return volume;
}

std::shared_ptr<FileReader> built(const ScratchFolder& folder, const Volume& volume) {
  testing::build_volume(volume, folder.file("v.8vo"), 2);
  return testing::open_file(folder.file("v.8vo"));
}

View view_toward(const FileReader& reader, const Direction& toward, std::int64_t pixels,
                 int level = 0) {
  const Geometry geometry = reader.levels().geometry(reader.description().geometry, level);
  const Size3& size = reader.levels().size(level);
  const Point3 steps{double(toward.x), double(toward.y), double(toward.z)};
  ViewFrame frame;
  frame.width = pixels;
  frame.height = pixels * 3 / 4;
  return make_view(geometry, size, box_of(size), viewpoint_along(geometry, steps), frame);
}

TransparencyPicture drawn(const FileReader& reader, const View& view,
                          const TransparencyOptions& options) {
  NoProgress progress;
  return render_transparency(reader, view, options, progress);
}

/// What a picture or a volume weighs, and where its middle lies on the picture.
struct Weight {
  double total = 0;
  double x = 0;
  double y = 0;

  void add(double weight, double at_x, double at_y) {
    total += weight;
    x += weight * at_x;
    y += weight * at_y;
  }
};

Weight weight_of(const Picture& picture) {
  Weight weight;
  for (std::int64_t i = 0; i < picture.width * picture.height; ++i) {
    weight.add(picture.pixels[static_cast<std::size_t>(3 * i)],
               static_cast<double>(i % picture.width) + 0.5,
               static_cast<double>(i / picture.width) + 0.5);
  }
  return weight;
}

/// The voxels as they fall on a view, one by one.
Weight weight_of(const Volume& volume, const View& view) {
  Weight weight;
  const Size3& size = volume.description.size;
  const double unit = std::ldexp(1, -view.fraction_bits);
  for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
    const auto value = static_cast<double>(volume.voxels[static_cast<std::size_t>(i)]);
    const Index3 v{i % size.x, i / size.x % size.y, i / (size.x * size.y)};
    const Place low = view.place_of(v);
    const Place high = view.place_of({v.x + 1, v.y + 1, v.z + 1});
    weight.add(value, static_cast<double>(low.x + high.x) / 2 * unit,
               static_cast<double>(low.y + high.y) / 2 * unit);
  }
  return weight;
}

TEST(Transparency, ThePictureHoldsTheVolumesDensityAtItsPlaceFromAllSides) {
  const ScratchFolder folder;
  const Volume volume = boxes_volume({30, 21, 17}, tilted());
  const auto reader = built(folder, volume);
  for (const Direction& toward : kDirections) {
    const View view = view_toward(*reader, toward, 160);
    TransparencyOptions options;
    options.ramp = {0, 9};
    options.window = Window{75, 150};
    const Weight picture = weight_of(drawn(*reader, view, options).picture);
    const Weight reference = weight_of(volume, view);
    const Point3& mm = volume.description.geometry.spacing_mm;
    const double voxels = reference.total * mm[0] * mm[1] * mm[2];
    const double pixels = picture.total / 255 * 150 * view.pixel_mm * view.pixel_mm;
    EXPECT_NEAR(pixels / voxels, 1, 0.01) << toward.x << toward.y << toward.z;
    EXPECT_NEAR(picture.x / picture.total, reference.x / reference.total, 0.2);
    EXPECT_NEAR(picture.y / picture.total, reference.y / reference.total, 0.2);
  }
}

TEST(Transparency, ASmallPictureIsTheMeanOfWhatItCovers) {
  const ScratchFolder folder;
  const Volume volume = boxes_volume({90, 63, 51}, tilted());
  const auto reader = built(folder, volume);
  const View view = view_toward(*reader, {1, 1, 1}, 24);
  TransparencyOptions options;
  options.ramp = {0, 9};
  options.window = Window{75, 150};
  const Weight picture = weight_of(drawn(*reader, view, options).picture);
  const Weight reference = weight_of(volume, view);
  const Point3& mm = volume.description.geometry.spacing_mm;
  EXPECT_NEAR(picture.total / 255 * 150 * view.pixel_mm * view.pixel_mm /
                  (reference.total * mm[0] * mm[1] * mm[2]),
              1, 0.05);
}

/// A volume of one value, and the share of white that its middle line has.
double middle_share(const FileReader& reader, const Direction& toward, int level,
                    TransparencyOptions options) {
  options.level = level;
  const View view = view_toward(reader, toward, 64, level);
  const Picture picture = drawn(reader, view, options).picture;
  const auto middle = static_cast<std::size_t>(3 * (view.height / 2 * view.width + 32));
  return static_cast<double>(picture.pixels[middle]) / 255;
}

TEST(Transparency, OpacityIsThatOfALengthWhateverDirectionAndLevel) {
  const ScratchFolder folder;
  Volume volume = boxes_volume({32, 32, 32}, {});
  std::fill(volume.voxels.begin(), volume.voxels.end(), std::byte{5});
  const auto reader = built(folder, volume);
  TransparencyOptions average;
  average.is_average = true;
  average.ranges = {{5, 5, {255, 255, 255}, 0.02}};
  TransparencyOptions sum = average;
  sum.is_average = false;
  sum.window = Window{1, 2};
  for (const int level : {0, 1, 2}) {
    for (const Direction& toward : {Direction{0, 0, 1}, Direction{1, -1, 0}, Direction{1, 1, 1}}) {
      const double steps =
          std::sqrt(toward.x * toward.x + toward.y * toward.y + toward.z * toward.z);
      const double layers = 32 * steps;
      EXPECT_NEAR(middle_share(*reader, toward, level, average), 1 - std::pow(0.98, layers), 0.02);
      EXPECT_NEAR(middle_share(*reader, toward, level, sum), layers * 0.02 / 2, 0.03);
    }
  }
}

TEST(Transparency, WhatIsInFrontHidesWhatIsBehind) {
  const ScratchFolder folder;
  Volume volume = boxes_volume({32, 32, 32}, {});
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    volume.voxels[i] = static_cast<std::byte>(i < volume.voxels.size() / 2 ? 1 : 2);
  }
  const auto reader = built(folder, volume);
  TransparencyOptions options;
  options.is_average = true;
  options.ranges = {{1, 1, {255, 0, 0}, 0.2}, {2, 2, {0, 255, 0}, 0.2}};
  for (const int side : {-1, 1}) {
    const View view = view_toward(*reader, {0, 0, side}, 64);
    const Picture picture = drawn(*reader, view, options).picture;
    const auto middle = static_cast<std::size_t>(3 * (view.height / 2 * view.width + 32));
    const int red = picture.pixels[middle];
    const int green = picture.pixels[middle + 1];
    EXPECT_GT(side < 0 ? red : green, 200);
    EXPECT_LT(side < 0 ? green : red, 40);
  }
}

TEST(Transparency, TheInnerCylindersOfThePhantomShineThroughItsShell) {
  const ScratchFolder folder;
  PhantomOptions phantom;
  phantom.size = {64, 64, 64};
  NoProgress progress;
  const auto source = make_phantom(phantom);
  build_file(*source, local_storage(), folder.file("p.8vo"), {}, progress);
  const auto reader = testing::open_file(folder.file("p.8vo"));
  TransparencyOptions options;
  options.ranges = {{300, 300, {255, 0, 0}, 0.05},
                    {-100, -100, {0, 255, 0}, 0.05},
                    {900, 900, {0, 0, 255}, 0.01}};
  for (const bool is_average : {false, true}) {
    options.is_average = is_average;
    for (const Direction& toward : {Direction{0, 1, 0}, Direction{1, 0, 1}, Direction{1, 1, 1}}) {
      const View view = view_toward(*reader, toward, 96);
      const Picture picture = drawn(*reader, view, options).picture;
      // A spot of each cylinder: pixels where it is seen and the shell before and behind it too.
      std::array<int, 2> seen{};
      for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
        if (picture.pixels[i + 2] < 5) continue;
        for (std::size_t c = 0; c < 2; ++c) seen[c] += picture.pixels[i + c] > 60 ? 1 : 0;
      }
      EXPECT_GT(seen[0], 60);
      EXPECT_GT(seen[1], 40);
    }
  }
}

Picture read_png(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return {};
  image.format = PNG_FORMAT_RGB;
  Picture picture = make_picture(image.width, image.height, 3);
  png_image_finish_read(&image, nullptr, picture.pixels.data(), 0, nullptr);
  return picture;
}

/// Compares with a kept picture by eye's measure: hardly any pixel differs, none by much.
/// OCTAVO_PICTURES names a folder that gets what was drawn, to be looked at.
void expect_like(const std::string& name, const Picture& picture) {
  if (const char* const folder = std::getenv("OCTAVO_PICTURES")) {
    const Bytes png = encode_png(picture);
    std::ofstream(std::string(folder) + "/" + name, std::ios::binary)
        .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
  }
  const Picture kept = read_png(testing::source_folder() + "/tests/unit/render/golden/" + name);
  ASSERT_EQ(kept.pixels.size(), picture.pixels.size()) << name;
  double sum = 0;
  int most = 0;
  for (std::size_t i = 0; i < kept.pixels.size(); ++i) {
    const int difference = std::abs(int{kept.pixels[i]} - int{picture.pixels[i]});
    sum += difference;
    most = std::max(most, difference);
  }
  EXPECT_LE(sum / static_cast<double>(kept.pixels.size()), 0.5) << name;
  EXPECT_LE(most, 12) << name;
}

TEST(Transparency, ThePhantomLooksAsItDid) {
  const ScratchFolder folder;
  PhantomOptions phantom;
  phantom.size = {40, 40, 40};
  phantom.spacing_mm = {1, 1, 1.5};
  NoProgress progress;
  const auto source = make_phantom(phantom);
  build_file(*source, local_storage(), folder.file("p.8vo"), {}, progress);
  const auto reader = testing::open_file(folder.file("p.8vo"));
  TransparencyOptions options;
  options.ranges = {{300, 300, {255, 130, 0}, 0.08},
                    {-100, -100, {0, 200, 255}, 0.08},
                    {900, 900, {255, 255, 255}, 0.02}};
  expect_like("sum-corner.png",
              drawn(*reader, view_toward(*reader, {1, 1, 1}, 64), options).picture);
  options.is_average = true;
  options.background = {12, 18, 48};
  expect_like("average-edge.png",
              drawn(*reader, view_toward(*reader, {0, -1, 1}, 64), options).picture);
  options = {};
  options.ramp = robust_ramp(*reader, true);
  expect_like("ramp-axis.png",
              drawn(*reader, view_toward(*reader, {0, -1, 0}, 64), options).picture);
}

TEST(Transparency, TheNumberOfThreadsChangesNoPixel) {
  const ScratchFolder folder;
  const auto reader = built(folder, boxes_volume({70, 66, 65}, tilted()));
  TransparencyOptions options;
  options.is_average = true;
  options.ramp = {0, 9};
  const View view = view_toward(*reader, {1, -1, 1}, 120);
  std::vector<std::uint8_t> first;
  for (const int threads : {1, 2}) {
    tbb::task_arena(threads).execute([&] {
      const Picture picture = drawn(*reader, view, options).picture;
      if (first.empty()) first = picture.pixels;
      else EXPECT_EQ(picture.pixels, first);
    });
  }
}

TEST(Transparency, AnAverageOfBlackVoxelsIsSeen) {
  const ScratchFolder folder;
  const auto reader = built(folder, boxes_volume({40, 36, 35}, {}));
  TransparencyOptions options;
  options.is_average = true;
  options.background = {255, 255, 255};
  for (const double opacity : {0.0, 0.5}) {
    options.ranges = {{5, 5, {0, 0, 0}, opacity}};
    const TransparencyPicture picture =
        drawn(*reader, view_toward(*reader, {1, 0, 0}, 40), options);
    const auto darkest =
        *std::min_element(picture.picture.pixels.begin(), picture.picture.pixels.end());
    EXPECT_EQ(picture.is_lit, darkest < 255) << opacity;
    EXPECT_EQ(picture.is_seen, opacity > 0);
  }
}

TEST(Transparency, EachOfThe26DirectionsIsItsOwnNearest) {
  for (const Direction& d : kDirections) {
    const Viewpoint exact = viewpoint_along(tilted(), {double(d.x), double(d.y), double(d.z)});
    const NearestLines nearest = nearest_lines(tilted(), exact.toward);
    EXPECT_EQ(nearest.toward, d);
    EXPECT_NEAR(nearest.degrees, 0, 1e-5);
  }
  const NearestLines nearest = nearest_lines({}, {std::cos(0.1), std::sin(0.1), 0});
  EXPECT_EQ(nearest.toward, (Direction{1, 0, 0}));
  EXPECT_NEAR(nearest.degrees, 0.1 * 180 / 3.14159265, 1e-6);
}

TEST(Transparency, ARampLeavesAFewExtremesOut) {
  const ScratchFolder folder;
  Volume volume = boxes_volume({20, 20, 20}, {});
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    volume.voxels[i] = static_cast<std::byte>(50 + i % 50);
  }
  volume.voxels[7] = std::byte{0};
  volume.voxels[8] = std::byte{255};
  const auto reader = built(folder, volume);
  const ValueRamp closed = robust_ramp(*reader, false);
  EXPECT_NEAR(closed.low, 50, 1);
  EXPECT_NEAR(closed.high, 99, 1);
  EXPECT_EQ(robust_ramp(*reader, true).high, 255);
}

TEST(Transparency, AnOpenRampEndsWhereNobodyKnowsTheMaximumAsAClosedOneDoes) {
  const Size3 size{20, 20, 20};
  std::vector<float> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<float>(50 + i % 50);
  voxels[7] = 1e30f;
  const testing::MemoryReader reader = testing::reader_of_unbounded(size, voxels);
  EXPECT_EQ(robust_ramp(reader, true).high, robust_ramp(reader, false).high);
  EXPECT_NEAR(robust_ramp(reader, true).high, 99, 1);
}

TEST(Transparency, WrongViewsAndWindowsAreRejected) {
  const ScratchFolder folder;
  const auto reader = built(folder, boxes_volume({30, 21, 17}, tilted()));
  TransparencyOptions options;
  options.ramp = {0, 9};
  const View view = view_toward(*reader, {0, 0, 1}, 64);
  const Geometry& geometry = reader->description().geometry;
  const Size3& size = reader->description().size;
  const View slanted =
      make_view(geometry, size, box_of(size), viewpoint_along(geometry, {1, 0.4, 0}), {});
  EXPECT_THROW(drawn(*reader, slanted, options), Error);
  options.window = Window{0, 0};
  EXPECT_THROW(drawn(*reader, view, options), Error);
  options.window.reset();
  options.ramp = {3, 3};
  EXPECT_THROW(drawn(*reader, view, options), Error);
  options.ramp = {0, 9};
  options.level = 44;
  EXPECT_THROW(drawn(*reader, view, options), Error);
}

}  // namespace
}  // namespace octavo
