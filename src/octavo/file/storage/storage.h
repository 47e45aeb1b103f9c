// The seam to the file system: everything that touches a disk while a file is written or read goes
// through it, so that tests can make any call fail.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octavo/file/storage/byte_source.h"

namespace octavo {

/// An open file. Every call throws Error{io} with the path, what was tried and the system's reason.
class StorageFile {
 public:
  virtual ~StorageFile() = default;
  virtual const std::string& path() const = 0;
  virtual std::uint64_t size() const = 0;
  /// Reads exactly out.size() bytes; Error{truncated} when the file ends before.
  virtual void read(std::uint64_t offset, std::span<std::uint8_t> out) const = 0;
  /// Writes all of `bytes`; short writes and EINTR are continued.
  virtual void write(std::uint64_t offset, std::span<const std::uint8_t> bytes) = 0;
  /// Cuts off what stands from `size` on; a shorter file stays as it is.
  virtual void truncate(std::uint64_t size) = 0;
  /// Makes what was written durable. A failure is final: it is never tried again.
  virtual void sync() = 0;
  /// Closes and reports what closing found; the destructor closes without a word, and lets go of
  /// the lock.
  virtual void close() = 0;
};

/// Of the disk that a folder lies on.
struct DiskSpace {
  std::uint64_t free_bytes = 0;
  std::uint64_t disk = 0;  ///< equal for folders on one disk
};

/// What a path names, links followed.
enum class PathType { missing, file, folder, other };

class Storage {
 public:
  virtual ~Storage() = default;
  virtual std::unique_ptr<StorageFile> open_read(const std::string& path) = 0;
  /// A new file for reading and writing, locked while it is open; Error{io} when the name is taken.
  virtual std::unique_ptr<StorageFile> create_exclusive(const std::string& path) = 0;
  /// The same for a file that takes the place of `target`, or holds some of it: where a file stands
  /// there, the new one is never open to more people. It gets the permissions, and the owner and
  /// group as far as the system lets. Unless overridden, create_exclusive.
  virtual std::unique_ptr<StorageFile> create_replacement(const std::string& path,
                                                          const std::string& target);
  /// An existing file for reading and writing, locked while it is open; null when somebody else has
  /// the lock, when the file system has none, and when there is no file that may be written.
  virtual std::unique_ptr<StorageFile> open_update(const std::string& path) = 0;
  /// The same of a file that another process has locked with whom this one works on it, and that
  /// stays locked by that one alone; Error{io} when there is none, and unless overridden.
  virtual std::unique_ptr<StorageFile> open_shared(const std::string& path);
  /// Whether files beside `path`, or it itself, can be locked: some network file systems have no
  /// locks. Unless overridden, true.
  virtual bool has_locks(const std::string& path);
  /// Locks what stands at `path`, a file or a folder, while what is returned lives; null where
  /// somebody has the lock, where the file system has none, and unless overridden.
  virtual std::unique_ptr<StorageFile> lock_left(const std::string& path);
  /// Whether somebody has a file locked; false where that is not known, and unless overridden.
  virtual bool is_locked(const std::string& path);
  /// The system's reason why nothing can be created in a folder, found by trying, without a trace;
  /// empty where files can, and unless overridden.
  virtual std::string why_closed(const std::string& folder);
  /// A nameless scratch file in `folder` that vanishes when closed.
  virtual std::unique_ptr<StorageFile> create_scratch(const std::string& folder) = 0;
  virtual bool exists(const std::string& path) = 0;
  /// Unless overridden, everything that exists counts as a file.
  virtual PathType path_type(const std::string& path);
  /// Puts `from` in the place of `to`, whether that exists or not, in one step.
  virtual void rename(const std::string& from, const std::string& to) = 0;
  /// The same only when `to` does not exist, else Error{io}; unless overridden, not in one step.
  virtual void rename_new(const std::string& from, const std::string& to);
  /// Lets two names change places in one step; false where the file system cannot, which is so
  /// unless overridden.
  virtual bool exchange(const std::string& a, const std::string& b);
  virtual void remove(const std::string& path) = 0;
  /// A new folder that takes the place of `target`, with the permissions of a folder that stands
  /// there, locked while what is returned lives; Error{io} when the name is taken and unless
  /// overridden.
  virtual std::unique_ptr<StorageFile> create_folder(const std::string& path,
                                                     const std::string& target);
  /// Removes the files that temporary_type knows by what follows `prefix`, and such folders of
  /// planes, where nobody has them locked; unless overridden, nothing. Never fails: what cannot be
  /// locked or removed stays.
  virtual void remove_stale(const std::string& prefix) noexcept;
  /// The files whose path starts with `prefix`, in the order of their names.
  virtual std::vector<std::string> list(const std::string& prefix) = 0;
  virtual void sync_folder(const std::string& folder) = 0;
  /// Nothing where it is not known, and unless overridden.
  virtual std::optional<DiskSpace> disk_space(const std::string& folder);
  /// What a file takes on its disk, which is less than its size where nothing was written; nothing
  /// where that is not known, and unless overridden.
  virtual std::optional<std::uint64_t> stored_bytes(const std::string& path);
  /// Locks a folder while what is returned lives, for who changes several names in it; waits for
  /// others, then Error{io}. Null where the file system has no locks, and unless overridden.
  virtual std::unique_ptr<StorageFile> lock_folder(const std::string& folder);
};

/// The folder a path lies in: "." for a bare name.
std::string folder_of(const std::string& path);

/// The part of a path after its last slash.
std::string base_name_of(const std::string& path);

/// The real file system (pread, pwrite, fsync, rename).
Storage& local_storage();

/// A ByteSource over a file of `storage`.
std::shared_ptr<ByteSource> open_byte_source(Storage& storage, const std::string& path);

}  // namespace octavo
