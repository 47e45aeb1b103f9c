// However many ranks build a file, and however often they are interrupted, it is that of one build.
#include "octavo/dist/rank_build.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <random>

#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/dist/rank_journal.h"
#include "octavo/dist/thread_ranks.h"
#include "octavo/planes/between/isotropic_source.h"
#include "octavo/planes/phantom.h"
#include "support/built_file.h"
#include "support/dying_storage.h"
#include "support/failure_text.h"
#include "support/goal_cases.h"
#include "support/texture_source.h"

namespace octavo {
namespace {

using testing::DyingStorage;
using testing::expect_words;
using testing::failure_of;
using testing::ScratchFolder;
using testing::TextureSource;

using OpenSource = std::function<std::unique_ptr<PlaneSource>()>;

constexpr int kMostRanks = 8;
constexpr Size3 kSevenGroups = {70, 20, 6 * TextureSource::kGroupPlanes + 16};

VolumeDescription seven_groups(VoxelType type = VoxelType::int16,
                               VolumeKind kind = VolumeKind::grey) {
  VolumeDescription description = TextureSource::three_groups(type, kind);
  description.size = kSevenGroups;
  return description;
}

/// Groups of one layer of bricks: six of 64 planes, and one of 16.
OpenSource ranked_texture(VoxelType type, VolumeKind kind = VolumeKind::grey) {
  return [=] { return std::make_unique<TextureSource>(seven_groups(type, kind)); };
}

/// Three groups of a brick each: enough where the kind of the volume matters.
OpenSource small_texture(VoxelType type, VolumeKind kind = VolumeKind::grey) {
  const Size3 size = {40, 30, TextureSource::kThreeGroups.z};
  return [=] {
    return std::make_unique<TextureSource>(TextureSource::three_groups(type, kind, size));
  };
}

/// Fails in the last group.
std::unique_ptr<PlaneSource> torn_source() {
  return std::make_unique<TextureSource>(seven_groups(), kSevenGroups.z - 10);
}

BuildOptions ranked_options(Preset preset, double max_error = 0) {
  BuildOptions options;
  options.preset = preset;
  options.max_error = max_error;
  options.threads = 1;
  return options;
}

/// The same volume built by one program and by ranks.
class RankBuild : public ::testing::Test {
 protected:
  std::string path() const { return folder_.file("a.8vo"); }

  std::string whole(const OpenSource& open, const BuildOptions& options) {
    NoProgress progress;
    const std::string name = folder_.file("whole.8vo");
    build_file(*open(), undying_, name, options, progress);
    const auto bytes = testing::bytes_of_file(name);
    std::filesystem::remove(name);
    return bytes;
  }

  BuildResult build(int ranks, const OpenSource& open, const BuildOptions& options,
                    RankBuildOptions by_ranks = {}, DyingStorage* dying = nullptr) {
    BuildResult result;
    NoProgress progress;
    const BuildPlan plan = plan_build(*open(), options, progress);
    by_ranks.work.threads = 1;
    Storage& storage = dying != nullptr ? *dying : undying_;
    run_thread_ranks(ranks, [&](Communicator& own) {
      NoProgress quiet;
      const auto source = open();
      try {
        const BuildResult one =
            build_by_ranks(plan, *source, own, storage, path(), by_ranks, quiet);
        if (own.is_first()) result = one;
      } catch (const Error& error) {
        if (error.kind() == ErrorKind::invalid_argument) ++rejections_;
        throw;
      }
    });
    return result;
  }

  void expect_same(const OpenSource& open, const BuildOptions& options,
                   const std::vector<int>& rank_counts) {
    const auto expected = whole(open, options);
    for (const int ranks : rank_counts) {
      SCOPED_TRACE(std::to_string(ranks) + " ranks");
      const BuildResult result = build(ranks, open, options);
      EXPECT_EQ(result.file_bytes, expected.size());
      ASSERT_TRUE(testing::bytes_of_file(path()) == expected);
      EXPECT_EQ(file_count(), 1u) << "something is left behind";
      std::filesystem::remove(path());
    }
  }

