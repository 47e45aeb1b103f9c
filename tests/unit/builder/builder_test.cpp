#include "octavo/builder/build_memory.h"
#include "octavo/builder/builder.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "octavo/core/error.h"
#include "octavo/planes/phantom.h"
#include "support/built_file.h"
#include "support/texture_source.h"

namespace octavo {
namespace {

using octavo::testing::ScratchFolder;
using octavo::testing::TextureSource;

PhantomOptions one_group() {
  PhantomOptions options;
  options.size = {70, 66, 130};
  options.noise_sigma = 3;
  return options;
}

// Counts what is announced and done; asks to stop after some units.
class CountingProgress final : public Progress {
 public:
  explicit CountingProgress(std::int64_t stop_after = -1) : stop_after_(stop_after) {}
  void begin(std::string_view, std::int64_t total, std::string_view) override { total_ += total; }
  void advance(std::int64_t units) override { done_ += units; }
  void end() override { ++ends_; }
  bool is_cancelled() const override { return stop_after_ >= 0 && done_ >= stop_after_; }

  std::int64_t stop_after_;
  std::int64_t total_ = 0;
  std::atomic<std::int64_t> done_ = 0;
  int ends_ = 0;
};

ErrorKind kind_of_failure(PlaneSource& source, const std::string& path, const BuildOptions& options,
                          Progress& progress) {
  try {
    build_file(source, local_storage(), path, options, progress);
  } catch (const Error& error) {
    return error.kind();
  }
  ADD_FAILURE() << "the build succeeded";
  return ErrorKind::internal;
}

TEST(Builder, ASourceThatFailsAtAnyPlaneLeavesNoFile) {
  const ScratchFolder folder;
  for (const std::int64_t k : {0, 1, 63, 64, 100, 128, 149}) {
    TextureSource source(TextureSource::three_groups(), k);
    CountingProgress progress;
    EXPECT_EQ(kind_of_failure(source, folder.file("a.8vo"), {.threads = 2}, progress),
              ErrorKind::source_rejected);
    EXPECT_TRUE(folder.is_empty()) << "plane " << k;
    EXPECT_EQ(progress.ends_, 1);
  }
}

TEST(Builder, ACancelledBuildLeavesNoFile) {
  const ScratchFolder folder;
  for (const std::int64_t units : {0, 1, 70, 150, 299}) {
    TextureSource source(TextureSource::three_groups());
    CountingProgress progress(units);
    EXPECT_EQ(kind_of_failure(source, folder.file("a.8vo"), {.threads = 2}, progress),
              ErrorKind::cancelled);
    EXPECT_TRUE(folder.is_empty()) << units << " units";
  }
}

TEST(Builder, ProgressCountsEveryPlaneReadAndEncoded) {
  const ScratchFolder folder;
  const auto one = make_phantom(one_group());
  TextureSource three(TextureSource::three_groups());
  for (PlaneSource* const source : {one.get(), static_cast<PlaneSource*>(&three)}) {
    CountingProgress progress;
    build_file(*source, local_storage(), folder.file("a.8vo"), {.overwrite = true}, progress);
    EXPECT_EQ(progress.total_, 2 * source->description().size.z);
    EXPECT_EQ(progress.done_, progress.total_);
    EXPECT_EQ(progress.ends_, 1);
  }
}

TEST(Builder, FileDoesNotDependOnThreads) {
  const ScratchFolder folder;
  std::string first;
  for (const int threads : {1, 2, 3, 8}) {
    const std::string path = folder.file(std::to_string(threads));
    NoProgress progress;
    TextureSource source(TextureSource::three_groups());
    const BuildResult result =
        build_file(source, local_storage(), path, {.threads = threads}, progress);
    const std::string bytes = octavo::testing::bytes_of_file(path);
    EXPECT_EQ(result.file_bytes, bytes.size());
    EXPECT_EQ(result.raw_bytes, 512u * 512 * 150 * 2);
    EXPECT_EQ(result.threads, threads);
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first) << threads << " threads";
  }
}

TEST(Builder, WhatCannotBeBuiltIsRejectedBeforeAnythingIsRead) {
  const ScratchFolder folder;
  octavo::testing::Volume volume;
  volume.description.type = VoxelType::float32;
  volume.description.size = {2, 2, 2};
  volume.voxels.resize(32);
  const BuildOptions rejected[] = {{.kind = VolumeKind::labels},
                                   {.kind = VolumeKind::labels, .max_error = 1},
                                   {.max_error = -1},
                                   {.max_error = HUGE_VAL},
                                   {.max_error = NAN}};
  for (const BuildOptions& options : rejected) {
    const auto source = make_memory_source(volume.description, volume.voxels);
    CountingProgress progress;
    EXPECT_EQ(kind_of_failure(*source, folder.file("a.8vo"), options, progress),
              ErrorKind::invalid_argument);
    EXPECT_EQ(progress.total_, 0);
  }
}

TEST(Builder, FloatVoxelsComeBackBitByBitAtAnySizeAndBox) {
  const ScratchFolder folder;
  for (const Size3& size : {Size3{1, 1, 1}, Size3{1, 7, 1}, Size3{65, 1, 66}, Size3{70, 66, 65}}) {
    octavo::testing::Volume volume;
    volume.description.type = VoxelType::float32;
    volume.description.size = size;
    for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
      const auto voxel = static_cast<float>(static_cast<double>(i * i % 1013 - 500) * 0.3);
      const auto* const bytes = reinterpret_cast<const std::byte*>(&voxel);
      volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof voxel);
    }
    const std::string path = folder.file("f.8vo");
    std::filesystem::remove(path);
    octavo::testing::build_volume(volume, path, 2);
    const auto reader = octavo::testing::open_file(path);
    EXPECT_EQ(reader->description().type, VoxelType::float32);
    const Box whole = box_of(size);
    EXPECT_EQ(octavo::testing::read_box(*reader, whole, 0), volume.voxels);
    const Box last{{size.x - 1, size.y - 1, size.z - 1}, {size.x, size.y, size.z}};
    EXPECT_EQ(octavo::testing::read_box(*reader, last, 0),
              octavo::testing::crop(volume.voxels, size, 4, last));
  }
}

