// What an interrupted build left, sealed without its source.
#include "octavo/builder/recover.h"

#include <gtest/gtest.h>

#include <stdlib.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "octavo/core/error.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/verify.h"
#include "octavo/file/write/interrupted.h"
#include "support/recording_writer.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

// A build that ended behind some of its layers, each of which is a group.
struct Ended {
  SampleVolume volume;
  MemoryStorage storage;
  std::string growing;

  Ended(SampleVolume sample, std::size_t layers, const std::string& settings = {})
      : volume(std::move(sample)) {
    RecordingWriter recording;
    encode_sample(recording, volume);
    WriterOptions options;
    options.max_error = volume.max_error;
    options.has_journal = options.is_resuming = true;
    options.settings = settings;
    const auto writer = FileWriter::create(storage, "a.8vo", volume.description, volume.levels, 1,
                                           options);
    const Size3 grid = volume.levels.brick_grid(0);
    recording.replay(*writer, static_cast<std::size_t>(grid.x * grid.y), 0, layers);
    for (const auto& [name, bytes] : storage.files) {
      if (!name.ends_with(kJournalEnding)) growing = name;
    }
  }

  std::optional<SealResult> seal(const std::string& input = "a.8vo") {
    return seal_in(storage, input);
  }

  static std::optional<SealResult> seal_in(MemoryStorage& where, const std::string& input) {
    NoProgress progress;
    return seal_interrupted(where, input, "out.8vo", {.overwrite = true, .threads = 2}, progress);
  }
};

SampleVolume four_layers(VoxelType type, VolumeKind kind = VolumeKind::grey) {
  return make_sample({68, 9, 230}, type, Pattern::gradient, kind);
}

Box planes(const SampleVolume& volume, std::int64_t begin, std::int64_t end) {
  Box box = box_of(volume.levels.size(0));
  box.lo.z = begin;
  box.hi.z = end;
  return box;
}

bool is_sound(const MemoryStorage& storage) {
  NoProgress progress;
  return verify_file(byte_source_of(*storage.files.at("out.8vo"), "out.8vo"), {}, progress)
      .is_sound();
}

TEST(Repair, WholePlanesAreTheOriginalsAndTheOthersTheLowestValue) {
  const struct {
    const char* name;
    SampleVolume volume;
    std::uint8_t low;
  } cases[] = {{"uint8", four_layers(VoxelType::uint8), 0},
               {"int16", four_layers(VoxelType::int16), 0},
               {"labels", four_layers(VoxelType::uint16, VolumeKind::labels), 0}};
  for (const auto& c : cases) {
    for (const std::size_t layers : {1u, 2u, 3u}) {
      SCOPED_TRACE(c.name);
      Ended ended(c.volume, layers);
      const auto before = copied(ended.storage.files);
      const auto result = ended.seal();
      ASSERT_TRUE(result.has_value());
      const std::int64_t whole = 64 * static_cast<std::int64_t>(layers);
      EXPECT_EQ(result->whole_planes, whole);
      EXPECT_EQ(result->plane_count, 230);
      EXPECT_TRUE(is_sound(ended.storage));
      const auto reader = open_bytes(*ended.storage.files.at("out.8vo"));
      const Box there = planes(ended.volume, 0, whole);
      EXPECT_EQ(read_samples(*reader, there, 0), expected_samples(ended.volume, there, 0));
      const Bytes missing = read_samples(*reader, planes(ended.volume, whole, 230), 0);
      EXPECT_TRUE(std::ranges::all_of(missing, [&](std::uint8_t byte) { return byte == c.low; }));
      const std::string record = "\"repaired\":{\"missing_planes\":[" + std::to_string(whole) +
                                 ",229],\"fill\":0}";
      EXPECT_NE(reader->description().metadata.text().find(record), std::string::npos)
          << reader->description().metadata.text();
      // What was left stays as it was.
      for (const auto& [name, bytes] : before) EXPECT_TRUE(*ended.storage.files.at(name) == *bytes);
    }
  }
}

TEST(Repair, ALossyFloatFileKeepsItsBound) {
  Ended ended(make_lossy_float_sample(), 1);
  ASSERT_TRUE(ended.seal().has_value());
  EXPECT_TRUE(is_sound(ended.storage));
  const auto reader = open_bytes(*ended.storage.files.at("out.8vo"));
  EXPECT_EQ(reader->max_error(), 1.5);
  const Box there = planes(ended.volume, 0, 64);
  const Bytes bytes = read_samples(*reader, there, 0);
  const Bytes& codes = ended.volume.samples[0];
  for (std::size_t i = 0; i < bytes.size() / 4; ++i) {
    float voxel = 0;
    std::memcpy(&voxel, bytes.data() + 4 * i, sizeof voxel);
    ASSERT_LE(std::abs(static_cast<double>(voxel) - (0.5 * codes[i] - 1)), 1.5) << i;
  }
}

