#include "octavo/file/thumbnail.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "octavo/builder/builder.h"
#include "octavo/core/label_color.h"
#include "octavo/file/fixed_png.h"
#include "support/built_file.h"
#include "support/memory_reader.h"
#include "support/memory_storage.h"
#include "support/read_png.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using testing::MemoryReader;
using testing::MemoryStorage;
using Voxel = std::function<double(const Index3&)>;

VolumeDescription description_of(const Size3& size, VoxelType type, const Point3& spacing) {
  VolumeDescription description;
  description.size = size;
  description.type = type;
  description.geometry.spacing_mm = spacing;
  return description;
}

std::vector<std::byte> voxels_of(const VolumeDescription& description, const Voxel& voxel) {
  std::vector<std::byte> bytes;
  with_voxel_type(description.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const Size3& size = description.size;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          const T value = static_cast<T>(voxel({x, y, z}));
          const auto* const first = reinterpret_cast<const std::byte*>(&value);
          bytes.insert(bytes.end(), first, first + sizeof value);
        }
      }
    }
  });
  return bytes;
}

/// The thumbnail of a volume in memory, which is small enough to be shown at level 0.
Bytes thumbnail_of_voxels(const VolumeDescription& description, const Voxel& voxel) {
  return thumbnail_of(MemoryReader(description, voxels_of(description, voxel), {}));
}

Picture picture_of(const VolumeDescription& description, const Voxel& voxel) {
  return testing::read_png(thumbnail_of_voxels(description, voxel));
}

std::pair<std::int64_t, std::int64_t> sides_of(const Size3& size, const Point3& spacing) {
  const Picture picture = picture_of(description_of(size, VoxelType::uint8, spacing),
                                     [](const Index3& p) { return p.x; });
  return {picture.width, picture.height};
}

/// Grows to the left, and faster to the head; its largest value is 98 in the plane y = 2.
double anatomy(const Index3& p) { return static_cast<double>(p.x + 11 * p.z + (p.y - 2) * 3); }

TEST(Thumbnail, ShowsTheMiddleCoronalPlaneFromTheFront) {
  const Picture picture = picture_of(
      description_of({11, 5, 9}, VoxelType::int16, {1, 1, 1}), anatomy);
  ASSERT_EQ(picture.width, 11);
  ASSERT_EQ(picture.height, 9);
  ASSERT_EQ(picture.channels, 1);
  for (std::int64_t row = 0; row < 9; ++row) {
    for (std::int64_t column = 0; column < 11; ++column) {
      const std::int64_t value = column + 11 * (8 - row);
      EXPECT_EQ(picture.pixels[static_cast<std::size_t>(11 * row + column)],
                (255 * value * 2 + 98) / (2 * 98));
    }
  }
}

TEST(Thumbnail, IsTheSameHoweverTheAxesOfAScanRun) {
  const Size3 size{11, 5, 9};
  const Bytes straight =
      thumbnail_of_voxels(description_of(size, VoxelType::int16, {1, 1, 1}), anatomy);
  std::array<int, 3> world = {0, 1, 2};  // of each index axis
  do {
    for (unsigned mirrored = 0; mirrored < 8; ++mirrored) {
      VolumeDescription description = description_of(size, VoxelType::int16, {1, 1, 1});
      description.geometry.direction.fill(0);
      for (int axis = 0; axis < 3; ++axis) {
        const int along = world[static_cast<std::size_t>(axis)];
        description.size[axis] = size[along];
        const bool is_mirrored = (mirrored >> axis & 1) != 0;
        description.geometry.direction[static_cast<std::size_t>(3 * along + axis)] =
            is_mirrored ? -1 : 1;
      }
      const auto voxel = [&](const Index3& at) {
        Index3 p;
        for (int axis = 0; axis < 3; ++axis) {
          const bool is_mirrored = (mirrored >> axis & 1) != 0;
          const std::int64_t last = description.size[axis] - 1;
          p[world[static_cast<std::size_t>(axis)]] = is_mirrored ? last - at[axis] : at[axis];
        }
        return anatomy(p);
      };
      EXPECT_EQ(thumbnail_of_voxels(description, voxel), straight)
          << world[0] << world[1] << world[2] << " mirrored " << mirrored;
    }
  } while (std::next_permutation(world.begin(), world.end()));
}

TEST(Thumbnail, OfEquallySteepAxesTakesTheLastOne) {
  const double half = std::sqrt(0.5);
  VolumeDescription description = description_of({11, 5, 9}, VoxelType::int16, {1, 1, 1});
  // y and z run to the head alike: z is taken for the head, y for the back.
  description.geometry.direction = {1, 0, 0, 0, -half, half, 0, half, half};
  const Picture picture = picture_of(description, anatomy);
  EXPECT_EQ(picture.width, 11);
  EXPECT_EQ(picture.height, 9);
}

