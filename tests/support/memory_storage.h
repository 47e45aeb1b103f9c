// A file system in memory whose calls can be made to fail, one by one.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "octavo/file/storage/storage.h"

namespace octavo::testing {

using FileBytes = std::shared_ptr<std::vector<std::uint8_t>>;

/// The same files with bytes of their own.
std::map<std::string, FileBytes> copied(const std::map<std::string, FileBytes>& files);

/// Counts every call that can fail on a disk; call number `fail_at` (from 1) throws Error{io}. A
/// failing write leaves half of its bytes. A dying storage throws from then on: what is left is
/// what a killed process leaves.
class MemoryStorage final : public Storage {
 public:
  std::map<std::string, FileBytes> files;
  std::vector<std::string> calls;   ///< what was called, in order
  std::size_t fail_at = 0;
  bool is_dying = false;            ///< nothing changes any more from call `fail_at` on
  bool has_failed = false;
  /// What else happens before each call; may throw.
  std::function<void(const std::string& what)> meanwhile;
  std::string locked;               ///< a file that somebody else has locked

  std::unique_ptr<StorageFile> open_read(const std::string& path) override;
  std::unique_ptr<StorageFile> create_exclusive(const std::string& path) override;
  std::unique_ptr<StorageFile> open_update(const std::string& path) override;
  std::unique_ptr<StorageFile> open_shared(const std::string& path) override;
  std::unique_ptr<StorageFile> create_scratch(const std::string& folder) override;
  bool exists(const std::string& path) override;
  bool is_locked(const std::string& path) override { return !locked.empty() && path == locked; }
  void rename(const std::string& from, const std::string& to) override;
  void remove(const std::string& path) override;
  /// Takes every process for gone.
  void remove_stale(const std::string& prefix) noexcept override;
  std::vector<std::string> list(const std::string& prefix) override;
  void sync_folder(const std::string& folder) override;

  /// Records a call; throws when it is the one to fail.
  void call(const std::string& what, const std::string& path);
};

}  // namespace octavo::testing
