// Disks that are almost full, and files of impossible lengths.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "support/memory_storage.h"

namespace octavo::testing {

/// A file that says it is longer than any memory.
class LongFile : public StorageFile {
 public:
  const std::string& path() const override { return path_; }
  std::uint64_t size() const override { return std::uint64_t{1} << 60; }
  void read(std::uint64_t, std::span<std::uint8_t> out) const override {
    std::ranges::fill(out, std::uint8_t{'['});
  }
  void write(std::uint64_t, std::span<const std::uint8_t>) override {}
  void truncate(std::uint64_t) override {}
  void sync() override {}
  void close() override {}

 private:
  std::string path_ = "long";
};

/// A file that is open while it lives.
class HeldFile final : public LongFile {
 public:
  HeldFile(std::multiset<std::string>& held, std::string path)
      : held_(held), own_(held.insert(std::move(path))) {}
  ~HeldFile() override { held_.erase(own_); }

 private:
  std::multiset<std::string>& held_;
  std::multiset<std::string>::iterator own_;
};

/// A disk that has little room, or a file that is too long.
class FullDisk final : public Storage {
 public:
  FullDisk(MemoryStorage& files, std::uint64_t free_bytes) : files_(files), free_(free_bytes) {}

  std::unique_ptr<StorageFile> open_read(const std::string& p) override {
    if (p == long_file) return std::make_unique<LongFile>();
    return files_.open_read(p);
  }
  std::unique_ptr<StorageFile> create_exclusive(const std::string& p) override {
    return files_.create_exclusive(p);
  }
  std::unique_ptr<StorageFile> open_update(const std::string& p) override {
    return files_.open_update(p);
  }
  std::unique_ptr<StorageFile> open_shared(const std::string& p) override {
    EXPECT_FALSE(held_.empty());
    for (const std::string& part : held_) EXPECT_TRUE(files_.files.contains(part)) << part;
    return files_.open_shared(p);
  }
  std::unique_ptr<StorageFile> create_scratch(const std::string& p) override {
    return files_.create_scratch(p);
  }
  bool exists(const std::string& p) override { return files_.exists(p); }
  void rename(const std::string& a, const std::string& b) override { files_.rename(a, b); }
  void remove(const std::string& p) override { files_.remove(p); }
  std::vector<std::string> list(const std::string& p) override { return files_.list(p); }
  void sync_folder(const std::string& p) override { files_.sync_folder(p); }
  std::optional<std::uint64_t> stored_bytes(const std::string&) override { return stored; }
  std::optional<DiskSpace> disk_space(const std::string& folder) override {
    return DiskSpace{free_, folder == "elsewhere" ? 2U : 1U};
  }

  /// Nobody copies while a part is open that is removed: its blocks are not free.
  std::unique_ptr<StorageFile> lock_left(const std::string& p) override {
    return std::make_unique<HeldFile>(held_, p);
  }

  std::optional<std::uint64_t> stored;  ///< of every file
  std::string long_file;                ///< its name

 private:
  MemoryStorage& files_;
  std::uint64_t free_;
  std::multiset<std::string> held_;
};

}  // namespace octavo::testing