TEST(Thumbnail, OfFlatVolumesShowsTheLongerSides) {
  using Sides = std::pair<std::int64_t, std::int64_t>;
  EXPECT_EQ(sides_of({40, 40, 10}, {1, 1, 1}), Sides(40, 10));
  EXPECT_EQ(sides_of({40, 41, 10}, {1, 1, 1}), Sides(40, 41));  // across the head axis
  EXPECT_EQ(sides_of({10, 41, 40}, {1, 1, 1}), Sides(41, 40));  // across the left axis
  EXPECT_EQ(sides_of({9, 41, 10}, {1, 1, 1}), Sides(41, 10));
  EXPECT_EQ(sides_of({10, 41, 9}, {1, 1, 1}), Sides(10, 41));
  EXPECT_EQ(sides_of({9, 41, 9}, {1, 1, 1}), Sides(9, 41));  // the head axis when equal
  EXPECT_EQ(sides_of({40, 1, 3}, {1, 1, 1}), Sides(40, 3));
  EXPECT_EQ(sides_of({1, 1, 1}, {1, 1, 1}), Sides(1, 1));
}

TEST(Thumbnail, KeepsTheProportionsOfThickSlices) {
  using Sides = std::pair<std::int64_t, std::int64_t>;
  EXPECT_EQ(sides_of({20, 20, 5}, {1, 1, 8}), Sides(20, 40));
  EXPECT_EQ(sides_of({20, 20, 5}, {1, 1, 1.3}), Sides(20, 7));  // 6.5
  EXPECT_EQ(sides_of({1, 20, 200}, {30, 1, 1}), Sides(30, 200));
  EXPECT_EQ(sides_of({20, 20, 1}, {1, 0.02, 1.2}), Sides(20, 1));
  const Picture picture =
      picture_of(description_of({2, 2, 2}, VoxelType::uint8, {1, 1, 3}),
                 [](const Index3& p) { return p.z; });
  ASSERT_EQ(picture.height, 6);
  EXPECT_EQ(picture.pixels, Bytes({255, 255, 255, 255, 255, 255, 0, 0, 0, 0, 0, 0}));
}

/// What a row of 200 voxels becomes.
Bytes greys(const Voxel& voxel, VoxelType type = VoxelType::float32, double slope = 1) {
  VolumeDescription description = description_of({200, 1, 1}, type, {1, 1, 1});
  description.rescale.slope = slope;
  return picture_of(description, voxel).pixels;
}

TEST(Thumbnail, RunsFromTheLowestToTheHighestHundredth) {
  const Bytes row =
      greys([](const Index3& p) { return p.x == 0 ? 9e9 : static_cast<double>(p.x); });
  EXPECT_EQ(row[0], 255);
  EXPECT_EQ(row[1], 0);
  EXPECT_EQ(row[2], 0);
  EXPECT_EQ(row[3], 0);
  EXPECT_EQ(row[4], 1);
  EXPECT_EQ(row[197], 254);
  EXPECT_EQ(row[199], 255);
}

TEST(Thumbnail, ShowsFewVoxelsOnAGroundOfOneValue) {
  const Bytes row = greys([](const Index3& p) { return p.x == 17 ? 5 : 3; }, VoxelType::uint8);
  EXPECT_EQ(row[16], 0);
  EXPECT_EQ(row[17], 255);
  EXPECT_EQ(greys([](const Index3&) { return 3; }, VoxelType::uint8), Bytes(200, 0));
}

TEST(Thumbnail, TurnsRoundWhereTheSlopeIsNegative) {
  const Bytes row = greys([](const Index3& p) { return p.x; }, VoxelType::int16, -0.5);
  EXPECT_EQ(row[0], 255);
  EXPECT_EQ(row[199], 0);
}

TEST(Thumbnail, ShowsNaNBlackAndInfinitiesAtTheEnds) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto some = [&](const Index3& p) {
    const std::array<double, 4> rare = {kNaN, -kInfinity, kInfinity, 1e30};
    return p.x < 4 ? rare[static_cast<std::size_t>(p.x)] : static_cast<double>(p.x);
  };
  Bytes row = greys(some);
  EXPECT_EQ(Bytes(row.begin(), row.begin() + 5), Bytes({0, 0, 255, 255, 0}));
  row = greys(some, VoxelType::float32, -1);
  EXPECT_EQ(Bytes(row.begin(), row.begin() + 5), Bytes({0, 255, 0, 0, 255}));
  EXPECT_EQ(greys([&](const Index3&) { return kNaN; }), Bytes(200, 0));
  EXPECT_EQ(greys([&](const Index3&) { return kInfinity; }), Bytes(200, 0));
  EXPECT_EQ(greys([](const Index3& p) { return p.x % 2 == 0 ? -3e38 : 3e38; })[1], 255);
}

