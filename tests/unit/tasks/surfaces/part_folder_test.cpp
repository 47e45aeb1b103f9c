#include "octavo/tasks/surfaces/part_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "octavo/core/error.h"
#include "support/built_labels.h"
#include "support/dying_storage.h"

namespace octavo {
namespace {

using testing::DyingStorage;
using testing::ScratchFolder;
using Files = std::map<std::string, std::string>;

/// The files of a folder, hidden ones too, and what is in them.
Files files_in(const std::string& folder) {
  Files files;
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    files[name] = entry.is_directory() ? "folder" : testing::bytes_of_file(entry.path().string());
  }
  return files;
}

std::size_t hidden_count(const std::string& folder) {
  const Files files = files_in(folder);
  return static_cast<std::size_t>(std::count_if(
      files.begin(), files.end(), [](const auto& file) { return file.first.starts_with('.'); }));
}

/// Writes three files that hold `text`.
void write_three(Storage& storage, const std::string& path, const std::string& text,
                 bool overwrite) {
  PartFolder folder(storage, path, overwrite);
  for (const char* const name : {"a.stl", "b.stl", "c.stl"}) {
    const std::uint64_t size = folder.add(name, [&](PendingFile& file) {
      file.append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    });
    EXPECT_EQ(size, text.size());
  }
  folder.publish();
}

Files three(const std::string& text) {
  return {{"a.stl", text}, {"b.stl", text}, {"c.stl", text}};
}

TEST(PartFolder, GetsAllFilesWhetherItIsNewOrNot) {
  ScratchFolder scratch;
  const std::string path = scratch.file("parts");
  write_three(local_storage(), path + "/", "old", false);
  EXPECT_EQ(files_in(path), three("old"));
  EXPECT_THROW(write_three(local_storage(), path, "new", false), Error);
  EXPECT_EQ(files_in(path), three("old"));
  write_three(local_storage(), path, "new", true);
  EXPECT_EQ(files_in(path), three("new"));
  EXPECT_EQ(hidden_count(scratch.file("")), 0u);
}

/// Lets call after call fail, alone or with all that come behind; `check` sees what it leaves.
template <class Check>
void for_each_failure(bool is_there, bool is_death, bool has_exchange, Check check) {
  std::size_t failures = 0;
  for (std::size_t call = 1;; ++call) {
    ScratchFolder scratch;
    const std::string path = scratch.file("parts");
    DyingStorage quick(local_storage(), 0);  // as it does not sync
    if (is_there) write_three(quick, path, "old", false);
    DyingStorage storage(local_storage(), call);
    if (!is_death) storage.fail_once();
    if (!has_exchange) storage.lose_exchange();
    try {
      write_three(storage, path, "new", true);
      break;
    } catch (const Error& error) {
      ++failures;
      EXPECT_TRUE(error.path().starts_with(path)) << error.what();
      EXPECT_EQ(error.path().find(".tmp-"), std::string::npos) << error.what();
    }
    check(scratch, path, call);
  }
  EXPECT_GE(failures, 15u);
}

TEST(PartFolder, AFailureLeavesNothingNew) {
  for (const bool has_exchange : {true, false}) {
    for_each_failure(false, false, has_exchange,
                     [](ScratchFolder& scratch, const std::string& path, std::size_t call) {
                       const Files files = files_in(path);
                       EXPECT_TRUE(files.empty() || files == three("new")) << call;
                       EXPECT_EQ(hidden_count(scratch.file("")), 0u) << call;
                     });
  }
}

TEST(PartFolder, AFailureLeavesTheEarlierFiles) {
  for (const bool has_exchange : {true, false}) {
    for_each_failure(true, false, has_exchange,
                     [](ScratchFolder&, const std::string& path, std::size_t call) {
                       EXPECT_EQ(files_in(path), three("old")) << call;
                     });
  }
}

TEST(PartFolder, ADeathLeavesWholeFilesAndTheNextRunTheRest) {
  for (const bool has_exchange : {true, false}) {
    for (const bool is_there : {false, true}) {
      for_each_failure(is_there, true, has_exchange,
                       [&](ScratchFolder& scratch, const std::string& path, std::size_t call) {
        for (const auto& [name, text] : files_in(path)) {
          EXPECT_TRUE(name.starts_with('.') || text == "old" || text == "new") << call;
        }
        EXPECT_TRUE(is_there || files_in(path).empty() || files_in(path) == three("new")) << call;
        DyingStorage quick(local_storage(), 0);
        write_three(quick, path, "next", true);
        EXPECT_EQ(files_in(path), three("next")) << call;
        EXPECT_EQ(hidden_count(scratch.file("")), 0u) << call;
      });
    }
  }
}

TEST(PartFolder, WhatOthersLeftInAHiddenFolderStays) {
  ScratchFolder scratch;
  const std::string hidden = scratch.file(".parts.tmp-1");
  std::filesystem::create_directory(hidden);
  std::ofstream(hidden + "/a.stl") << "left";
  std::ofstream(hidden + "/letter.txt") << "mine";
  write_three(local_storage(), scratch.file("parts"), "new", false);
  EXPECT_EQ(files_in(hidden), (Files{{"letter.txt", "mine"}}));
}

TEST(PartFolder, VolumesOfAnyNameThatWereLeftGo) {
  ScratchFolder scratch;
  const testing::BuiltLabels volume({4, 4, 4}, testing::random_labels({4, 4, 4}, 1, 3));
  const std::string hidden = scratch.file(".parts.tmp-1");
  std::filesystem::create_directory(hidden);
  std::filesystem::copy_file(volume.path(), hidden + "/scan");
  write_three(local_storage(), scratch.file("parts"), "new", false);
  EXPECT_FALSE(std::filesystem::exists(hidden));
}

TEST(PartFolder, SaysAtOnceWhatCannotBeAFolder) {
  ScratchFolder scratch;
  std::ofstream(scratch.file("file")) << "text";
  EXPECT_THROW(PartFolder(local_storage(), scratch.file("file"), true), Error);
  EXPECT_THROW(PartFolder(local_storage(), scratch.file("file/parts"), true), Error);
  EXPECT_THROW(PartFolder(local_storage(), scratch.file("missing/parts"), true), Error);
}

}  // namespace
}  // namespace octavo
