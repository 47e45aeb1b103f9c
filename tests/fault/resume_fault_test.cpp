// Builds that end at any call and are continued: the same bytes, or the old file and what is left.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "octavo/core/crc32c.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/interrupted.h"
#include "support/recording_storage.h"
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

TEST_F(Resume, WhatIsOfSomethingElseIsRejectedByNameAndKept) {
  const auto files = left_behind(2, true);
  const auto reject = [&](const WriterOptions& options, const VolumeDescription& description,
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
  reject(resuming, other, 1, ErrorKind::invalid_argument,
         "spacing: 0.5 0.5 0.5 there, 0.5 0.5 0.75");
  other = volume_.description;
  other.metadata = Metadata::read(R"({"source":{"format":"best"}})");
  reject(resuming, other, 1, ErrorKind::invalid_argument, "best");
  reject(resuming, volume_.description, 2, ErrorKind::source_rejected, "the first planes");
  reject({.is_resuming = true, .settings = "preset: fast\n"}, volume_.description, 1,
         ErrorKind::invalid_argument, "preset");
}

TEST_F(Resume, ABuildThatDoesNotContinueRemovesWhatIsLeftOnlyWhenAsked) {
  MemoryStorage storage;
  storage.files = left_behind(2, true);
  const auto names = copied(storage.files);
  const Attempt unasked = build(storage, {});
  EXPECT_EQ(unasked.kind, ErrorKind::io);
  EXPECT_NE(unasked.failure.find("an interrupted build of it is here"), std::string::npos)
      << unasked.failure;
  EXPECT_EQ(storage.files.size(), names.size());
  EXPECT_EQ(build(storage, {.discards_interrupted = true}).failure, "");
  EXPECT_EQ(storage.files.size(), 1u);
  EXPECT_TRUE(*storage.files.at("a.8vo") == reference_);
}

TEST_F(Resume, TheJournalGoesAfterTheNewNameIsOnDisk) {
  RecordingStorage storage;
  const auto writer =
      FileWriter::create(storage, "a.8vo", volume_.description, volume_.levels, 1,
                         {.overwrite = true, .has_journal = true, .is_resuming = true});
  recording_.replay(*writer, 2, 0);
  writer->finish();
  ASSERT_GE(storage.changes.size(), 3u);
  const std::span last = std::span(storage.changes).last(3);
  EXPECT_EQ(last[0].new_name, "a.8vo");
  EXPECT_EQ(last[1].what, Change::What::sync_folder);
  EXPECT_EQ(last[2].what, Change::What::remove);
  EXPECT_TRUE(last[2].name.ends_with(kJournalEnding)) << last[2].name;
}

TEST(TemporaryNames, OfLongNamesAreTheirOwnAndFit) {
  const std::string common(230, 'n');
  const std::string a = temporary_prefix("there/" + common + "a.8vo");
  const std::string b = temporary_prefix("there/" + common + "b.8vo");
  EXPECT_NE(a, b);
  EXPECT_LE(base_name_of(a).size() + std::string("4194304-99.journal").size(), kMaxNameBytes);
  // What such a file was to become is known by its own name alone.
  const std::string cut = base_name_of(a).substr(1, base_name_of(a).rfind(".tmp-") - 1);
  EXPECT_EQ(temporary_prefix("there/" + cut), a);
}

class ResumeOnDisk : public Resume {
 protected:
  void SetUp() override {
    Resume::SetUp();
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::unique_ptr<FileWriter> create(bool is_resuming) const {
    return FileWriter::create(local_storage(), path_of("a.8vo"), volume_.description,
                              volume_.levels, 1,
                              {.overwrite = true,
                               .has_journal = true,
                               .is_resuming = is_resuming,
                               .discards_interrupted = !is_resuming});
  }

  std::string path_of(const std::string& name) const { return folder_ + "/" + name; }
  std::size_t file_count() const { return local_storage().list(folder_ + "/").size(); }

  std::string folder_ = "/tmp/octavo-resume-XXXXXX";
};

TEST_F(ResumeOnDisk, AFileWithALivingWriterIsNotTaken) {
  auto first = create(true);
  first.reset();
  EXPECT_EQ(file_count(), 0u);

  auto living = create(true);
  recording_.replay(*living, 2, 0, kLayers);
  EXPECT_EQ(living->kept_layers(), 4);
  EXPECT_EQ(file_count(), 2u);
  try {
    create(true);
    ADD_FAILURE() << "a second build began beside the one to be continued";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io);
    EXPECT_NE(std::string(error.what()).find("another program works on "), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(file_count(), 2u);
  auto neighbor = create(false);
  EXPECT_TRUE(neighbor->resumed().empty());
  EXPECT_EQ(file_count(), 4u);
  neighbor.reset();
  living.reset();
  EXPECT_EQ(file_count(), 2u);
  const auto heir = create(true);
  EXPECT_EQ(heir->resumed().size(), kLayers);
  recording_.replay(*heir, 2, kLayers);
  heir->finish();
  EXPECT_EQ(file_count(), 1u);
  EXPECT_EQ(local_storage().open_read(path_of("a.8vo"))->size(), reference_.size());
}

TEST_F(ResumeOnDisk, ANameThatAnotherProgramBuildsIsRejected) {
  EXPECT_NO_THROW(reject_running(local_storage(), path_of("a.8vo")));
  auto living = create(false);
  try {
    reject_running(local_storage(), path_of("a.8vo"));
    ADD_FAILURE() << "nobody was seen";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io);
    EXPECT_EQ(error.path(), path_of("a.8vo"));
    EXPECT_EQ(error.detail().find("is being built by another program (.a.8vo.tmp-"), 0u);
  }
  living.reset();
  EXPECT_NO_THROW(reject_running(local_storage(), path_of("a.8vo")));
}

TEST_F(ResumeOnDisk, TheGrowingFileIsOpenToNobodyNew) {
  const auto mode_of = [&](const std::string& path) {
    return std::filesystem::status(path).permissions();
  };
  const auto is_private = std::filesystem::perms::owner_read | std::filesystem::perms::owner_write;
  std::ofstream(path_of("a.8vo")) << "old";
  std::filesystem::permissions(path_of("a.8vo"), is_private);
  const auto writer = create(false);
  const auto growing = local_storage().list(path_of(".a.8vo.tmp-"));
  ASSERT_EQ(growing.size(), 2u);
  for (const std::string& path : growing) EXPECT_EQ(mode_of(path), is_private) << path;
  recording_.replay(*writer, 2, 0);
  writer->finish();
  EXPECT_EQ(mode_of(path_of("a.8vo")), is_private);
}

TEST_F(ResumeOnDisk, ATemporaryThatCannotBeOpenedStopsNoBuild) {
  std::filesystem::create_directory(path_of(".a.8vo.tmp-1"));
  std::ofstream(path_of(".a.8vo.tmp-1/inside")) << "something";
  std::filesystem::create_directory(path_of(".a.8vo.tmp-1.journal"));
  std::ofstream(path_of(".a.8vo.tmp-1.journal/inside")) << "something";
  std::filesystem::create_symlink("gone", path_of(".a.8vo.tmp-1-1"));
  std::filesystem::create_symlink("gone", path_of(".a.8vo.tmp-1-1.journal"));
  EXPECT_EQ(local_storage().open_update(path_of(".a.8vo.tmp-1-2.journal")), nullptr);
  const auto writer = create(false);
  recording_.replay(*writer, 2, 0);
  writer->finish();
  EXPECT_EQ(local_storage().open_read(path_of("a.8vo"))->size(), reference_.size());
  EXPECT_EQ(file_count(), 5u);
  EXPECT_THROW(create(true), Error);
}

}  // namespace
}  // namespace octavo
