// Builds that end at any call and are continued: the same bytes, or the old file and what is left.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "octavo/codec/crc32c.h"
#include "octavo/file/interrupted.h"
#include "octavo/file/temporary.h"
#include "support/recording_writer.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

struct Attempt {
  std::size_t resumed = 0;
  std::string failure;  ///< empty when the file was finished
  ErrorKind kind = ErrorKind::internal;
};

// A build of four groups of two bricks, each with a model of its own.
class Resume : public ::testing::Test {
 protected:
  static constexpr std::size_t kLayers = 4;

  void SetUp() override {
    volume_.model_layers = 1;
    encode_sample(recording_, volume_);
    MemoryStorage storage;
    ASSERT_EQ(build(storage, {}).failure, "");
    reference_ = *storage.files.at("a.8vo");
  }

  Attempt build(MemoryStorage& storage, WriterOptions options) const {
    return build(storage, std::move(options), volume_.description);
  }

  Attempt build(MemoryStorage& storage, WriterOptions options, const VolumeDescription& description,
                std::uint32_t content_hash = 1) const {
    Attempt attempt;
    options.overwrite = true;
    options.has_journal = options.has_journal || options.is_resuming;
    try {
      const auto writer = FileWriter::create(storage, "a.8vo", description, volume_.levels,
                                             content_hash, options);
      attempt.resumed = writer->resumed().size();
      for (std::size_t i = 0; i < attempt.resumed; ++i) {
        EXPECT_EQ(writer->resumed()[i].voxels_crc, i + 1);
        EXPECT_EQ(writer->resumed()[i].parents.size(), 2u);
      }
      recording_.replay(*writer, 2, attempt.resumed);
      writer->finish();
    } catch (const Error& error) {
      attempt.failure = error.what();
      attempt.kind = error.kind();
    }
    return attempt;
  }

  Attempt resume(MemoryStorage& storage) const { return build(storage, {.is_resuming = true}); }

  // Continues what is left in `storage` and compares the file.
  std::size_t finish(MemoryStorage& storage) const {
    storage.fail_at = 0;
    const Attempt attempt = resume(storage);
    EXPECT_EQ(attempt.failure, "");
    EXPECT_TRUE(*storage.files.at("a.8vo") == reference_);
    EXPECT_EQ(storage.files.size(), 1u);
    return attempt.resumed;
  }

  // What a build leaves that is killed behind `groups` groups.
  std::map<std::string, FileBytes> left_behind(std::size_t groups, bool is_resuming) const {
    for (std::size_t k = 1;; ++k) {
      MemoryStorage storage;
      storage.fail_at = k;
      storage.is_dying = true;
      build(storage, {.has_journal = true, .is_resuming = is_resuming});
      MemoryStorage copy;
      copy.files = copied(storage.files);
      if (finish(copy) == groups) return storage.files;
      if (!storage.has_failed) break;
    }
    ADD_FAILURE() << "no call leaves " << groups << " groups";
    return {};
  }

  static std::string journal_of(const std::map<std::string, FileBytes>& files) {
    for (const auto& [name, bytes] : files) {
      if (name.ends_with(kJournalEnding)) return name;
    }
    ADD_FAILURE() << "no journal";
    return {};
  }

  SampleVolume volume_ = make_sample({70, 20, 230}, VoxelType::int16, Pattern::noisy_half);
  RecordingWriter recording_;
  std::vector<std::uint8_t> reference_;
};

TEST_F(Resume, ABuildWithAJournalGivesTheSameBytesAndLeavesNothing) {
  for (const bool is_resuming : {false, true}) {
    MemoryStorage storage;
    EXPECT_EQ(build(storage, {.has_journal = true, .is_resuming = is_resuming}).failure, "");
    EXPECT_TRUE(*storage.files.at("a.8vo") == reference_);
    EXPECT_EQ(storage.files.size(), 1u);
    EXPECT_EQ(std::count(storage.calls.begin(), storage.calls.end(), "create_scratch"), 0);
  }
}

