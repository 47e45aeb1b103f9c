// Parts, joins and ranks count the floats that only level 0 holds as a build in one piece does.
#include "octavo/dist/clipped_bytes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/dist/join_steps.h"
#include "octavo/dist/rank_build.h"
#include "octavo/dist/thread_ranks.h"
#include "support/built_file.h"
#include "support/part_volumes.h"

#include "support/small_parts.h"

namespace octavo::testing {
namespace {

/// Floats of which some in every group lie far from the others.
SmallVolume volume_of_fills() {
  SmallVolume volume = small_volume("fills", VoxelType::float32, {33, 20, 300});
  std::vector<float> floats(volume.voxels.size() / sizeof(float));
  for (std::size_t i = 0; i < floats.size(); ++i) {
    floats[i] = static_cast<float>(i % 1013) + static_cast<float>(i % 97) / 89;
    if (i % 5003 == 5002) floats[i] = i % 2 == 0 ? 1e20f : -2e20f;
  }
  std::memcpy(volume.voxels.data(), floats.data(), volume.voxels.size());
  return volume;
}

class ClippedOfParts : public ::testing::Test {
 protected:
  ClippedOfParts() {
    NoProgress progress;
    MemoryStorage storage;
    expected_ = build_file(*volume_.open(), storage, "a.8vo", volume_.options, progress).clipped;
    plan_ = planned(volume_);
    runs_ = {{2, plan_.group_count}, {0, 1}, {1, 2}};
  }

  SmallGroups groups_{kPartGroupBytes};
  SmallVolume volume_ = volume_of_fills();
  ClippedVoxels expected_;
  BuildPlan plan_;
  std::vector<GroupRun> runs_;
  MemoryStorage storage_;
};

TEST_F(ClippedOfParts, AreThoseOfABuild) {
  EXPECT_EQ(expected_.count, 33 * 20 * 300 / 5003);
  EXPECT_EQ(expected_.farthest, -2e20f);
  ASSERT_GE(plan_.group_count, 3);
  for (const std::uint64_t band_bytes : {0u, 4096u}) {
    for (const GroupRun& run : runs_) {
      make_part(volume_, plan_, run, storage_, "", 1, band_bytes);
      EXPECT_GT(PartFile::open(storage_, part_name(run))->clipped().count, 0);
    }
    EXPECT_EQ(joined(plan_, storage_, runs_).clipped, expected_) << band_bytes;
    storage_.files.clear();
  }
}

TEST_F(ClippedOfParts, AreKeptWhileAJoinConsumesThem) {
  std::vector<std::string> names;
  for (const GroupRun& run : runs_) {
    make_part(volume_, plan_, run, storage_);
    names.push_back(part_name(run));
  }
  NoProgress progress;
  const auto consume = [&](ClippedVoxels* clipped) {
    consume_parts(plan_, names, storage_, "a.8vo", false, {.threads = 1}, progress, clipped);
  };
  // Stopped once the first part is gone, then once the file has its name
  storage_.meanwhile = [&](const std::string&) {
    if (storage_.files.contains(names[0])) return;
    throw Error(ErrorKind::io, "killed");
  };
  EXPECT_THROW(consume(nullptr), Error);
  storage_.meanwhile = [&](const std::string&) {
    if (storage_.files.contains("a.8vo")) throw Error(ErrorKind::io, "killed");
  };
  ClippedVoxels clipped;
  EXPECT_THROW(consume(&clipped), Error);
  storage_.meanwhile = {};
  clipped = {};
  consume(&clipped);
  EXPECT_EQ(clipped, expected_);
}

TEST_F(ClippedOfParts, AreThoseOfAllRanks) {
  for (const int ranks : {1, 3}) {
    const ScratchFolder folder;
    ClippedVoxels clipped;
    run_thread_ranks(ranks, [&](Communicator& own) {
      NoProgress progress;
      RankBuildOptions options;
      options.work.threads = 1;
      const BuildResult result =
          build_by_ranks(plan_, *volume_.open(), own, local_storage(),
                                                folder.file("a.8vo"), options, progress);
      if (own.is_first()) clipped = result.clipped;
    });
    EXPECT_EQ(clipped, expected_) << ranks << " ranks";
  }
}

TEST(ClippedBytes, OtherBytesAreRejected) {
  const ClippedVoxels clipped{30, -1e20f, 7.5};
  const Bytes bytes = clipped_bytes(clipped);
  ByteSpan rest = bytes;
  EXPECT_EQ(take_clipped(rest, "a test"), clipped);
  EXPECT_TRUE(rest.empty());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    rest = ByteSpan(bytes).first(length);
    EXPECT_THROW(take_clipped(rest, "a test"), Error) << length;
  }
  Bytes many = bytes;
  many[7] = 0xff;
  rest = many;
  EXPECT_THROW(take_clipped(rest, "a test"), Error);
}

}  // namespace
}  // namespace octavo::testing