  std::size_t file_count() const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.file(""))) {
      count += entry.is_regular_file() ? 1u : 0u;
    }
    return count;
  }

  ScratchFolder folder_;
  DyingStorage undying_{local_storage(), 0};
  std::atomic<int> rejections_ = 0;  ///< of ranks, as wrong usage
  SmallGroups small_groups_{1};
};

TEST_F(RankBuild, GreyVolumesAreTheSameAtAnyNumberOfRanks) {
  expect_same(ranked_texture(VoxelType::int16), ranked_options(Preset::fast),
              {1, 2, 3, 4, 5, 6, 7, kMostRanks});
  expect_same(small_texture(VoxelType::uint16), ranked_options(Preset::small), {2, 3});
}

TEST_F(RankBuild, VolumesWithAMaxErrorAreTheSame) {
  expect_same(small_texture(VoxelType::int16), ranked_options(Preset::fast, 4), {2, 3});
}

TEST_F(RankBuild, VolumesWithoutDetailsAreTheSameUpToTheErrorsInTheirMetadata) {
  BuildOptions options = ranked_options(Preset::fast);
  options.keep_details = 1;
  expect_same(ranked_texture(VoxelType::int16), options, {2, 3});
}

TEST_F(RankBuild, LabelsAreTheSame) {
  BuildOptions options = ranked_options(Preset::small);
  options.kind = VolumeKind::labels;
  expect_same(small_texture(VoxelType::uint16, VolumeKind::labels), options, {2, 3});
}

TEST_F(RankBuild, FloatsAreTheSameBitByBitAndWithinAMaxError) {
  expect_same(small_texture(VoxelType::float32), ranked_options(Preset::fast), {2});
  expect_same(small_texture(VoxelType::float32), ranked_options(Preset::fast, 0.3), {3});
}

TEST_F(RankBuild, ThumbnailsAreTheSame) {
  BuildOptions options = ranked_options(Preset::fast);
  options.has_thumbnail = true;
  expect_same(ranked_texture(VoxelType::int16), options, {3});
}

TEST_F(RankBuild, IsotropicVolumesAreTheSame) {
  const OpenSource open = [] {
    PhantomOptions phantom;
    phantom.size = {90, 80, 100};
    phantom.spacing_mm = {1, 1, 2.4};
    phantom.noise_sigma = 4;
    auto source = make_phantom(phantom);
    const IsotropicPlan plan = plan_isotropic(source->description(), PlaneInterpolation::cubic);
    return make_isotropic_source(std::move(source), plan);
  };
  expect_same(open, ranked_options(Preset::fast), {2, 3});
}

TEST_F(RankBuild, FilesAreTheSameByEitherPlan) {
  const BuildOptions options = ranked_options(Preset::fast);
  const OpenSource open = ranked_texture(VoxelType::int16);
  const auto expected = whole(open, options);
  RankBuildOptions mesh;
  mesh.gather = GatherPlan::mesh;
  mesh.overwrite = true;
  for (const int ranks : {1, 2, 4, 7}) {
    build(ranks, open, options, mesh);
    EXPECT_TRUE(testing::bytes_of_file(path()) == expected) << ranks;
  }
}

// Wherever a job breaks off, one of any other size goes on behind the groups that are whole.
TEST_F(RankBuild, InterruptedJobsAreContinuedByAnyNumberOfRanks) {
  const BuildOptions options = ranked_options(Preset::fast);
  const OpenSource open = ranked_texture(VoxelType::int16);
  const auto expected = whole(open, options);
  DyingStorage counted(local_storage(), 0);
  build(3, open, options, {}, &counted);
  std::filesystem::remove(path());
  const auto calls = static_cast<int>(counted.calls());
  ASSERT_GT(calls, 60);

  testing::GoalCases cases("R1", "jobs of ranks that were interrupted",
                           testing::case_count(12, 1000));
  std::mt19937 random(19);
  const auto any = [&](int most) { return static_cast<int>(random() % unsigned(most)) + 1; };
  int resumed = 0;
  while (cases.next()) {
    SCOPED_TRACE(cases.done());
    for (int jobs = any(3); jobs > 0 && !std::filesystem::exists(path()); --jobs) {
      DyingStorage dying(local_storage(), static_cast<std::size_t>(any(calls)));
      try {
        build(any(kMostRanks), open, options, {}, &dying);
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::io) << error.what();
      }
    }
    if (!std::filesystem::exists(path())) {
      resumed += build(any(kMostRanks), open, options).resumed_planes > 0 ? 1 : 0;
      EXPECT_EQ(file_count(), 1u) << "something is left behind";
    }
    ASSERT_TRUE(testing::bytes_of_file(path()) == expected);
    std::filesystem::remove(path());
  }
  EXPECT_GT(resumed, 0);
}