// Ends a build at every call, continues it, and compares. Returns how many groups were spared.
std::size_t end_at_every_call(const std::function<void(MemoryStorage&)>& begin,
                              const std::function<Attempt(MemoryStorage&)>& build,
                              const std::function<std::size_t(MemoryStorage&)>& finish,
                              bool is_dying) {
  std::size_t spared = 0;
  for (std::size_t k = 1;; ++k) {
    MemoryStorage storage;
    begin(storage);
    storage.calls.clear();
    storage.fail_at = k;
    storage.is_dying = is_dying;
    const Attempt attempt = build(storage);
    if (!storage.has_failed) {
      EXPECT_EQ(attempt.failure, "");
      EXPECT_GT(k, 20u);
      return spared;
    }
    EXPECT_NE(attempt.failure, "") << "call " << k << " failed unnoticed";
    EXPECT_EQ(attempt.kind, ErrorKind::io) << attempt.failure;
    EXPECT_LE(storage.files.size(), 3u) << attempt.failure;
    if (*storage.files.at("a.8vo") != std::vector<std::uint8_t>{'o', 'l', 'd'}) {
      // Only the folder was not yet on disk, or the journal not yet removed.
      EXPECT_NE(attempt.failure.find("complete"), std::string::npos) << attempt.failure;
    }
    storage.is_dying = false;
    spared += finish(storage);
  }
}

void put_old_file(MemoryStorage& storage) {
  storage.files["a.8vo"] =
      std::make_shared<std::vector<std::uint8_t>>(std::vector<std::uint8_t>{'o', 'l', 'd'});
}

TEST_F(Resume, ABuildThatFailsAtAnyCallIsContinued) {
  for (const bool is_dying : {false, true}) {
    const std::size_t spared = end_at_every_call(
        put_old_file, [&](MemoryStorage& storage) { return resume(storage); },
        [&](MemoryStorage& storage) { return finish(storage); }, is_dying);
    EXPECT_GT(spared, kLayers) << is_dying;
  }
}

TEST_F(Resume, AKilledBuildThatDidNotAskForItIsContinuedToo) {
  const std::size_t spared = end_at_every_call(
      put_old_file, [&](MemoryStorage& storage) { return build(storage, {.has_journal = true}); },
      [&](MemoryStorage& storage) { return finish(storage); }, true);
  EXPECT_GT(spared, kLayers);
}

TEST_F(Resume, AContinuedBuildThatFailsAtAnyCallIsContinuedAgain) {
  for (const std::size_t groups : {1u, 3u, 4u}) {
    const auto files = left_behind(groups, true);
    const auto begin = [&](MemoryStorage& storage) {
      storage.files = copied(files);
      put_old_file(storage);
    };
    for (const bool is_dying : {false, true}) {
      end_at_every_call(
          begin, [&](MemoryStorage& storage) { return resume(storage); },
          [&](MemoryStorage& storage) {
            const bool is_done = *storage.files.at("a.8vo") == reference_;
            const std::size_t spared = finish(storage);
            EXPECT_TRUE(is_done || spared >= groups) << spared;
            return spared;
          },
          is_dying);
    }
  }
}

TEST_F(Resume, AFailedBuildThatMayNotBeContinuedLeavesNothing) {
  for (std::size_t k = 1;; ++k) {
    MemoryStorage storage;
    storage.fail_at = k;
    const Attempt attempt = build(storage, {.has_journal = true});
    if (!storage.has_failed) break;
    EXPECT_NE(attempt.failure, "");
    const bool was_named = storage.calls.back() == "sync_folder";
    EXPECT_EQ(storage.files.size(), was_named ? 1u : 0u) << attempt.failure;
  }
}

