// Builds of float32 volumes that come back bit by bit.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "octavo/builder/recover.h"
#include "octavo/core/error.h"
#include "octavo/file/verify.h"
#include "octavo/planes/computed_source.h"
#include "support/built_file.h"
#include "support/memory_storage.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr Size3 kSize{150, 67, 131};

/// Noise in a ball, NaN around it and in a slab; some infinities and zeros of both signs.
std::vector<float> scan() {
  std::mt19937 random(2);
  std::normal_distribution<float> noise(900, 25);
  std::vector<float> voxels;
  for (std::int64_t z = 0; z < kSize.z; ++z) {
    for (std::int64_t y = 0; y < kSize.y; ++y) {
      for (std::int64_t x = 0; x < kSize.x; ++x) {
        const std::int64_t far = (x - 40) * (x - 40) + (y - 33) * (y - 33) + (z - 60) * (z - 60);
        const std::uint32_t some = static_cast<std::uint32_t>(random()) % 500;
        float voxel = far > 3000 || (z > 100 && z < 110) ? kNan : noise(random);
        if (some == 0) voxel = std::numeric_limits<float>::infinity();
        if (some == 1) voxel = -0.0f;
        if (some == 2 && x < 100) voxel = std::bit_cast<float>(0xffc00000u + some);
        voxels.push_back(x >= 128 ? kNan : voxel);
      }
    }
  }
  return voxels;
}

Volume volume_of(const std::vector<float>& voxels) {
  Volume volume;
  volume.description.type = VoxelType::float32;
  volume.description.size = kSize;
  const auto bytes = std::as_bytes(std::span(voxels));
  volume.voxels.assign(bytes.begin(), bytes.end());
  return volume;
}

void build(const Volume& volume, const BuildOptions& options, const std::string& path) {
  const auto source = make_memory_source(volume.description, volume.voxels);
  NoProgress progress;
  build_file(*source, local_storage(), path, options, progress);
}

std::vector<float> level_of(const FileReader& reader, int level) {
  const Size3& size = reader.levels().size(level);
  std::vector<float> samples(static_cast<std::size_t>(size.voxel_count()));
  reader.read(box_of(size), level, samples.data());
  return samples;
}

TEST(ExactBuild, EveryBitComesBackInAllTiers) {
  const ScratchFolder folder;
  const Volume volume = volume_of(scan());
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const std::string path = folder.file(preset == Preset::fast ? "fast.8vo" : "small.8vo");
    build(volume, {.preset = preset}, path);
    const auto reader = open_file(path);
    EXPECT_EQ(read_box(*reader, box_of(kSize), 0), volume.voxels);
    EXPECT_EQ(reader->max_error(), 0);
    ASSERT_TRUE(reader->description().coding.has_value());
    EXPECT_TRUE(reader->description().coding->is_exact);
    NoProgress progress;
    EXPECT_TRUE(verify_file(open_byte_source(local_storage(), path), {}, progress).is_sound());
  }
}

TEST(ExactBuild, CoarseLevelsStandWhereVoxelsLieFarAway) {
  const ScratchFolder folder;
  std::mt19937 random(2);
  std::normal_distribution<float> noise(900, 25);
  std::vector<float> voxels(static_cast<std::size_t>(kSize.voxel_count()));
  for (float& voxel : voxels) voxel = noise(random);
  for (const std::size_t at : {0u, 77u, 9000u}) voxels[at] = -1e10f;  // all in the first planes
  const std::string path = folder.file("far.8vo");
  build(volume_of(voxels), {}, path);
  const auto reader = open_file(path);
  EXPECT_EQ(read_box(*reader, box_of(kSize), 0), volume_of(voxels).voxels);
  const std::vector<float> samples = level_of(*reader, 3);
  const auto near = std::ranges::count_if(samples, [](float v) { return v > 850 && v < 950; });
  EXPECT_GE(near + 3, static_cast<std::ptrdiff_t>(samples.size()));
}

TEST(ExactBuild, TheFileDoesNotDependOnThreads) {
  const ScratchFolder folder;
  const Volume volume = volume_of(scan());
  build(volume, {.preset = Preset::fast, .threads = 1}, folder.file("a"));
  build(volume, {.preset = Preset::fast, .threads = 4}, folder.file("b"));
  EXPECT_EQ(bytes_of_file(folder.file("a")), bytes_of_file(folder.file("b")));
}

