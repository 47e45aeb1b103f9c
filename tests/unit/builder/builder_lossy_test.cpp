// Builds with a max error, through a codec that goes as far as it may.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "octavo/core/error.h"
#include "octavo/file/verify.h"
#include "support/built_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

template <class T>
Volume make_volume(const Size3& size, const std::vector<T>& voxels) {
  Volume volume;
  volume.description.type = voxel_type_of<T>();
  volume.description.size = size;
  const auto* const bytes = reinterpret_cast<const std::byte*>(voxels.data());
  volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(T));
  return volume;
}

template <class T>
std::vector<T> voxels_of(const std::vector<std::byte>& bytes) {
  std::vector<T> voxels(bytes.size() / sizeof(T));
  std::memcpy(voxels.data(), bytes.data(), bytes.size());
  return voxels;
}

constexpr Size3 kSize{130, 70, 129};

Volume noisy_volume() {
  std::mt19937 random(4);
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(kSize.voxel_count()));
  // One brick corner is constant, so that not all bricks reach the same error.
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = i % 130 < 64 ? std::int16_t{8} : static_cast<std::int16_t>(random() % 1000);
  }
  voxels[0] = INT16_MIN;
  voxels[1] = INT16_MAX;
  return make_volume(kSize, voxels);
}

std::shared_ptr<FileReader> build(const Volume& volume, const BuildOptions& options,
                                  const std::string& path) {
  const auto source = make_memory_source(volume.description, volume.voxels);
  NoProgress progress;
  build_file(*source, local_storage(), path, options, progress);
  return open_file(path);
}

bool is_sound(const std::string& path) {
  NoProgress progress;
  return verify_file(open_byte_source(local_storage(), path), {}, progress).is_sound();
}

// The largest difference between the file and its source inside a box.
template <class T>
double found_error(const FileReader& reader, const Volume& volume, const Box& box) {
  const auto got = voxels_of<T>(read_box(reader, box, 0));
  const auto meant = voxels_of<T>(crop(volume.voxels, volume.description.size, sizeof(T), box));
  double largest = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    largest =
        std::max(largest, std::abs(static_cast<double>(got[i]) - static_cast<double>(meant[i])));
  }
  return largest;
}

TEST(LossyBuild, TheIndexSaysOfEveryBrickHowFarItIsFromItsSource) {
  const ScratchFolder folder;
  Volume volume = noisy_volume();
  volume.description.rescale.slope = -2;
  // 7 real units are 3.5 stored ones, of which 3 are whole.
  const auto reader = build(volume, {.max_error = 7}, folder.file("a.8vo"));
  EXPECT_EQ(reader->max_error(), 3);
  EXPECT_EQ(reader->achieved_error(), 3);
  const Size3 grid = reader->levels().brick_grid(0);
  double minimum = 3;
  for (std::int64_t z = 0; z < grid.z; ++z) {
    for (std::int64_t y = 0; y < grid.y; ++y) {
      for (std::int64_t x = 0; x < grid.x; ++x) {
        const BrickEntry entry = reader->brick(0, {x, y, z});
        const Box box = reader->levels().brick_box(0, {x, y, z});
        EXPECT_EQ(entry.max_error, found_error<std::int16_t>(*reader, volume, box));
        minimum = std::min(minimum, entry.max_error);
      }
    }
  }
  EXPECT_EQ(minimum, 0);
  EXPECT_TRUE(is_sound(folder.file("a.8vo")));
}

TEST(LossyBuild, TiersAboveTheFirstAreExactAndHaveAModelOfTheirOwn) {
  const ScratchFolder folder;
  const auto reader = build(noisy_volume(), {.max_error = 3}, folder.file("a.8vo"));
  const Size3 top = reader->levels().size(6);
  const auto samples = voxels_of<std::int16_t>(read_box(*reader, box_of(top), 6));
  std::size_t i = 0;
  for (std::int64_t z = 0; z < top.z; ++z) {
    for (std::int64_t y = 0; y < top.y; ++y) {
      for (std::int64_t x = 0; x < top.x; ++x) {
        // The codec's coarse sample is the first voxel as it comes out.
        const Index3 corner{64 * x, 64 * y, 64 * z};
        const Box one{corner, {corner.x + 1, corner.y + 1, corner.z + 1}};
        EXPECT_EQ(samples[i++], voxels_of<std::int16_t>(read_box(*reader, one, 0))[0]);
      }
    }
  }
  EXPECT_EQ(reader->brick(0, {0, 0, 2}).model, 0u);
  EXPECT_EQ(reader->brick(1, {0, 0, 0}).model, 1u);
  EXPECT_EQ(reader->brick(1, {0, 0, 0}).max_error, 0);
}