TEST(Repair, WhereEveryPlaneIsWholeNothingIsMissing) {
  Ended ended(four_layers(VoxelType::uint8), 4);
  const auto result = ended.seal();
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->whole_planes, 230);
  EXPECT_TRUE(is_sound(ended.storage));
  const auto reader = open_bytes(*ended.storage.files.at("out.8vo"));
  EXPECT_EQ(reader->description().metadata.text(), ended.volume.description.metadata.text());
  for (int level = 0; level < ended.volume.levels.count(); ++level) {
    const Box all = box_of(ended.volume.levels.size(level));
    EXPECT_EQ(read_samples(*reader, all, level), expected_samples(ended.volume, all, level));
  }
}

TEST(Repair, AThumbnailThatWasAskedForIsMade) {
  for (const std::string settings : {"", "thumbnail: not given\n", "thumbnail: given\n"}) {
    Ended ended(four_layers(VoxelType::uint8), 2, settings);
    ASSERT_TRUE(ended.seal().has_value());
    EXPECT_TRUE(is_sound(ended.storage));
    const auto reader = open_bytes(*ended.storage.files.at("out.8vo"));
    EXPECT_EQ(reader->thumbnail_bytes() > 0, settings == kThumbnailSetting);
  }
}

TEST(Repair, TheGrowingFileAndTheJournalNameItToo) {
  Ended ended(four_layers(VoxelType::uint8), 2);
  for (const std::string& name : {ended.growing, ended.growing + kJournalEnding}) {
    const auto result = ended.seal(name);
    ASSERT_TRUE(result.has_value()) << name;
    EXPECT_EQ(result->input, ended.growing);
  }
  EXPECT_FALSE(ended.seal("b.8vo").has_value());
}

TEST(Repair, OnlyNamesOfGrowingFilesCountAsSuch) {
  for (const char* name : {".a.8vo.tmp-1", "there/.a.8vo.tmp-1.journal", ".a.tmp-8vo.tmp-3-2"}) {
    EXPECT_TRUE(is_growing_name(name)) << name;
  }
  for (const char* name : {"a.8vo", "a.8vo.journal", "a.8vo.tmp-1", ".a.8vo", ".tmp-1", ""}) {
    EXPECT_FALSE(is_growing_name(name)) << name;
  }
}

// The reason why `input` in `storage` is not sealed.
std::string error_of(Storage& storage, const std::string& input, ErrorKind kind,
                     bool overwrite = true) {
  NoProgress progress;
  try {
    seal_interrupted(storage, input, "out.8vo", {.overwrite = overwrite, .threads = 1}, progress);
    ADD_FAILURE() << "it was sealed";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  }
  return {};
}

TEST(Repair, WhatHasNothingWholeIsNotTakenForABuildThatRuns) {
  const Ended ended(four_layers(VoxelType::uint8), 1);
  const std::string journal = ended.growing + kJournalEnding;
  MemoryStorage torn;
  torn.files = copied(ended.storage.files);
  torn.files.at(journal)->at(4) ^= 8;
  MemoryStorage alone;
  alone.files = copied(ended.storage.files);
  alone.files.erase(ended.growing);
  for (const std::string& input : {std::string("a.8vo"), ended.growing, journal}) {
    const std::string damaged = error_of(torn, input, ErrorKind::corrupt);
    EXPECT_NE(damaged.find("the start of its journal is damaged"), std::string::npos) << damaged;
    const std::string gone = error_of(alone, input, ErrorKind::io);
    EXPECT_NE(gone.find("is gone"), std::string::npos) << gone;
  }
}

TEST(Repair, ABuildThatRunsIsLeftAlone) {
  const Ended ended(four_layers(VoxelType::uint8), 1);
  std::string folder = "/tmp/octavo-repair-XXXXXX";
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  for (const auto& [name, bytes] : ended.storage.files) {
    local_storage().create_exclusive(folder + "/" + name)->write(0, *bytes);
  }
  {
    const auto held = local_storage().open_update(folder + "/" + ended.growing + kJournalEnding);
    for (const std::string& input : {std::string("a.8vo"), ended.growing}) {
      const std::string message = error_of(local_storage(), folder + "/" + input, ErrorKind::io);
      EXPECT_NE(message.find("still runs"), std::string::npos) << message;
    }
  }
  std::filesystem::remove_all(folder);
}