TEST(Builder, ABrokenFloatSourceLeavesNoFile) {
  const ScratchFolder folder;
  octavo::testing::Volume volume;
  volume.description.type = VoxelType::float32;
  volume.description.size = {512, 512, 70};
  std::vector<float> voxels(512 * 512 * 70);
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<float>(i % 100);
  voxels[512 * 512 * 69 + 1] = std::numeric_limits<float>::quiet_NaN();
  const auto* const bytes = reinterpret_cast<const std::byte*>(voxels.data());
  volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(float));
  const auto source = make_memory_source(volume.description, volume.voxels);
  CountingProgress progress;
  EXPECT_EQ(kind_of_failure(*source, folder.file("a.8vo"), {.max_error = 2}, progress),
            ErrorKind::source_rejected);
  EXPECT_TRUE(folder.is_empty());
}

TEST(Builder, AMemoryLimitBelowTheNeedStopsItBeforeItStarts) {
  const ScratchFolder folder;
  const auto source = make_phantom(one_group());
  CountingProgress progress;
  const std::uint64_t need = build_memory_bytes(source->description(), 1);
  EXPECT_EQ(kind_of_failure(*source, folder.file("a.8vo"),
                            {.threads = 1, .max_memory_bytes = need - 1}, progress),
            ErrorKind::limit_exceeded);
  EXPECT_EQ(progress.total_, 0);
  build_file(*source, local_storage(), folder.file("a.8vo"),
             {.threads = 1, .max_memory_bytes = need}, progress);
}

TEST(Builder, MemoryIsThatOfTwoGroupsAndTheWorkers) {
  VolumeDescription description;
  description.type = VoxelType::int16;
  description.size = {1024, 1024, 1024};
  const std::uint64_t mib = 1 << 20;
  EXPECT_EQ(build_memory_bytes(description, 2), (2 * 128 + 2 * 24 + 192) * mib);
  description.size = {256, 256, 4096};
  EXPECT_EQ(build_memory_bytes(description, 1), (2 * 32 + 24 + 192) * mib);
  description.size = {10, 10, 10};
  EXPECT_EQ(build_memory_bytes(description, 1), 2 * 2000 + (24 + 192) * mib);
}

TEST(Builder, AnExistingFileIsKeptUnlessOverwriteIsAsked) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  std::ofstream(path) << "precious";
  CountingProgress progress;
  const auto source = make_phantom(one_group());
  EXPECT_EQ(kind_of_failure(*source, path, {}, progress), ErrorKind::io);
  EXPECT_EQ(octavo::testing::bytes_of_file(path), "precious");
  const auto again = make_phantom(one_group());
  build_file(*again, local_storage(), path, {.overwrite = true}, progress);
  EXPECT_NE(octavo::testing::bytes_of_file(path), "precious");
}

}  // namespace
}  // namespace octavo