TEST(LossyBuild, AnErrorBelowOneStoredStepIsLossless) {
  const ScratchFolder folder;
  Volume volume = noisy_volume();
  volume.description.rescale.slope = 0.1;
  const auto reader = build(volume, {.max_error = 0.09}, folder.file("a.8vo"));
  EXPECT_EQ(reader->max_error(), 0);
  EXPECT_EQ(read_box(*reader, box_of(kSize), 0), volume.voxels);
  // 0.3 / 0.1 is 3, though not in binary.
  EXPECT_EQ(build(volume, {.max_error = 0.3}, folder.file("b.8vo"))->max_error(), 3);
}

TEST(LossyBuild, FloatVoxelsStayWithinAnyError) {
  const ScratchFolder folder;
  std::mt19937 random(9);
  std::normal_distribution<float> noise(0, 100);
  std::vector<float> voxels(static_cast<std::size_t>(kSize.voxel_count()));
  for (float& v : voxels) v = noise(random);
  voxels[7] = -0.0f;
  voxels[8] = 1e-45f;
  voxels[9] = 54321.0f;
  const Volume volume = make_volume(kSize, voxels);
  for (const double e : {0.01, 0.25, 3.0, 777.0, 1e20}) {
    const std::string path = folder.file(std::to_string(e));
    const auto reader = build(volume, {.max_error = e}, path);
    const double found = found_error<float>(*reader, volume, box_of(kSize));
    EXPECT_LE(found, reader->achieved_error());
    EXPECT_LE(reader->achieved_error(), found + e / 1024);
    EXPECT_LE(reader->achieved_error(), reader->max_error());
    EXPECT_EQ(reader->max_error(), e);
    EXPECT_TRUE(is_sound(path));
  }
}

TEST(LossyBuild, SpikesThatRoundBeyondTheBoundAreRejectedWithAnErrorThatWorks) {
  const ScratchFolder folder;
  std::mt19937 random(9);
  std::normal_distribution<float> noise(0, 100);
  // The spikes come behind the first group, 512 x 512 x 64 planes of 4 bytes, where no plane is
  // looked at beforehand.
  const Size3 size{512, 512, 66};
  std::vector<float> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (float& v : voxels) v = noise(random);
  for (std::size_t i = 0; i < 600; ++i) {
    voxels[512 * 512 * 64 + i] = 3e7f + 2 * static_cast<float>(i);
  }
  const Volume volume = make_volume(size, voxels);
  try {
    build(volume, {.max_error = 1.9}, folder.file("a"));
    FAIL() << "the bound was kept";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_EQ(error.hints(), (std::vector<OptionHint>{{"max_error", "1"}})) << error.what();
  }
  EXPECT_TRUE(folder.is_empty());
  const auto reader = build(volume, {.max_error = 1}, folder.file("b"));
  EXPECT_LE(found_error<float>(*reader, volume, box_of(size)), 1);
}

TEST(LossyBuild, WhatWasAskedForStandsInTheMetadata) {
  const ScratchFolder folder;
  Volume volume = make_volume<float>({3, 3, 3}, std::vector<float>(27, 0.5f));
  const auto text = [&](const BuildOptions& options) {
    static int count = 0;
    return build(volume, options, folder.file(std::to_string(count++)))
        ->description()
        .metadata.text();
  };
  const std::string writer = R"("written_by":{"name":"octavo","revision":1}})";
  EXPECT_EQ(text({}), "{" + writer);
  EXPECT_EQ(text({.preset = Preset::fast}), R"({"coding":{"preset":"fast"},)" + writer);
  EXPECT_EQ(text({.access = Access::boxes}), R"({"coding":{"access":"boxes"},)" + writer);
  volume.description.metadata = Metadata::read(R"({"unit":"HU" })");
  EXPECT_EQ(text({.max_error = 0.5, .repair = {.nan = -1.5f, .infinity = 9.0f}}),
            R"({"unit":"HU","coding":{"max_error":0.5,"nan":-1.5,"inf":9},)" + writer);
}

TEST(LossyBuild, TheFileDoesNotDependOnThreads) {
  const ScratchFolder folder;
  const Volume volume = noisy_volume();
  build(volume, {.max_error = 5, .threads = 1}, folder.file("a"));
  build(volume, {.max_error = 5, .threads = 4}, folder.file("b"));
  EXPECT_EQ(bytes_of_file(folder.file("a")), bytes_of_file(folder.file("b")));
}

}  // namespace
}  // namespace octavo
