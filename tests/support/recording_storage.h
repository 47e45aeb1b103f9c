// A file system in memory that remembers every change, and what a power cut can make of them.
//
// What was written is on the disk once its file was synced; a name once its folder was. Before that
// each 4 KiB page of what was written may be there or not, and so may the changes of names, in
// their order.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "octavo/file/storage/storage.h"

namespace octavo::testing {

/// One change. Long writes stand as several.
struct Change {
  enum class What { create, write, sync, rename, remove, sync_folder };
  What what = What::create;
  std::size_t file = 0;             ///< create, write, sync: which
  std::string name;                 ///< create, rename, remove: the old name
  std::string new_name;             ///< rename
  std::uint64_t offset = 0;         ///< write
  std::vector<std::uint8_t> bytes;  ///< write
};

class RecordingStorage final : public Storage {
 public:
  /// The log of all changes, scratch files left out.
  std::vector<Change> changes;

  /// Puts a file in place that is on the disk.
  void add_file(const std::string& name, std::vector<std::uint8_t> bytes);

  std::unique_ptr<StorageFile> open_read(const std::string& path) override;
  std::unique_ptr<StorageFile> create_exclusive(const std::string& path) override;
  std::unique_ptr<StorageFile> open_update(const std::string& path) override;
  std::unique_ptr<StorageFile> create_scratch(const std::string& folder) override;
  bool exists(const std::string& path) override;
  void rename(const std::string& from, const std::string& to) override;
  void remove(const std::string& path) override;
  std::vector<std::string> list(const std::string& prefix) override;
  void sync_folder(const std::string& folder) override;

  using Content = std::vector<std::uint8_t>;
  const std::map<std::string, std::size_t>& names() const { return names_; }
  const Content& content(std::size_t file) const { return *contents_[file]; }

 private:
  std::map<std::string, std::size_t> names_;
  std::vector<std::shared_ptr<Content>> contents_;
};

/// How much of what was not synced outlasts the cut.
enum class Outlasting {
  everything,
  nothing,
  some_pages,         ///< random ones, all names
  names_before_data,  ///< all names, no data
  data_before_names,  ///< all data, no names
  some_of_all         ///< random pages, and names up to a random one
};

/// The file `name` after a power cut behind the first `count` of `changes`, on a disk that held
/// `old_bytes` under it, or nothing; nullptr where there is none.
std::unique_ptr<std::vector<std::uint8_t>> after_power_cut(
    const std::vector<Change>& changes, std::size_t count, const std::string& name,
    const std::vector<std::uint8_t>* old_bytes, Outlasting outlasting, std::mt19937_64& random);

}  // namespace octavo::testing