TEST(ExactBuild, EveryLevelMeansTheFiniteVoxelsAndIsNanWhereThereAreNone) {
  const ScratchFolder folder;
  const Volume volume = volume_of(scan());
  build(volume, {.preset = Preset::fast}, folder.file("v.8vo"));
  const auto reader = open_file(folder.file("v.8vo"));
  const double step = reader->description().coding->scale;
  const Levels& levels = reader->levels();
  std::vector<float> fine = level_of(*reader, 0);
  for (int level = 1; level < levels.count(); ++level) {
    const Size3& below = levels.size(level - 1);
    const Size3& size = levels.size(level);
    const HalvingMask mask = levels.halving(level - 1);
    std::vector<float> low(static_cast<std::size_t>(size.voxel_count()), kNan);
    std::vector<float> high = low;
    for (std::int64_t i = 0; i < below.voxel_count(); ++i) {
      const float v = fine[static_cast<std::size_t>(i)];
      if (!std::isfinite(v)) continue;
      const Index3 at{i % below.x >> (mask & 1), i / below.x % below.y >> (mask >> 1 & 1),
                      i / (below.x * below.y) >> (mask >> 2 & 1)};
      const auto place = static_cast<std::size_t>((at.z * size.y + at.y) * size.x + at.x);
      low[place] = std::fmin(low[place], v);
      high[place] = std::fmax(high[place], v);
    }
    const std::vector<float> coarse = level_of(*reader, level);
    for (std::size_t i = 0; i < coarse.size(); ++i) {
      ASSERT_EQ(std::isnan(coarse[i]), std::isnan(low[i])) << "level " << level;
      if (std::isnan(coarse[i])) {
        ASSERT_EQ(std::bit_cast<std::uint32_t>(coarse[i]), 0x7fc00000u);
        continue;
      }
      ASSERT_GE(static_cast<double>(coarse[i]), static_cast<double>(low[i]) - 2 * step);
      ASSERT_LE(static_cast<double>(coarse[i]), static_cast<double>(high[i]) + 2 * step);
    }
    fine = coarse;
  }
}

/// Voxels [z][y][x], each asked for in this order.
std::vector<float> voxels_of(const Size3& size, const std::function<float(const Index3&)>& f) {
  std::vector<float> voxels;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) voxels.push_back(f({x, y, z}));
    }
  }
  return voxels;
}

/// Means of 2 x 2 x 2 samples.
std::vector<double> means_of(const std::vector<double>& fine, std::int64_t side) {
  std::vector<double> coarse(fine.size() / 8);
  for (std::size_t i = 0; i < fine.size(); ++i) {
    const auto at = static_cast<std::int64_t>(i);
    const std::int64_t x = at % side / 2;
    const std::int64_t y = at / side % side / 2;
    const std::int64_t z = at / side / side / 2;
    coarse[static_cast<std::size_t>((z * (side / 2) + y) * (side / 2) + x)] += fine[i] / 8;
  }
  return coarse;
}

TEST(ExactBuild, FewValuesHaveMeansBetweenThem) {
  constexpr std::int64_t kSide = 64;
  constexpr Size3 kCube{kSide, kSide, kSide};
  std::minstd_rand random(5);
  struct Case {
    const char* name;
    std::function<float(const Index3&)> voxel;
    double range;
    double max_error = 0;
  };
  const auto checker = [](const Index3& p) { return (p.x + p.y + p.z) % 2 == 0 ? 0.0f : 1000.0f; };
  const Case cases[] = {
      {"checkerboard", checker, 1000},
      {"checkerboard within 1", checker, 1000, 1},
      {"two", [&](const Index3&) { return random() % 10 < 3 ? 1.0f : 0.0f; }, 1},
      {"five", [&](const Index3&) { return static_cast<float>(random() % 5); }, 4},
      {"phases", [&](const Index3&) { return random() % 3 == 0 ? 0.35f : 1.25f; },
       double{1.25f} - double{0.35f}},
      {"one", [](const Index3& p) { return p == Index3{31, 32, 33} ? 6.0f : 5.0f; }, 1},
  };
  for (const Case& one : cases) {
    const ScratchFolder folder;
    const std::vector<float> voxels = voxels_of(kCube, one.voxel);
    Volume volume = volume_of(voxels);
    volume.description.size = kCube;
    build(volume, {.max_error = one.max_error}, folder.file("few.8vo"));
    const auto reader = open_file(folder.file("few.8vo"));
    const double step = reader->description().coding->scale;
    EXPECT_LE(step, one.range / 32) << one.name;
    std::vector<double> means(voxels.begin(), voxels.end());
    for (int level = 1; level <= 3; ++level) {
      means = means_of(means, kSide >> (level - 1));
      const std::vector<float> samples = level_of(*reader, level);
      ASSERT_EQ(samples.size(), means.size());
      double farthest = 0;
      for (std::size_t i = 0; i < means.size(); ++i) {
        farthest = std::max(farthest, std::abs(static_cast<double>(samples[i]) - means[i]));
      }
      EXPECT_LE(farthest, 1.5 * step) << one.name << " at level " << level;
    }
  }
}

