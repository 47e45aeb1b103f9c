// Journals whose records are whole but whose groups could not have been written.
#include <gtest/gtest.h>

#include <functional>

#include "octavo/core/error.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/interrupted.h"
#include "support/recording_writer.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

// A build that ended behind three of its four layers of two bricks, each of which is a group.
class HostileJournal : public ::testing::Test {
 protected:
  static constexpr std::size_t kGroups = 3;

  void SetUp() override {
    RecordingWriter recording;
    encode_sample(recording, volume_);
    const auto writer =
        FileWriter::create(storage_, "a.8vo", volume_.description, volume_.levels, 1,
                           {.overwrite = true, .has_journal = true, .is_resuming = true});
    recording.replay(*writer, 2, 0, kGroups);
    for (const auto& [name, bytes] : storage_.files) {
      if (!name.ends_with(kJournalEnding)) growing_ = name;
    }
  }

  /// The journal once more, its head and its groups (by number, with their blocks) changed.
  void rewrite(const std::function<void(JournalHead&)>& change_head,
               const std::function<void(std::size_t, WholeGroup&)>& change) {
    const auto old = storage_.open_read(growing_ + kJournalEnding);
    std::vector<WholeGroup> groups = read_journal_groups(*old);
    ASSERT_EQ(groups.size(), kGroups);
    JournalHead head = read_journal_head(*old).value();
    if (change_head) change_head(head);
    storage_.files.erase(growing_ + kJournalEnding);
    Journal journal(storage_.create_exclusive(growing_ + kJournalEnding), head);
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if (change) change(i, groups[i]);
      for (const JournalBlock& block : groups[i].blocks) {
        Bytes bytes(std::min<std::uint64_t>(block.length, old->size() - block.offset));
        old->read(block.offset, bytes);
        bytes.resize(block.length);
        journal.append_block(block.stream, bytes);
      }
      journal.append_group(groups[i].group);
    }
  }

  std::size_t proven() {
    const auto file = storage_.open_read(growing_);
    const auto journal = storage_.open_read(growing_ + kJournalEnding);
    return proven_groups(*file, *journal, volume_.levels).size();
  }

  SampleVolume volume_ = make_sample({70, 20, 230}, VoxelType::int16, Pattern::noisy_half);
  MemoryStorage storage_;
  std::string growing_;
};

TEST_F(HostileJournal, WhatCannotFollowTheGroupBeforeEndsWhatIsProven) {
  using Change = std::function<void(WholeGroup&)>;
  const struct {
    const char* what;
    std::size_t group;
    Change change;
  } cases[] = {
      {"no layer", 1, [](WholeGroup& g) { g.group.end_layer = 1; }},
      {"a layer before", 1, [](WholeGroup& g) { g.group.end_layer = 0; }},
      {"a layer too many", 1, [](WholeGroup& g) { g.group.end_layer = 3; }},
      {"layers beyond the volume", 2, [](WholeGroup& g) { g.group.end_layer = 5; }},
      {"bytes before", 1, [](WholeGroup& g) { g.group.file_bytes = kHeaderBytes; }},
      {"bytes beyond the file", 1, [](WholeGroup& g) { g.group.file_bytes = 1ull << 40; }},
      {"another digest", 1, [](WholeGroup& g) { g.group.digest ^= 1; }},
      {"a slab trailer less", 1, [](WholeGroup& g) { g.group.slab_trailer_bytes.clear(); }},
      {"a page less", 1, [](WholeGroup& g) { g.group.pages.clear(); }},
      {"a page more", 1, [](WholeGroup& g) { g.group.pages.push_back(g.group.pages[0]); }},
      {"a parent less", 1, [](WholeGroup& g) { g.group.parents.pop_back(); }},
      {"a model of a slab before", 1, [](WholeGroup& g) { g.group.models[0].first_slab = 0; }},
      {"a model of a slab behind", 1, [](WholeGroup& g) { g.group.models[0].first_slab = 2; }},
      {"a huge model", 1,
       [](WholeGroup& g) {
         g.group.models[0].length = static_cast<std::uint32_t>(kMaxModelBytes + 1);
       }},
      {"no first model", 0, [](WholeGroup& g) { g.group.models.clear(); }},
      {"a stream that is not there", 1, [](WholeGroup& g) { g.blocks[0].stream = 99; }},
      {"a huge block", 1, [](WholeGroup& g) { g.blocks[0].length = (1u << 20) + 1; }},
  };
  ASSERT_EQ(proven(), kGroups);
  const auto files = copied(storage_.files);
  for (const auto& c : cases) {
    storage_.files = copied(files);
    rewrite({}, [&](std::size_t number, WholeGroup& group) {
      if (number == c.group) c.change(group);
    });
    EXPECT_EQ(proven(), c.group) << c.what;
  }
  storage_.files = copied(files);
  rewrite({}, {});
  EXPECT_EQ(proven(), kGroups);
}

TEST_F(HostileJournal, OnlyWhatHoldsAWholePlaneIsNotGivenUpUnasked) {
  const auto message = [&]() -> std::string {
    try {
      reject_interrupted(storage_, "a.8vo");
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::io);
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message().find("(planes 0 to 191 of 230)"), std::string::npos) << message();
  const auto files = copied(storage_.files);
  rewrite({}, [](std::size_t, WholeGroup& group) { group.group.digest ^= 1; });
  EXPECT_EQ(message(), "");

  // A head whose header is none.
  storage_.files = copied(files);
  rewrite([](JournalHead& head) { head.header.fill(7); }, {});
  const auto found = find_interrupted(storage_, "a.8vo");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(proven_groups(found.front()).empty());
  EXPECT_EQ(message(), "");
}

TEST_F(HostileJournal, ABuildIsAGrowingFileAndAJournalWithAWholeHead) {
  const auto files = copied(storage_.files);
  const auto found = [&] { return find_interrupted(storage_, "a.8vo").size(); };
  EXPECT_EQ(found(), 1u);
  EXPECT_EQ(find_interrupted(storage_, "b.8vo").size(), 0u);
  for (const std::size_t length : {std::size_t{0}, std::size_t{10}, std::size_t{500}}) {
    storage_.files = copied(files);
    storage_.files.at(growing_ + kJournalEnding)->resize(length);
    EXPECT_EQ(found(), 0u) << length;
  }
  storage_.files = copied(files);
  storage_.files.erase(growing_);
  EXPECT_EQ(found(), 0u);
  storage_.files = copied(files);
  storage_.files.erase(growing_ + kJournalEnding);
  EXPECT_EQ(found(), 0u);

  storage_.files = copied(files);
  discard_interrupted(storage_, "a.8vo");
  EXPECT_TRUE(storage_.files.empty());
  // A disk that fails stops no one from giving up what is left.
  storage_.files = copied(files);
  storage_.calls.clear();
  storage_.fail_at = 1;
  discard_interrupted(storage_, "a.8vo");
  EXPECT_EQ(storage_.files.size(), 2u);
}

}  // namespace
}  // namespace octavo
