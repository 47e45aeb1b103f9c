// Interrupted builds, continued: the bytes of a build without a break.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "octavo/builder/builder.h"
#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "support/built_file.h"
#include "support/hints.h"
#include "support/memory_storage.h"
#include "support/texture_source.h"

namespace octavo {
namespace {

using octavo::testing::copied;
using octavo::testing::MemoryStorage;
using octavo::testing::TextureSource;

struct Kind {
  const char* name;
  VoxelType type;
  VolumeKind kind = VolumeKind::grey;
  double max_error = 0;
  Preset preset = Preset::small;
  bool is_alike = false;  ///< the groups, so that models of later ones refine the first
  int keep_details = 0;
};

TextureSource source_of(const Kind& kind, std::int64_t failing_plane = -1) {
  // Alike groups have six bricks each, others one.
  const Size3 size = kind.is_alike ? Size3{136, 72, 150} : Size3{40, 30, 150};
  TextureSource source(TextureSource::three_groups(kind.type, kind.kind, size), failing_plane);
  source.is_alike = kind.is_alike;
  return source;
}

BuildOptions options_of(const Kind& kind, Interrupted interrupted, int threads = 2) {
  BuildOptions options;
  options.kind = kind.kind;
  options.max_error = kind.max_error;
  options.preset = kind.preset;
  options.keep_details = kind.keep_details;
  options.interrupted = interrupted;
  options.threads = threads;
  return options;
}

BuildResult build(PlaneSource& source, MemoryStorage& storage, const BuildOptions& options) {
  NoProgress progress;
  return build_file(source, storage, "a.8vo", options, progress);
}

std::string failure_of(PlaneSource& source, MemoryStorage& storage, const BuildOptions& options,
                       ErrorKind kind) {
  try {
    build(source, storage, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return testing::with_hints(error);
  }
  ADD_FAILURE() << "the build succeeded";
  return {};
}

std::vector<std::uint8_t> built(const Kind& kind) {
  TextureSource source = source_of(kind);
  MemoryStorage storage;
  build(source, storage, options_of(kind, Interrupted::discard));
  EXPECT_EQ(std::count(storage.calls.begin(), storage.calls.end(), "create_scratch"), 0);
  return *storage.files.at("a.8vo");
}

constexpr Kind kGrey = {"grey", VoxelType::int16};

// What a build leaves that dies when the third of its groups is to be made durable.
std::map<std::string, octavo::testing::FileBytes> interrupted(const Kind& kind) {
  const BuildOptions options = options_of(kind, Interrupted::resume);
  TextureSource whole = source_of(kind);
  MemoryStorage storage;
  build(whole, storage, options);
  // Two calls make a group durable: one for the growing file, one for the journal.
  auto call = storage.calls.begin();
  for (int syncs = 0; syncs < 5; ++call) syncs += *call == "sync";
  TextureSource source = source_of(kind);
  MemoryStorage dying;
  dying.fail_at = static_cast<std::size_t>(call - storage.calls.begin());
  dying.is_dying = true;
  failure_of(source, dying, options, ErrorKind::io);
  EXPECT_EQ(dying.files.size(), 2u);
  return dying.files;
}

const std::map<std::string, octavo::testing::FileBytes>& interrupted_grey() {
  static const auto files = interrupted(kGrey);
  return files;
}

class ResumedBuild : public ::testing::Test {
  SmallGroups groups_{1};
};

TEST_F(ResumedBuild, IsNotOfferedWhereNoJournalIsWanted) {
  BuildOptions options = options_of(kGrey, Interrupted::reject);
  options.is_resumable = false;
  MemoryStorage whole;
  TextureSource first = source_of(kGrey);
  build(first, whole, options);
  // A program that dies when all but the last step is done leaves the growing file alone.
  const auto last = std::find(whole.calls.begin(), whole.calls.end(), "rename");
  MemoryStorage dying;
  dying.is_dying = true;
  dying.fail_at = static_cast<std::size_t>(last - whole.calls.begin()) + 1;
  TextureSource source = source_of(kGrey);
  failure_of(source, dying, options, ErrorKind::io);
  ASSERT_EQ(dying.files.size(), 1u);
  EXPECT_TRUE(dying.files.begin()->first.starts_with(".a.8vo.tmp-"));
  // It does not keep the next build from its work.
  MemoryStorage storage;
  storage.files = copied(dying.files);
  TextureSource again = source_of(kGrey);
  build(again, storage, options);
  EXPECT_TRUE(*storage.files.at("a.8vo") == *whole.files.at("a.8vo"));
  EXPECT_EQ(storage.files.size(), 1u);
}

class ResumedBuildOf : public ::testing::TestWithParam<Kind> {
  SmallGroups groups_{1};
};

TEST_P(ResumedBuildOf, HasTheBytesOfABuildWithoutABreak) {
  const Kind& kind = GetParam();
  const auto reference = built(kind);
  MemoryStorage storage;
  int threads = 1;
  for (const std::int64_t plane : {std::int64_t{70}, std::int64_t{149}}) {
    TextureSource torn = source_of(kind, plane);
    const BuildOptions options = options_of(kind, Interrupted::resume, threads++);
    const std::string message = failure_of(torn, storage, options, ErrorKind::source_rejected);
    const bool is_kept = storage.files.size() == 2;
    EXPECT_EQ(message.find("[interrupted=resume]") != std::string::npos, is_kept) << message;
    EXPECT_EQ(storage.files.count("a.8vo"), 0u);
  }
  TextureSource whole = source_of(kind);
  const BuildResult result = build(whole, storage, options_of(kind, Interrupted::resume, 4));
  EXPECT_GE(result.resumed_planes, 64) << "nothing was kept";
  EXPECT_TRUE(*storage.files.at("a.8vo") == reference);
  EXPECT_EQ(storage.files.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(
    EveryKind, ResumedBuildOf,
    ::testing::Values(kGrey, Kind{"fast", VoxelType::int16, VolumeKind::grey, 0, Preset::fast},
                      Kind{"alike", VoxelType::int16, VolumeKind::grey, 0, Preset::small, true},
                      Kind{"fast_alike", VoxelType::int16, VolumeKind::grey, 0, Preset::fast, true},
                      Kind{"lossy", VoxelType::int16, VolumeKind::grey, 2},
                      Kind{"lossy_alike", VoxelType::int16, VolumeKind::grey, 2, Preset::small,
                           true},
                      Kind{"details_left_out", VoxelType::int16, VolumeKind::grey, 0, Preset::fast,
                           true, 2},
                      Kind{"labels", VoxelType::uint16, VolumeKind::labels},
                      Kind{"float", VoxelType::float32},
                    Kind{"lossy_float", VoxelType::float32, VolumeKind::grey, 0.25}),
    [](const auto& of) { return std::string(of.param.name); });

TEST_F(ResumedBuild, HasTheThumbnailOfABuildWithoutABreak) {
  BuildOptions options = options_of(kGrey, Interrupted::resume);
  options.has_thumbnail = true;
  TextureSource whole = source_of(kGrey);
  MemoryStorage unbroken;
  build(whole, unbroken, options);
  MemoryStorage storage;
  TextureSource torn = source_of(kGrey, 149);
  failure_of(torn, storage, options, ErrorKind::source_rejected);
  TextureSource again = source_of(kGrey);
  EXPECT_GE(build(again, storage, options).resumed_planes, 64);
  EXPECT_TRUE(*storage.files.at("a.8vo") == *unbroken.files.at("a.8vo"));
}

TEST_F(ResumedBuild, NamesThePlanesThatChanged) {
  const auto files = interrupted_grey();
  const struct {
    std::int64_t plane;
    std::string words;
  } changes[] = {{3, "the first planes hold other voxels"},
                 {100, "planes 64 to 127 of 150 are not those of the interrupted build"}};
  for (const auto& change : changes) {
    MemoryStorage storage;
    storage.files = copied(files);
    TextureSource source = source_of(kGrey);
    source.changed_plane = change.plane;
    const std::string message = failure_of(source, storage, options_of(kGrey, Interrupted::resume),
                                           ErrorKind::source_rejected);
    EXPECT_NE(message.find(change.words), std::string::npos) << message;
    EXPECT_EQ(storage.files.size(), 2u);
  }
  MemoryStorage storage;
  storage.files = copied(files);
  TextureSource source = source_of(kGrey);
  EXPECT_EQ(build(source, storage, options_of(kGrey, Interrupted::resume)).resumed_planes, 128);
}

TEST_F(ResumedBuild, NamesTheSettingThatChanged) {
  const auto files = interrupted_grey();
  const auto reject = [&](PlaneSource& source, const BuildOptions& options,
                          const std::string& words) {
    MemoryStorage storage;
    storage.files = copied(files);
    const std::string message = failure_of(source, storage, options, ErrorKind::invalid_argument);
    EXPECT_NE(message.find(words), std::string::npos) << message;
    EXPECT_EQ(storage.files.size(), 2u);
  };
  TextureSource source = source_of(kGrey);
  BuildOptions options = options_of(kGrey, Interrupted::resume);
  options.preset = Preset::fast;
  reject(source, options,
         "another preset: small there, fast now; the interrupted build is kept "
         "[interrupted.preset=small] [interrupted=discard]");
  TextureSource cut = source_of(kGrey);
  options = options_of(kGrey, Interrupted::resume);
  options.access = Access::boxes;
  reject(cut, options,
         "another access: not given there, boxes now; the interrupted build is kept "
         "[interrupted.access] [interrupted=discard]");
  TextureSource shown = source_of(kGrey);
  options = options_of(kGrey, Interrupted::resume);
  options.has_thumbnail = true;
  reject(shown, options,
         "another thumbnail: not given there, given now; the interrupted build is kept "
         "[interrupted.thumbnail] [interrupted=discard]");
  TextureSource again = source_of(kGrey);
  options = options_of(kGrey, Interrupted::resume);
  options.max_error = 3;
  reject(again, options, "another max error: 0 there, 3 now");
  TextureSource moved = source_of(kGrey);
  moved.mutable_description().geometry.origin_mm[0] = 5;
  reject(moved, options_of(kGrey, Interrupted::resume), "another origin: 0 0 0 there, 5 0 0 now");
}

TEST_F(ResumedBuild, NamesAnotherReplacementOfNaN) {
  const Kind floats = {"float", VoxelType::float32};
  MemoryStorage storage;
  storage.files = interrupted(floats);
  TextureSource source = source_of(floats);
  BuildOptions options = options_of(floats, Interrupted::resume);
  options.repair.nan = 0.0F;
  const std::string message =
      failure_of(source, storage, options, ErrorKind::invalid_argument);
  EXPECT_NE(message.find("another replacement of NaN: not given there, 0 now; the interrupted "
                         "build is kept [interrupted.repair.nan] [interrupted=discard]"),
            std::string::npos)
      << message;
}

TEST_F(ResumedBuild, IsRejectedOrDiscardedWhereNobodyAskedForIt) {
  const auto files = interrupted_grey();
  MemoryStorage storage;
  storage.files = copied(files);
  TextureSource source = source_of(kGrey);
  const std::string message =
      failure_of(source, storage, options_of(kGrey, Interrupted::reject), ErrorKind::io);
  EXPECT_NE(message.find("planes 0 to 127 of 150"), std::string::npos) << message;
  EXPECT_NE(message.find("[interrupted]"), std::string::npos) << message;
  EXPECT_EQ(storage.files.size(), 2u);
  EXPECT_EQ(failure_of(source, storage, {}, ErrorKind::io), message);
  build(source, storage, options_of(kGrey, Interrupted::discard));
  EXPECT_EQ(storage.files.size(), 1u);
}

TEST_F(ResumedBuild, NothingIsRejectedForTheSakeOfGroupsThatAreNotWhole) {
  MemoryStorage storage;
  storage.files = copied(interrupted_grey());
  for (const auto& [name, bytes] : storage.files) {
    if (!name.ends_with(".journal")) bytes->at(700) ^= 1;
  }
  TextureSource source = source_of(kGrey);
  build(source, storage, options_of(kGrey, Interrupted::reject));
  EXPECT_EQ(storage.files.size(), 1u);
}

TEST_F(ResumedBuild, NothingIsKeptOfABuildThatDidNotAskForIt) {
  TextureSource source = source_of(kGrey, 140);
  MemoryStorage storage;
  const std::string message = failure_of(source, storage, options_of(kGrey, Interrupted::reject),
                                         ErrorKind::source_rejected);
  EXPECT_EQ(message.find("kept"), std::string::npos) << message;
  EXPECT_TRUE(storage.files.empty());
}

}  // namespace
}  // namespace octavo