TEST(ExactBuild, ValuesFarBeyondThoseOfTheFirstPlanesComeBack) {
  const ScratchFolder folder;
  std::mt19937 random(9);
  std::normal_distribution<float> noise(0, 1e-6f);
  // The spikes come behind the first group: 512 x 512 x 64 planes of 4 bytes.
  Volume volume;
  volume.description.type = VoxelType::float32;
  volume.description.size = {512, 512, 66};
  std::vector<float> voxels(512 * 512 * 66);
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = i % 512 < 16 ? noise(random) : 0;
  for (std::size_t i = 0; i < 600; ++i) {
    voxels[512 * 512 * 65 + 97 * i] = 3e30f + 1e28f * static_cast<float>(i);
  }
  const auto bytes = std::as_bytes(std::span(voxels));
  volume.voxels.assign(bytes.begin(), bytes.end());
  build(volume, {.preset = Preset::fast}, folder.file("v.8vo"));
  const auto reader = open_file(folder.file("v.8vo"));
  EXPECT_EQ(read_box(*reader, box_of(volume.description.size), 0), volume.voxels);
  EXPECT_GE(reader->description().voxel_of(reader->range().max), 3e30);
}

/// Faint noise at one side; far below it a voxel of the second group. The fourth group fails.
void fill_until_torn(const Box& box, std::byte* voxels) {
  if (box.hi.z > 192) throw Error(ErrorKind::source_rejected, "torn");
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x, voxels += sizeof(float)) {
        float voxel = x < 16 ? 1e-8f * static_cast<float>((7 * x + 13 * y + 5 * z) % 97) : 0;
        if (x == 100 && y == 200 && z == 70) voxel = -3e30f;
        std::memcpy(voxels, &voxel, sizeof voxel);
      }
    }
  }
}

// The index knows no end of such a range: missing planes get the lowest voxel that codes reach.
TEST(ExactBuild, WhatAnInterruptedOneLeftCanBeSealedWhereAFloatLiesBelowAllCodes) {
  VolumeDescription description;
  description.type = VoxelType::float32;
  description.size = {256, 512, 200};
  const auto torn = make_computed_source(description, fill_until_torn);
  MemoryStorage storage;
  NoProgress progress;
  EXPECT_THROW(build_file(*torn, storage, "b.8vo",
                          {.preset = Preset::fast, .interrupted = Interrupted::resume}, progress),
               Error);
  const auto sealed = seal_interrupted(storage, "b.8vo", "a.8vo", {}, progress);
  ASSERT_TRUE(sealed);
  EXPECT_GE(sealed->whole_planes, 128);
  const auto source = byte_source_of(*storage.files.at("a.8vo"), "a.8vo");
  EXPECT_TRUE(verify_file(source, {}, progress).is_sound());
  const auto reader = FileReader::open(source);
  EXPECT_TRUE(reader->description().is_unbounded(reader->range().min));
  const auto voxel_at = [&](const Index3& at) {
    float voxel = 0;
    reader->read({at, {at.x + 1, at.y + 1, at.z + 1}}, 0, &voxel);
    return voxel;
  };
  EXPECT_EQ(voxel_at({100, 200, 70}), -3e30f);
  EXPECT_EQ(voxel_at({0, 0, 199}), static_cast<float>(sealed->fill));
  EXPECT_EQ(sealed->fill, reader->description().voxel_of(2 - (std::int64_t{1} << 31)));
}

}  // namespace
}  // namespace octavo
