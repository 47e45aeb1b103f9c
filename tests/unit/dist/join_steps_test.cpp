// A join in steps makes the file of a join in one, and of a build; whoever is stopped goes on.
#include "octavo/dist/join_steps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/file/storage/temporary.h"
#include "support/failure_text.h"
#include "support/full_disk.h"
#include "support/laid_out_file.h"
#include "support/small_parts.h"
#include "support/stopping_progress.h"

namespace octavo::testing {
namespace {

/// What every test begins with. Requires the groups of JoinSteps.
struct Made {
  Made() {
    volume.options.has_thumbnail = true;
    plan = planned(volume);
    whole = built(volume);
    for (const GroupRun& run : runs) make_part(volume, plan, run, storage);
  }

  SmallVolume volume = small_volume("steps", VoxelType::int16, {70, 66, 330});
  std::vector<GroupRun> runs = {{4, 6}, {0, 1}, {1, 4}};
  BuildPlan plan;
  std::vector<std::uint8_t> whole;
  MemoryStorage storage;  ///< of the parts
};

const Made& made_once() {
  static const Made made;
  return made;
}

class JoinSteps : public ::testing::Test {
 protected:
  JoinSteps() { storage_.files = copied(made_.storage.files); }

  JoinLayout lay_out(const std::vector<GroupRun>& runs) {
    return lay_out_join(plan_, open_parts(storage_, runs), storage_, "a.8vo", false,
                        {.threads = 1}, progress_);
  }
  void copy(const GroupRun& run, bool consumes = false) {
    copy_part(plan_, PartFile::open(storage_, part_name(run)), storage_, "a.8vo", consumes,
              progress_);
  }
  std::uint64_t seal(bool overwrite = false) { return seal(overwrite, plan_); }
  std::uint64_t seal(bool overwrite, const BuildPlan& plan, const std::string& path = "a.8vo") {
    return seal_join(plan, storage_, path, overwrite, {.threads = 1}, progress_);
  }
  std::uint64_t consume() {
    std::vector<std::string> names;
    for (const GroupRun& run : runs_) names.push_back(part_name(run));
    return consume_parts(plan_, names, storage_, "a.8vo", false, {.threads = 1}, progress_);
  }
  /// Parts, file and the mark of steps that were done apart, nothing else is there.
  void expect_done(std::size_t part_count, std::size_t marks = 1) {
    ASSERT_EQ(storage_.files.count("a.8vo"), 1U);
    EXPECT_TRUE(*storage_.files.at("a.8vo") == whole_);
    EXPECT_EQ(storage_.files.size(), part_count + 1 + marks);
  }