TEST(Repair, TheBuildOfWhichMostIsProvenIsTaken) {
  const Ended more(four_layers(VoxelType::uint8), 3);
  const Ended less(four_layers(VoxelType::uint8), 1);
  MemoryStorage storage;
  storage.files = copied(more.storage.files);
  storage.files.at(more.growing)->at(kHeaderBytes + 3) ^= 1;
  const auto files = copied(less.storage.files);
  storage.files[".a.8vo.tmp-5"] = files.at(less.growing);
  storage.files[".a.8vo.tmp-5.journal"] = files.at(less.growing + kJournalEnding);
  const auto result = Ended::seal_in(storage, "a.8vo");
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->input, ".a.8vo.tmp-5");
  EXPECT_EQ(result->whole_planes, 64);
}

TEST(Repair, AnInterruptedBuildOfTheOutputIsNotLostUnasked) {
  const Ended ended(four_layers(VoxelType::uint8), 2);
  MemoryStorage storage;
  storage.files = copied(ended.storage.files);
  const auto others = copied(ended.storage.files);
  storage.files[".out.8vo.tmp-5"] = others.at(ended.growing);
  storage.files[".out.8vo.tmp-5.journal"] = others.at(ended.growing + kJournalEnding);
  const std::string message = error_of(storage, "a.8vo", ErrorKind::io, false);
  EXPECT_NE(message.find("out.8vo: an interrupted build of it is here (planes 0 to 127 of 230)"),
            std::string::npos)
      << message;
  EXPECT_EQ(storage.files.size(), 4u);
  EXPECT_TRUE(Ended::seal_in(storage, "a.8vo").has_value());
  EXPECT_EQ(storage.files.count(".out.8vo.tmp-5"), 0u);
}

TEST(Repair, WithoutAWholePlaneItIsRejected) {
  Ended ended(four_layers(VoxelType::uint8), 1);
  ended.storage.files.at(ended.growing)->resize(600);
  try {
    ended.seal();
    FAIL() << "nothing was sealed";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
  }
  EXPECT_EQ(ended.storage.files.size(), 2u);
}

TEST(Repair, DamageCostsLayersAndNeverGivesAWrongVoxel) {
  const Ended ended(four_layers(VoxelType::uint8), 3);
  for (const auto& [name, bytes] : ended.storage.files) {
    for (std::size_t at = 0; at < bytes->size(); at += bytes->size() / 12) {
      MemoryStorage storage;
      storage.files = copied(ended.storage.files);
      storage.files.at(name)->at(at) ^= 8;
      try {
        const auto result = Ended::seal_in(storage, "a.8vo");
        ASSERT_TRUE(result.has_value());
        const auto reader = open_bytes(*storage.files.at("out.8vo"));
        const Box there = planes(ended.volume, 0, result->whole_planes);
        EXPECT_EQ(read_samples(*reader, there, 0), expected_samples(ended.volume, there, 0));
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
        EXPECT_EQ(storage.files.count("out.8vo"), 0u);
      }
    }
  }
}

TEST(Repair, EveryFailingCallLeavesTheOldFileAndWhatIsLeft) {
  const Ended ended(four_layers(VoxelType::uint8), 2);
  for (std::size_t k = 1;; ++k) {
    MemoryStorage storage;
    storage.files = copied(ended.storage.files);
    storage.files["out.8vo"] =
        std::make_shared<std::vector<std::uint8_t>>(std::vector<std::uint8_t>{'o', 'l', 'd'});
    storage.fail_at = k;
    std::string failure;
    try {
      Ended::seal_in(storage, "a.8vo");
    } catch (const Error& error) {
      failure = error.what();
    }
    EXPECT_EQ(storage.files.size(), 3u) << failure;
    if (!storage.has_failed) {
      EXPECT_GT(k, 10u);
      EXPECT_EQ(failure, "");
      break;
    }
    ASSERT_NE(failure, "") << "call " << k << " failed unnoticed";
    if (storage.calls.back() == "sync_folder") continue;
    EXPECT_EQ(storage.files.at("out.8vo")->size(), 3u) << failure;
  }
}

}  // namespace
}  // namespace octavo
