// A file system in memory whose calls can be made to fail, one by one.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "octavo/file/storage.h"

namespace octavo::testing {

using FileBytes = std::shared_ptr<std::vector<std::uint8_t>>;

/// Counts every call that can fail on a disk; call number `fail_at` (from 1) throws Error{io}. A
/// failing write leaves half of its bytes.
class MemoryStorage final : public Storage {
 public:
  std::map<std::string, FileBytes> files;
  std::vector<std::string> calls;   ///< what was called, in order
  std::size_t fail_at = 0;
  bool has_failed = false;

  std::unique_ptr<StorageFile> open_read(const std::string& path) override;
  std::unique_ptr<StorageFile> create_exclusive(const std::string& path) override;
  std::unique_ptr<StorageFile> create_scratch(const std::string& folder) override;
  bool exists(const std::string& path) override;
  void rename(const std::string& from, const std::string& to) override;
  void remove(const std::string& path) override;
  void sync_folder(const std::string& folder) override;

  /// Records a call; throws when it is the one to fail.
  void call(const std::string& what, const std::string& path);
};

}  // namespace octavo::testing
