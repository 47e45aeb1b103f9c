// A file that takes its name only when it is complete.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "octavo/file/storage/storage.h"

namespace octavo {

/// Grows under a temporary name beside its own; a destroyed one that was not published leaves
/// nothing. What killed processes left behind for the same name goes first. One thread at a time.
/// Every call throws Error{io} that names `path`.
class PendingFile {
 public:
  PendingFile(Storage& storage, std::string path);
  /// Open to nobody to whom what stands at `target` is not, whose place it takes later on.
  PendingFile(Storage& storage, std::string path, const std::string& target);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  const std::string& path() const { return path_; }
  /// Where it stands until it has its name.
  const std::string& temporary_path() const { return temporary_path_; }
  /// Bytes appended; of a sealed file, its size.
  std::uint64_t size() const { return size_; }
  /// For writing at any place. Requires a file that is not sealed.
  StorageFile& file() { return *file_; }

  /// Appends at the end.
  void append(std::span<const std::uint8_t> bytes);
  /// Makes the bytes durable and closes; nothing can be written afterwards.
  void seal();
  /// Gives a sealed file its name, durably. A name that was taken meanwhile is replaced only with
  /// `overwrite`.
  void publish(bool overwrite);
  /// The same, not yet durable.
  void take_name(bool overwrite);

 private:
  void discard() noexcept;
  template <class F>
  void named(F f) const;

  Storage& storage_;
  std::string path_;
  std::string temporary_path_;
  std::unique_ptr<StorageFile> file_;
  std::uint64_t size_ = 0;
  bool is_published_ = false;
};

/// Ends what a program left that was stopped while it replaced a header and its data: the earlier
/// ones come back unless the new ones stand there. To be called before anything is written for
/// these names.
/// Throws Error{io} that names one of the two
void settle_pair(Storage& storage, const std::string& header, const std::string& data);

/// Gives a header and the data that it describes their names, both sealed. An earlier pair makes
/// way first, so that a header stands at no moment beside other data, and comes back when anything
/// fails, at the latest by settle_pair. One program at a time, where the folder can be locked.
/// Throws Error{io} that names one of the two
void publish_pair(Storage& storage, PendingFile& header, PendingFile& data, bool overwrite);

}  // namespace octavo
