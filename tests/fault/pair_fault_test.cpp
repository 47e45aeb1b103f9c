// A header and its data that replace an earlier pair: a header never stands beside other data,
// whatever call fails, whenever the program is killed or the power is cut; and one whole pair comes
// out of it.
#include <gtest/gtest.h>

#include <new>
#include <optional>
#include <string>

#include "octavo/core/error.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/file/storage/temporary.h"
#include "support/memory_storage.h"
#include "support/recording_storage.h"

namespace octavo {
namespace {

using namespace octavo::testing;
using Content = std::vector<std::uint8_t>;

Content bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

// Writes "a.mhd" and "a.raw", which both hold `text`.
void write_pair(Storage& storage, const std::string& text, bool overwrite) {
  settle_pair(storage, "a.mhd", "a.raw");
  PendingFile data(storage, "a.raw");
  PendingFile header(storage, "a.mhd");
  for (PendingFile* file : {&data, &header}) {
    file->append(bytes_of(text));
    file->seal();
  }
  publish_pair(storage, header, data, overwrite);
}

std::optional<Content> content_of(const MemoryStorage& storage, const std::string& name) {
  const auto found = storage.files.find(name);
  if (found == storage.files.end()) return std::nullopt;
  return *found->second;
}

// Lets call after call fail while a pair replaces another; `check` sees what each failure leaves.
template <class Check>
void fail_every_call(bool is_dying, Check check) {
  for (std::size_t k = 1;; ++k) {
    MemoryStorage storage;
    write_pair(storage, "old", false);
    storage.calls.clear();
    storage.fail_at = k;
    storage.is_dying = is_dying;
    std::optional<Error> failure;
    try {
      write_pair(storage, "new", true);
    } catch (const Error& error) {
      failure = error;
    }
    if (!storage.has_failed) {
      EXPECT_FALSE(failure);
      EXPECT_GT(k, 10u);
      return;
    }
    ASSERT_TRUE(failure) << "call " << k << " failed unnoticed";
    EXPECT_TRUE(failure->path() == "a.mhd" || failure->path() == "a.raw") << failure->what();
    const auto header = content_of(storage, "a.mhd");
    EXPECT_TRUE(!header || header == content_of(storage, "a.raw")) << failure->what();
    check(storage, *failure);
  }
}

TEST(PairFaults, AHeaderNeverStandsBesideOtherData) {
  fail_every_call(true, [](MemoryStorage& storage, const Error&) {
    storage.fail_at = 0;
    storage.is_dying = false;
    storage.has_failed = false;
    settle_pair(storage, "a.mhd", "a.raw");
    ASSERT_TRUE(content_of(storage, "a.mhd"));
    EXPECT_EQ(content_of(storage, "a.mhd"), content_of(storage, "a.raw"));
    for (const std::string path : {"a.mhd", "a.raw"}) {
      EXPECT_FALSE(storage.exists(earlier_name(path)));
    }
  });
}

TEST(PairFaults, AFailureAfterAKillLeavesTheEarlierPair) {
  for (std::size_t kill = 1;; ++kill) {
    MemoryStorage killed;
    write_pair(killed, "old", false);
    killed.calls.clear();
    killed.fail_at = kill;
    killed.is_dying = true;
    try {
      write_pair(killed, "new", true);
    } catch (const Error&) {
      // The kill.
    }
    if (!killed.has_failed) break;
    for (std::size_t k = 1;; ++k) {
      MemoryStorage storage;
      storage.files = copied(killed.files);
      storage.fail_at = k;
      try {
        write_pair(storage, "new", true);
      } catch (const Error&) {
        // The failure.
      }
      if (!storage.has_failed) break;
      storage.fail_at = 0;
      settle_pair(storage, "a.mhd", "a.raw");
      ASSERT_TRUE(content_of(storage, "a.mhd")) << kill << " " << k;
      EXPECT_EQ(content_of(storage, "a.mhd"), content_of(storage, "a.raw")) << kill << " " << k;
    }
  }
}

TEST(PairFaults, WhateverIsThrownTheEarlierPairComesBack) {
  for (int number = 1; number < 4; ++number) {
    MemoryStorage storage;
    write_pair(storage, "old", false);
    int renames = 0;
    storage.meanwhile = [&](const std::string& what) {
      if (what == "rename" && ++renames == number) throw std::bad_alloc();
    };
    EXPECT_THROW(write_pair(storage, "new", true), std::bad_alloc);
    EXPECT_EQ(content_of(storage, "a.mhd"), bytes_of("old"));
    EXPECT_EQ(content_of(storage, "a.raw"), bytes_of("old"));
    EXPECT_EQ(storage.files.size(), 2u);
  }
}

TEST(PairFaults, AWholePairStandsAfterAnyFailure) {
  fail_every_call(false, [](MemoryStorage& storage, const Error& failure) {
    EXPECT_TRUE(content_of(storage, "a.mhd")) << failure.what();
    const bool is_new = content_of(storage, "a.raw") == bytes_of("new");
    EXPECT_EQ(is_new, failure.detail().find("; what is new stands") != std::string::npos);
    settle_pair(storage, "a.mhd", "a.raw");
    EXPECT_EQ(storage.files.size(), 2u) << failure.what();
  });
}

// What settle_pair makes of the files after a cut that `content` looks up.
template <class Content>
void expect_whole_pair(Content content, std::size_t count) {
  auto header = content("a.mhd");
  auto data = content("a.raw");
  if (header) {
    ASSERT_TRUE(data) << "change " << count;
  } else {
    header = content(earlier_name("a.mhd"));
    if (auto earlier = content(earlier_name("a.raw"))) data = std::move(earlier);
    ASSERT_TRUE(header && data) << "change " << count;
    EXPECT_EQ(*header, bytes_of("old"));
  }
  EXPECT_EQ(*header, *data) << "change " << count;
}

TEST(PairFaults, APowerCutLeavesAWholePair) {
  RecordingStorage storage;
  write_pair(storage, "old", false);
  const std::size_t first = storage.changes.size();
  write_pair(storage, "new", true);
  std::mt19937_64 random(61);
  for (std::size_t count = first; count <= storage.changes.size(); ++count) {
    for (int round = 0; round < 20; ++round) {
      for (const Outlasting way :
           {Outlasting::everything, Outlasting::nothing, Outlasting::names_before_data,
            Outlasting::data_before_names, Outlasting::some_of_all}) {
        // The same cut for all names.
        const std::uint64_t seed = random();
        const auto content = [&](const std::string& name) {
          std::mt19937_64 same(seed);
          return after_power_cut(storage.changes, count, name, nullptr, way, same);
        };
        expect_whole_pair(content, count);
        if (count == storage.changes.size()) {
          const auto header = content("a.mhd");
          ASSERT_NE(header, nullptr);
          EXPECT_EQ(*header, bytes_of("new"));
        }
      }
    }
  }
}

}  // namespace
}  // namespace octavo