TEST_F(Resume, EveryDamageCostsGroupsAndNothingElse) {
  const auto files = left_behind(3, true);
  for (const auto& [name, bytes] : files) {
    const bool is_journal = name == journal_of(files);
    for (std::size_t at = 0; at < bytes->size(); at += is_journal ? 37 : 1009) {
      MemoryStorage flipped;
      flipped.files = copied(files);
      flipped.files.at(name)->at(at) ^= 16;
      const std::size_t kept = finish(flipped);
      EXPECT_LE(kept, at < kHeaderBytes && !is_journal ? 3u : 2u) << name << " " << at;
      MemoryStorage cut;
      cut.files = copied(files);
      cut.files.at(name)->resize(at);
      EXPECT_LE(finish(cut), 2u) << name << " " << at;
    }
  }
}

TEST_F(Resume, WhatIsOfSomethingElseIsRefusedByNameAndKept) {
  const auto files = left_behind(2, true);
  const auto refuse = [&](const WriterOptions& options, const VolumeDescription& description,
                          std::uint32_t hash, ErrorKind kind, const std::string& words) {
    MemoryStorage storage;
    storage.files = copied(files);
    const Attempt attempt = build(storage, options, description, hash);
    EXPECT_EQ(attempt.kind, kind);
    EXPECT_NE(attempt.failure.find(words), std::string::npos) << attempt.failure;
    EXPECT_EQ(storage.files.size(), files.size());
    EXPECT_EQ(finish(storage), 2u);
  };
  const WriterOptions resuming{.is_resuming = true};
  VolumeDescription other = volume_.description;
  other.geometry.spacing_mm[2] = 0.75;
  refuse(resuming, other, 1, ErrorKind::invalid_argument,
         "spacing: 0.5 0.5 0.5 there, 0.5 0.5 0.75");
  other = volume_.description;
  other.metadata_json = R"({"source":{"format":"best"}})";
  refuse(resuming, other, 1, ErrorKind::invalid_argument, "best");
  refuse(resuming, volume_.description, 2, ErrorKind::source_rejected, "the first planes");
  refuse({.is_resuming = true, .settings = "preset: fast\n"}, volume_.description, 1,
         ErrorKind::invalid_argument, "preset");
}

TEST_F(Resume, ABuildThatDoesNotContinueRemovesWhatIsLeft) {
  MemoryStorage storage;
  storage.files = left_behind(2, true);
  EXPECT_EQ(build(storage, {}).failure, "");
  EXPECT_EQ(storage.files.size(), 1u);
  EXPECT_TRUE(*storage.files.at("a.8vo") == reference_);
}

TEST_F(Resume, AFileWithALivingWriterIsNotTaken) {
  std::string folder = "/tmp/octavo-resume-XXXXXX";
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  const std::string path = folder + "/a.8vo";
  const auto create = [&] {
    return FileWriter::create(local_storage(), path, volume_.description, volume_.levels, 1,
                              {.overwrite = true, .has_journal = true, .is_resuming = true});
  };
  auto first = create();
  first.reset();
  EXPECT_TRUE(local_storage().list(folder + "/").empty());

  auto living = create();
  const auto neighbour = create();
  EXPECT_TRUE(neighbour->resumed().empty());
  EXPECT_EQ(local_storage().list(folder + "/").size(), 4u);
  recording_.replay(*living, 2, 0, kLayers);
  EXPECT_EQ(living->kept_layers(), 4);
  living.reset();
  EXPECT_EQ(local_storage().list(folder + "/").size(), 4u);
  const auto heir = create();
  EXPECT_EQ(heir->resumed().size(), kLayers);
  recording_.replay(*heir, 2, kLayers);
  heir->finish();
  EXPECT_EQ(local_storage().list(folder + "/").size(), 3u);
  EXPECT_EQ(local_storage().open_read(path)->size(), reference_.size());
  for (const std::string& name : local_storage().list(folder + "/")) local_storage().remove(name);
  ::rmdir(folder.c_str());
}

}  // namespace
}  // namespace octavo