TEST(Thumbnail, GivesLabelsTheirColors) {
  for (const VoxelType type : {VoxelType::int16, VoxelType::uint32}) {
    VolumeDescription description = description_of({40, 1, 1}, type, {1, 1, 1});
    description.kind = VolumeKind::labels;
    const auto label = [&](std::int64_t x) {
      return type == VoxelType::int16 ? x - 20 : x * 107374182;
    };
    const Picture picture = picture_of(
        description, [&](const Index3& p) { return static_cast<double>(label(p.x)); });
    ASSERT_EQ(picture.channels, 3);
    for (std::int64_t x = 0; x < 40; ++x) {
      EXPECT_EQ(testing::pixel(picture, x, 0), label_color(label(x))) << label(x);
    }
  }
}

// --- Files

std::shared_ptr<FileReader> built(const VolumeDescription& description, const Voxel& voxel,
                                  int threads, BuildOptions options = {}) {
  const auto voxels = voxels_of(description, voxel);
  const auto source = make_memory_source(description, voxels);
  MemoryStorage storage;
  NoProgress progress;
  options.kind = description.kind;
  options.threads = threads;
  options.has_thumbnail = true;
  options.preset = Preset::fast;
  build_file(*source, storage, "a.8vo", options, progress);
  return testing::open_bytes(*storage.files.at("a.8vo"));
}

TEST(Thumbnail, OfAFileShowsTheFirstLevelThatFits) {
  const auto reader = built(description_of({700, 6, 300}, VoxelType::uint16, {1, 1, 1}),
                            [](const Index3& p) { return p.x * 50 + p.z; }, 2);
  // 700 / 256 lies between 2 and 4: level 2.
  const Size3 size = reader->levels().size(2);
  ASSERT_EQ(size, (Size3{175, 2, 75}));
  std::vector<std::uint16_t> samples(static_cast<std::size_t>(175 * 75));
  reader->read({{0, 0, 0}, {175, 1, 75}}, 2, samples.data());
  const Picture picture = testing::read_png(reader->thumbnail());
  ASSERT_EQ(picture.width, 175);
  ASSERT_EQ(picture.height, 75);
  std::vector<std::uint16_t> ordered = samples;
  std::ranges::sort(ordered);
  const double low = ordered[131];
  const double high = ordered[ordered.size() - 132];
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t from = (74 - i / 175) * 175 + i % 175;
    const double value = std::clamp(static_cast<double>(samples[from]), low, high);
    ASSERT_EQ(picture.pixels[i], static_cast<int>(255 * (value - low) / (high - low) + 0.5)) << i;
  }
}

TEST(Thumbnail, IsThatOfTheFileForEveryKindAndAnyNumberOfThreads) {
  const auto rough = [](const Index3& p) {
    return static_cast<double>((p.x * 31 + p.y * 17 + p.z * p.x) % 97);
  };
  BuildOptions parts;
  parts.access = Access::boxes;
  BuildOptions lossy;
  lossy.max_error = 3;
  VolumeDescription labels = description_of({90, 70, 66}, VoxelType::uint8, {1, 1, 1});
  labels.kind = VolumeKind::labels;
  const struct {
    const char* name;
    VolumeDescription description;
    BuildOptions options;
  } cases[] = {
      {"grey", description_of({300, 70, 66}, VoxelType::int16, {1, 1, 1}), {}},
      {"parts", description_of({90, 70, 66}, VoxelType::int16, {1, 1, 1}), parts},
      {"lossy", description_of({90, 70, 66}, VoxelType::int16, {1, 1, 1}), lossy},
      {"float", description_of({90, 70, 66}, VoxelType::float32, {1, 1, 1}), {}},
      {"lossy float", description_of({90, 70, 66}, VoxelType::float32, {1, 1, 1}), lossy},
      {"thick", description_of({90, 70, 12}, VoxelType::int16, {1, 1, 4}), {}},
      {"labels", labels, {}},
      {"one voxel", description_of({1, 1, 1}, VoxelType::int16, {1, 1, 1}), {}},
  };
  for (const auto& [name, description, options] : cases) {
    const auto one = built(description, rough, 1, options);
    const auto three = built(description, rough, 3, options);
    EXPECT_GT(one->thumbnail_bytes(), 0u) << name;
    EXPECT_TRUE(has_true_thumbnail(*one)) << name;
    EXPECT_EQ(one->thumbnail(), three->thumbnail()) << name;
  }
}

}  // namespace
}  // namespace octavo