  SmallGroups groups_{std::uint64_t{1} << 18};
  const Made& made_ = made_once();
  const SmallVolume& volume_ = made_.volume;
  const std::vector<GroupRun>& runs_ = made_.runs;
  const BuildPlan& plan_ = made_.plan;
  const std::vector<std::uint8_t>& whole_ = made_.whole;
  MemoryStorage storage_;
  NoProgress progress_;
};

TEST_F(JoinSteps, InAnyOrderAndTwiceTheyMakeTheFile) {
  ASSERT_EQ(plan_.group_count, 6);
  const JoinLayout layout = lay_out(runs_);
  EXPECT_EQ(layout.file_bytes, whole_.size());
  EXPECT_EQ(parts_of(layout).size(), 3U);
  copy({1, 4});
  EXPECT_EQ(layout_text(lay_out({})), layout_text(layout)) << "it needs no part any more";
  copy({4, 6});
  EXPECT_EQ(uncopied_parts(layout, storage_, "a.8vo").front().end_group, 1);
  const std::string early = failure_of([&] { seal(); }, ErrorKind::io);
  EXPECT_NE(early.find("group 0"), std::string::npos) << early;
  EXPECT_EQ(storage_.files.count("a.8vo"), 0U);
  copy({0, 1});
  copy({4, 6});
  EXPECT_EQ(seal(), whole_.size());
  EXPECT_EQ(seal(), whole_.size()) << "again";
  expect_done(3);
}

TEST_F(JoinSteps, TheFileIsItsOwnBytesAndThoseOfItsRuns) {
  const JoinLayout layout = lay_out(runs_);
  const LaidOutFile made =
      laid_out_file(layout, storage_, "a.8vo", [](const PartPlace& place) {
        return part_name({place.first_group, place.end_group});
      });
  EXPECT_EQ(made.bytes, layout.file_bytes);
  EXPECT_TRUE(made.file == whole_);
}

TEST_F(JoinSteps, ACopyLooksAtItsOwnPartAlone) {
  std::vector<GroupRun> runs;
  for (std::int64_t group = 0; group < plan_.group_count; ++group) {
    runs.emplace_back(group, group + 1);
    make_part(volume_, plan_, runs.back(), storage_);
  }
  const JoinLayout layout = lay_out(runs);
  const PartCopier copier(plan_, layout, storage_, "a.8vo");
  std::vector<std::string> first;
  for (const GroupRun& run : runs) {
    const std::shared_ptr<PartFile> part = PartFile::open(storage_, part_name(run));
    EXPECT_FALSE(copier.is_copied(part->place()));
    storage_.calls.clear();
    copier.copy(part, false, progress_);
    if (first.empty()) first = storage_.calls;
    else EXPECT_EQ(storage_.calls, first) << run.first;
  }
  storage_.calls.clear();
  EXPECT_TRUE(uncopied_parts(layout, storage_, "a.8vo").empty());
  EXPECT_TRUE(storage_.calls.empty()) << "no mark is read";
  seal();
  expect_done(runs.size() + runs_.size() - 1);
}

TEST_F(JoinSteps, ALayoutThatWasChangedIsNone) {
  const std::string text = layout_text(lay_out(runs_));
  EXPECT_EQ(layout_text(parse_layout(text)), text);
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::string changed = text;
    changed[at] = changed[at] == '7' ? '8' : '7';
    EXPECT_THROW(parse_layout(changed), Error) << at;
    EXPECT_THROW(parse_layout(text.substr(0, at)), Error) << at;
  }
}

TEST_F(JoinSteps, ALayoutThatIsLongerThanThatOfAnyPlanIsNotRead) {
  lay_out(runs_);
  FullDisk disk(storage_, 0);
  EXPECT_TRUE(find_layout(plan_, disk, "a.8vo"));
  copy({0, 1});
  disk.long_file = joined_name("a.8vo") + "-layout";
  EXPECT_FALSE(find_layout(plan_, disk, "a.8vo"));
  discard_steps(plan_, disk, "a.8vo");
  EXPECT_TRUE(storage_.files.contains(joined_name("a.8vo"))) << "the part may be gone";
}

// The hidden file may be all that is left of parts that were removed once they were copied.
TEST_F(JoinSteps, WhatALayoutThatCannotBeReadBelongsToStays) {
  const std::string text = layout_text(lay_out(runs_));
  copy({0, 1});
  auto& layout = *storage_.files.at(joined_name("a.8vo") + "-layout");
  std::string older = text;
  const std::size_t version = older.find('4', older.find("octavo_join"));
  ASSERT_LT(version, older.size());
  older[version] = '1';
  std::string damaged = text;
  damaged.back() = ' ';
  for (const std::string& other : {older, damaged, std::string("{"), std::string()}) {
    layout.assign(other.begin(), other.end());
    EXPECT_FALSE(find_layout(plan_, storage_, "a.8vo"));
    discard_steps(plan_, storage_, "a.8vo");
    const std::string why = failure_of([&] { lay_out(runs_); }, ErrorKind::io);
    EXPECT_NE(why.find("layout cannot be read"), std::string::npos) << why;
    EXPECT_NE(why.find("remove .a.8vo.join*"), std::string::npos) << why;
    failure_of([&] { consume(); }, ErrorKind::io);
    ASSERT_TRUE(storage_.files.contains(joined_name("a.8vo")));
    EXPECT_EQ(open_parts(storage_, runs_).size(), 3U);
  }
  layout.assign(text.begin(), text.end());
  storage_.files.erase(part_name({0, 1}));
  copy({1, 4});
  copy({4, 6});
  EXPECT_EQ(seal(), whole_.size());
  expect_done(2);
}

TEST_F(JoinSteps, AGrowingFileThatWasCutOffIsNotLaidOutAnew) {
  lay_out(runs_);
  copy({0, 1}, true);
  auto& growing = *storage_.files.at(joined_name("a.8vo"));
  const std::vector<std::uint8_t> whole = growing;
  growing.resize(growing.size() - 1);
  const FileBytes part = storage_.files.at(part_name({1, 4}));
  storage_.files[part_name({0, 1})] = part;
  const std::string why = failure_of([&] { lay_out(runs_); }, ErrorKind::io);
  EXPECT_NE(why.find("has " + std::to_string(whole.size() - 1) + " bytes, " +
                     std::to_string(whole.size()) + " expected"),
            std::string::npos)
      << why;
  EXPECT_NE(why.find("remove .a.8vo.join*"), std::string::npos) << why;
  discard_steps(plan_, storage_, "a.8vo");
  ASSERT_EQ(storage_.files.at(joined_name("a.8vo"))->size(), whole.size() - 1);
  *storage_.files.at(joined_name("a.8vo")) = whole;
  storage_.files.erase(part_name({0, 1}));
  copy({1, 4});
  copy({4, 6});
  EXPECT_EQ(seal(), whole_.size());
  expect_done(2);
}

TEST_F(JoinSteps, OfTwoJoinsToOneNameTheOneThatConsumesTakesThePlaceOfItsTwin) {
  storage_.meanwhile = [&](const std::string& what) {
    if (what != "rename" || storage_.files.contains("a.8vo")) return;
    if (!storage_.files.contains(part_name({0, 1}))) {
      storage_.files["a.8vo"] = std::make_shared<std::vector<std::uint8_t>>(whole_);
    }
  };
  EXPECT_EQ(consume(), whole_.size());
  storage_.meanwhile = {};
  expect_done(0);
}

TEST_F(JoinSteps, PartsThatAnotherJoinConsumesAreLeftToIt) {
  storage_.locked = part_name({0, 1});
  const std::string why = failure_of([&] { consume(); }, ErrorKind::io);
  EXPECT_NE(why.find("another join that consumes parts works on this one"), std::string::npos)
      << why;
  EXPECT_EQ(storage_.files.size(), 3U) << "the parts, and nothing that grows";
  storage_.locked.clear();
  EXPECT_EQ(consume(), whole_.size());
}

TEST_F(JoinSteps, OnlyTheFileThatWasSealedIsTakenForThatOfItsPlan) {
  lay_out(runs_);
  for (const GroupRun& run : runs_) copy(run);
  seal();
  EXPECT_TRUE(is_joined(plan_, storage_, "a.8vo"));

  BuildPlan other = plan_;  // of the same first group, and of no file that would be newer
  other.recipe = R"({"other":1})";
  other.id = id_of(other);
  EXPECT_FALSE(is_joined(other, storage_, "a.8vo"));
  failure_of([&] { seal(true, other); }, ErrorKind::io);

  // A file of the same first group that takes the name later
  SmallVolume changed = volume_;
  changed.voxels.back() ^= std::byte{1};
  auto& file = storage_.files.at("a.8vo");
  const auto sealed = std::exchange(
      file, std::make_shared<std::vector<std::uint8_t>>(built(changed)));
  ASSERT_FALSE(*file == *sealed);
  EXPECT_FALSE(is_joined(plan_, storage_, "a.8vo"));
  failure_of([&] { seal(true); }, ErrorKind::io);
  file = sealed;
  EXPECT_EQ(seal(), whole_.size());
  expect_done(3);
}

TEST_F(JoinSteps, APartThatWasNotLaidOutIsRejectedByName) {
  lay_out(runs_);
  make_part(volume_, plan_, {1, 2}, storage_);
  const std::string text = failure_of([&] { copy({1, 2}); }, ErrorKind::invalid_argument);
  EXPECT_NE(text.find("part-1-2"), std::string::npos) << text;
}

TEST_F(JoinSteps, WithoutALayoutNothingIsCopiedOrSealed) {
  failure_of([&] { copy({0, 1}); }, ErrorKind::io);
  failure_of([&] { seal(); }, ErrorKind::io);
}

TEST_F(JoinSteps, ADamagedPartIsNotCopied) {
  lay_out(runs_);
  (*storage_.files.at("part-1-4"))[5000] ^= 1;
  const std::string text = failure_of([&] { copy({1, 4}); }, ErrorKind::corrupt);
  EXPECT_NE(text.find("part-1-4"), std::string::npos) << text;
  (*storage_.files.at("part-1-4"))[5000] ^= 1;
  for (const GroupRun& run : runs_) copy(run);
  seal();
  expect_done(3);
}

TEST_F(JoinSteps, WhatAnotherPlanHasBegunIsNotTakenAway) {
  lay_out(runs_);
  copy({0, 1});
  SmallVolume other = volume_;
  other.options.access = Access::boxes;
  const BuildPlan plan = planned(other);
  MemoryStorage parts;
  make_part(other, plan, {0, 6}, parts);
  storage_.files["other"] = parts.files.at("part-0-6");
  const std::string text = failure_of(
      [&] {
        lay_out_join(plan, {PartFile::open(storage_, "other")}, storage_, "a.8vo", false, {},
                     progress_);
      },
      ErrorKind::io);
  EXPECT_NE(text.find("another plan"), std::string::npos) << text;
  copy({4, 6});
  copy({1, 4});
  seal();
  EXPECT_TRUE(*storage_.files.at("a.8vo") == whole_);
}

// Also where folders have no locks, as here.
TEST_F(JoinSteps, WhoSealsWhileAnotherDoesFindsTheFileSealed) {
  const auto before = copied(storage_.files);
  for (const std::string call : {"create", "rename"}) {
    for (const bool overwrite : {false, true}) {
      storage_.files = copied(before);
      lay_out(runs_);
      for (const GroupRun& run : runs_) copy(run);
      bool is_over = false;
      storage_.meanwhile = [&](const std::string& what) {
        if (what != call || std::exchange(is_over, true)) return;
        EXPECT_EQ(seal(overwrite), whole_.size());
      };
      EXPECT_EQ(seal(overwrite), whole_.size()) << call;
      storage_.meanwhile = {};
      EXPECT_TRUE(is_over) << call;
      EXPECT_TRUE(is_joined(plan_, storage_, "a.8vo")) << call;
      expect_done(3);
    }
  }
}

TEST_F(JoinSteps, SealingAgainKeepsWhatAnotherPlanHasBegun) {
  lay_out(runs_);
  for (const GroupRun& run : runs_) copy(run);
  seal();
  SmallVolume other = volume_;
  other.options.access = Access::boxes;
  const BuildPlan plan = planned(other);
  MemoryStorage parts;
  make_part(other, plan, {0, 6}, parts);
  storage_.files["other"] = parts.files.at("part-0-6");
  const std::shared_ptr<PartFile> part = PartFile::open(storage_, "other");
  lay_out_join(plan, {part}, storage_, "a.8vo", true, {}, progress_);
  copy_part(plan, part, storage_, "a.8vo", false, progress_);
  storage_.files.erase("other");
  EXPECT_EQ(seal(true), whole_.size());
  seal(true, plan);
  EXPECT_TRUE(*storage_.files.at("a.8vo") == built(other));
}

TEST_F(JoinSteps, APartIsKeptThatWasCopiedToAFileThatIsGone) {
  for (const std::string call : {"open_shared", "write"}) {
    lay_out(runs_);
    bool is_over = false;
    storage_.meanwhile = [&](const std::string& what) {
      if (what != call || std::exchange(is_over, true)) return;
      discard_steps(plan_, storage_, "a.8vo");
      lay_out(runs_);
    };
    failure_of([&] { copy({0, 1}, true); }, ErrorKind::io);
    EXPECT_TRUE(is_over) << call;
    EXPECT_EQ(uncopied_parts(*find_layout(plan_, storage_, "a.8vo"), storage_, "a.8vo").size(), 3U);
    for (const GroupRun& run : runs_) copy(run);
    seal();
    expect_done(3);
    storage_.remove("a.8vo");
  }
}

TEST_F(JoinSteps, WhoLaysOutLaterTakesWhatTheOtherHasLaidOut) {
  // Another job lays out and copies after this one found no layout.
  bool is_over = false;
  storage_.meanwhile = [&](const std::string& what) {
    if (what != "create" || std::exchange(is_over, true)) return;
    lay_out(runs_);
    copy({0, 1});
    storage_.files.erase(part_name({0, 1}));
  };
  const JoinLayout layout = lay_out(runs_);
  EXPECT_TRUE(is_over);
  EXPECT_EQ(uncopied_parts(layout, storage_, "a.8vo").size(), 2U);
  copy({1, 4});
  copy({4, 6});
  seal();
  expect_done(2);
}

TEST_F(JoinSteps, AFileThatStandsThereIsReplacedOnlyWhenAsked) {
  storage_.files["a.8vo"] = std::make_shared<std::vector<std::uint8_t>>(3);
  failure_of([&] { lay_out(runs_); }, ErrorKind::io);
  lay_out_join(plan_, open_parts(storage_, runs_), storage_, "a.8vo", true, {}, progress_);
  for (const GroupRun& run : runs_) copy(run);
  failure_of([&] { seal(); }, ErrorKind::io);
  EXPECT_EQ(storage_.files.at("a.8vo")->size(), 3U);
  seal(true);
  expect_done(3);
}

// The longest stands there only while the file takes its name.
TEST_F(JoinSteps, WhatStandsBesideALongNameHasNoLongerNameThanFilesMay) {
  const auto before = copied(storage_.files);
  for (const std::size_t bytes : {150U, 200U, 215U, 223U, 255U}) {
    storage_.files = copied(before);
    const std::string path = "folder/" + std::string(bytes - 4, 'n') + ".8vo";
    const auto expect_names = [&](const std::string&) {
      for (const auto& [name, file] : storage_.files) {
        ASSERT_LE(base_name_of(name).size(), kMaxNameBytes) << name;
      }
    };
    storage_.meanwhile = expect_names;
    lay_out_join(plan_, open_parts(storage_, runs_), storage_, path, false, {.threads = 1},
                 progress_);
    for (const GroupRun& run : runs_) {
      copy_part(plan_, PartFile::open(storage_, part_name(run)), storage_, path, false,
                progress_);
    }
    EXPECT_EQ(seal(false, plan_, path), whole_.size());
    EXPECT_TRUE(is_joined(plan_, storage_, path));
    storage_.meanwhile = {};
    expect_names("");
  }
}

TEST_F(JoinSteps, ConsumedPartsAreGoneAndTheFileIsThere) {
  EXPECT_EQ(consume(), whole_.size());
  expect_done(0);
}

TEST_F(JoinSteps, NothingIsConsumedBeforeAllIsProvenAndThereIsRoom) {
  (*storage_.files.at("part-1-4"))[5000] ^= 1;
  failure_of([&] { consume(); }, ErrorKind::corrupt);
  (*storage_.files.at("part-1-4"))[5000] ^= 1;
  std::vector<std::string> names;
  std::uint64_t largest = 0;
  std::uint64_t all = 0;
  for (const GroupRun& run : runs_) {
    names.push_back(part_name(run));
    const std::uint64_t bytes = PartFile::open(storage_, names.back())->stream_bytes();
    largest = std::max(largest, bytes);
    all += bytes;
  }
  FullDisk full(storage_, largest - 1);
  const auto consume_on = [&](Storage& storage) {
    return consume_parts(plan_, names, storage, "a.8vo", false, {.threads = 1}, progress_);
  };
  const std::string text = failure_of([&] { consume_on(full); }, ErrorKind::io);
  EXPECT_NE(text.find("no room"), std::string::npos) << text;
  EXPECT_EQ(open_parts(storage_, runs_).size(), 3U);
  storage_.files.erase(joined_name("a.8vo"));
  for (std::string& name : names) {
    storage_.files["elsewhere/" + name] = storage_.files.at(name);
    storage_.files.erase(name);
    name = "elsewhere/" + name;
  }
  FullDisk apart(storage_, all - 1);
  failure_of([&] { consume_on(apart); }, ErrorKind::io);
  storage_.files.erase(joined_name("a.8vo"));
  FullDisk enough(storage_, all);
  EXPECT_EQ(consume_on(enough), whole_.size());
  expect_done(0);
}

// What a copy that was cut off has written needs no more room; all else does.
TEST_F(JoinSteps, AJoinInOneWritesNothingWhereTheDiskHasNoRoomForIt) {
  std::uint64_t bytes = 0;
  for (const auto& part : open_parts(storage_, runs_)) bytes += part->joined_bytes();
  for (const std::uint64_t free : {bytes - 1, bytes}) {
    FullDisk disk(storage_, free);
    const auto join = [&] {
      join_parts(plan_, open_parts(disk, runs_), disk, "a.8vo", false, {.threads = 1}, progress_);
    };
    if (free == bytes) {
      join();
      expect_done(3, 0);
    } else {
      const std::string why = failure_of(join, ErrorKind::io);
      EXPECT_NE(why.find("a.8vo: no room: "), std::string::npos) << why;
      EXPECT_EQ(storage_.files.size(), 3U);
    }
  }
}

TEST_F(JoinSteps, AConsumingJoinThatGoesOnLooksForRoomAsWell) {
  const JoinLayout layout = lay_out(runs_);
  std::uint64_t own = 0;
  for (const Section& section : own_bytes_of(layout)) own += section.length;
  std::vector<std::string> names;
  std::uint64_t largest = 0;
  for (const GroupRun& run : runs_) {
    names.push_back(part_name(run));
    largest = std::max(largest, PartFile::open(storage_, names.back())->stream_bytes());
  }
  FullDisk disk(storage_, largest - 10);
  const auto consume_on_disk = [&] {
    return consume_parts(plan_, names, disk, "a.8vo", false, {.threads = 1}, progress_);
  };
  disk.stored = own + 9;
  const std::string text = failure_of(consume_on_disk, ErrorKind::io);
  EXPECT_NE(text.find("no room"), std::string::npos) << text;
  EXPECT_EQ(open_parts(storage_, runs_).size(), 3U);
  disk.stored = own + 10;
  EXPECT_EQ(consume_on_disk(), whole_.size());
  expect_done(0);
}

// Killed at any call, it goes on; what a process leaves is all that the next one has.
TEST_F(JoinSteps, AConsumingJoinThatIsKilledGoesOn) {
  const auto before = copied(storage_.files);
  storage_.calls.clear();
  consume();
  const std::size_t calls = storage_.calls.size();
  for (std::size_t call = 1; call <= calls; call += 1 + calls / 150) {
    for (const bool is_dying : {true, false}) {
      storage_.files = copied(before);
      storage_.calls.clear();
      storage_.has_failed = false;
      storage_.fail_at = call;
      storage_.is_dying = is_dying;
      try {
        consume();
      } catch (const Error&) {
      }
      storage_.fail_at = 0;
      storage_.is_dying = false;
      storage_.has_failed = false;
      const auto found = storage_.files.find("a.8vo");
      if (found != storage_.files.end()) {
        ASSERT_TRUE(*found->second == whole_) << call;
      }
      ASSERT_EQ(consume(), whole_.size()) << call;
      ASSERT_TRUE(*storage_.files.at("a.8vo") == whole_) << call;
    }
  }
}

// The file has its name, the parts are gone, and marks are left.
TEST_F(JoinSteps, AConsumingJoinThatIsKilledBehindTheRenameEndsWhenGivenAgain) {
  storage_.meanwhile = [&](const std::string&) {
    if (storage_.files.contains("a.8vo")) throw Error(ErrorKind::io, "killed");
  };
  failure_of([&] { consume(); }, ErrorKind::io);
  storage_.meanwhile = {};
  BuildPlan later = plan_;  // whose first group is the same
  later.recipe = R"({"other":1})";
  later.id = id_of(later);
  EXPECT_FALSE(is_sealed(later, storage_, "a.8vo"));
  failure_of([&] { seal(true, later); }, ErrorKind::io);
  EXPECT_TRUE(is_sealed(plan_, storage_, "a.8vo"));
  EXPECT_EQ(consume(), whole_.size());
  expect_done(0);
}

TEST_F(JoinSteps, AJoinThatIsStoppedLeavesThePartsAndNoFile) {
  StoppingProgress stopping(2);
  try {
    join_parts(plan_, open_parts(storage_, runs_), storage_, "a.8vo", false, {.threads = 1},
               stopping);
    ADD_FAILURE() << "nobody stopped it";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::cancelled) << error.what();
  }
  EXPECT_EQ(storage_.files.size(), 3U);
}

}  // namespace
}  // namespace octavo::testing
