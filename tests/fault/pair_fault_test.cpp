// A header and its data that replace an earlier pair: a header never stands beside other data,
// whatever call fails, whenever the program is killed or the power is cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>

#include "octavo/core/error.h"
#include "octavo/io/pending_file.h"
#include "support/memory_storage.h"
#include "support/recording_storage.h"

namespace octavo {
namespace {

using namespace octavo::testing;
using Content = std::vector<std::uint8_t>;

Content bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

// Writes "a.mhd" and "a.raw", which both hold `text`.
void write_pair(Storage& storage, const std::string& text, bool overwrite) {
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
  fail_every_call(true, [](const MemoryStorage&, const Error&) {});
}

TEST(PairFaults, TheOldHeaderComesBackWhereItsDataStay) {
  fail_every_call(false, [](const MemoryStorage& storage, const Error& failure) {
    const bool has_new_data = content_of(storage, "a.raw") == bytes_of("new");
    EXPECT_EQ(content_of(storage, "a.mhd").has_value() || has_new_data, true) << failure.what();
    EXPECT_EQ(has_new_data, failure.detail().find("; ") != std::string::npos) << failure.what();
    const auto is_other = [](const auto& entry) {
      return entry.first != "a.mhd" && entry.first != "a.raw";
    };
    EXPECT_EQ(std::ranges::count_if(storage.files, is_other), 0) << failure.what();
  });
}

TEST(PairFaults, APowerCutLeavesNoHeaderBesideOtherData) {
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
        // The same cut for both names.
        std::mt19937_64 again = random;
        const auto header =
            after_power_cut(storage.changes, count, "a.mhd", nullptr, way, random);
        const auto data = after_power_cut(storage.changes, count, "a.raw", nullptr, way, again);
        ASSERT_NE(data, nullptr);
        EXPECT_TRUE(!header || *header == *data) << "change " << count;
        if (count == storage.changes.size()) {
          ASSERT_NE(header, nullptr);
          EXPECT_EQ(*header, bytes_of("new"));
        }
      }
    }
  }
}

}  // namespace
}  // namespace octavo