TEST_F(RankBuild, AFailingSourceLeavesNoFileAndWhatIsWhole) {
  const BuildOptions options = ranked_options(Preset::fast);
  const OpenSource sound = ranked_texture(VoxelType::int16);
  expect_words(
      failure_of([&] { build(2, torn_source, options); }, ErrorKind::source_rejected),
      {"slice.dcm", "torn"});
  EXPECT_FALSE(std::filesystem::exists(path()));
  EXPECT_TRUE(std::filesystem::exists(ranks_name(path())));
  EXPECT_GT(build(3, sound, options).resumed_planes, 0);
  EXPECT_TRUE(testing::bytes_of_file(path()) == whole(sound, options));
}

TEST_F(RankBuild, WhatIsLeftOfOtherWorkIsRejectedUnlessDiscarded) {
  const BuildOptions options = ranked_options(Preset::fast);
  failure_of([&] { build(2, torn_source, options); }, ErrorKind::source_rejected);
  const OpenSource sound = ranked_texture(VoxelType::int16);
  const BuildOptions other = ranked_options(Preset::fast, 2);
  expect_words(failure_of([&] { build(2, sound, other); }, ErrorKind::invalid_argument),
               {"a.8vo", "max error", "ranks.interrupted=discard"});
  EXPECT_EQ(rejections_, 1) << "one rank says so";
  RankBuildOptions discarding;
  discarding.discards_interrupted = true;
  EXPECT_EQ(build(2, sound, other, discarding).resumed_planes, 0);
  EXPECT_TRUE(testing::bytes_of_file(path()) == whole(sound, other));
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(RankBuild, TwoJobsDoNotWorkOnOneFile) {
  const auto held = undying_.create_exclusive(ranks_name(path()));
  const OpenSource open = ranked_texture(VoxelType::int16);
  expect_words(
      failure_of([&] { build(2, open, ranked_options(Preset::fast)); }, ErrorKind::io),
      {"a.8vo", "another job"});
}

TEST_F(RankBuild, AJobIsContinuedWhereFilesCannotBeLocked) {
  undying_.lose_locks();
  const BuildOptions options = ranked_options(Preset::fast);
  const OpenSource sound = ranked_texture(VoxelType::int16);
  failure_of([&] { build(2, torn_source, options); }, ErrorKind::source_rejected);
  EXPECT_GT(build(3, sound, options).resumed_planes, 0);
  EXPECT_TRUE(testing::bytes_of_file(path()) == whole(sound, options));
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(RankBuild, AnExistingFileStays) {
  const OpenSource open = ranked_texture(VoxelType::int16);
  const BuildOptions options = ranked_options(Preset::fast);
  build(1, open, options);
  expect_words(failure_of([&] { build(2, open, options); }, ErrorKind::io),
               {"a.8vo", "exists already"});
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(RankBuild, AnotherSourceThanThePlannedOneIsRejected) {
  NoProgress progress;
  const BuildPlan plan = plan_build(*ranked_texture(VoxelType::int16)(),
                                    ranked_options(Preset::fast), progress);
  const auto work = [&](Communicator& ranks) {
    NoProgress quiet;
    const VoxelType type = ranks.rank() == 1 ? VoxelType::uint16 : VoxelType::int16;
    const auto source = ranked_texture(type)();
    build_by_ranks(plan, *source, ranks, undying_, path(), {.work = {.threads = 1}}, quiet);
  };
  expect_words(failure_of([&] { run_thread_ranks(2, work); }, ErrorKind::source_rejected),
               {"voxel type", "plan again"});
  EXPECT_FALSE(std::filesystem::exists(path()));
}

}  // namespace
}  // namespace octavo
