// The real file system, by pread and pwrite: a file that shrinks while it is read is an error, not
// a signal.
#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/missing_path.h"
#include "octavo/file/storage/plane_folder.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxCallBytes = std::size_t{1} << 30;
constexpr int kMaxCreateTries = 10;
constexpr int kMaxLockTries = 6000;
constexpr unsigned kMicrosecondsToLock = 10'000;  // between two tries: a minute in all

std::string room_text(std::uint64_t bytes) {
  if (bytes < (1 << 17)) return std::to_string(bytes) + (bytes == 1 ? " byte" : " bytes");
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MiB", static_cast<double>(bytes) / (1 << 20));
  return text;
}

[[noreturn]] void fail(const std::string& what, const std::string& path, int code) {
  const std::string cause = std::generic_category().message(code);
  throw told_missing(Error(ErrorKind::io, what + ": " + cause, path), code);
}

// Calls `f` until no signal interrupts it.
template <class F>
auto uninterrupted(F f) {
  auto result = f();
  while (result < 0 && errno == EINTR) result = f();
  return result;
}

std::string no_space_detail(int descriptor, std::uint64_t needed) {
  std::string text = "no space left";
  if (needed > 0) text += ": " + room_text(needed) + " more needed";
  struct statvfs disk {};
  if (fstatvfs(descriptor, &disk) == 0) {
    text += ", " + room_text(std::uint64_t{disk.f_bavail} * disk.f_frsize) + " free";
  }
  return text;
}

// True when `path` names the open file or folder, and not another one that took its place.
bool is_named(int descriptor, const std::string& path) {
  struct stat opened {};
  if (fstat(descriptor, &opened) != 0) fail("cannot look up", path, errno);
  struct stat named {};
  if (::lstat(path.c_str(), &named) != 0) {
    if (errno == ENOENT) return false;
    fail("cannot look up", path, errno);
  }
  return named.st_dev == opened.st_dev && named.st_ino == opened.st_ino;
}

// Locks what was just created, which tells remove_stale on any machine that a writer lives; file
// systems without locks do without. Returns false when somebody who had the lock first, taking the
// new file for one that was left behind, has removed it.
bool lock_created(int descriptor, const std::string& path) {
  if (uninterrupted([&] { return ::flock(descriptor, LOCK_EX | LOCK_NB); }) == 0) {
    return is_named(descriptor, path);
  }
  if (errno != EWOULDBLOCK) return true;
  uninterrupted([&] { return ::flock(descriptor, LOCK_EX); });
  return is_named(descriptor, path);
}

// To whom a file or folder is open.
struct FileAccess {
  mode_t mode;
  uid_t owner;
  gid_t group;
  bool has_list;  ///< an access control list, which makes the group's permissions mean other things
};

constexpr mode_t kPermissions = S_IRWXU | S_IRWXG | S_IRWXO;

// What stands at `path`, links followed; nothing unless it is of that type.
std::optional<FileAccess> access_of(const std::string& path, mode_t type) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || (status.st_mode & S_IFMT) != type) return std::nullopt;
  const bool has_list = ::getxattr(path.c_str(), "system.posix_acl_access", nullptr, 0) > 0;
  return FileAccess{status.st_mode & kPermissions, status.st_uid, status.st_gid, has_list};
}

// Opens what was created for its owner alone to those of `access`. File systems without
// permissions do without.
void open_to(int descriptor, const FileAccess& access) noexcept {
  constexpr auto kSameOwner = static_cast<uid_t>(-1);
  mode_t mode = access.mode;
  const bool has_group = ::fchown(descriptor, access.owner, access.group) == 0 ||
                         ::fchown(descriptor, kSameOwner, access.group) == 0;
  if (!has_group || access.has_list) {
    // The members of the former group are now among the others, and get no less than these did;
    // those of another group were among the others before.
    const mode_t former_group = (access.mode & S_IRWXG) >> 3;
    mode &= ~static_cast<mode_t>(S_IRWXG);
    mode &= ~static_cast<mode_t>(S_IRWXO) | former_group;
    if (!access.has_list) mode |= (mode & S_IRWXO) << 3;
  }
  ::fchmod(descriptor, mode);
}

// True for the reasons why a file cannot be opened that lie in the file, not in the system: it is
// gone, somebody else's, or no file.
bool is_not_ours(int code) {
  constexpr int kReasons[] = {ENOENT, EACCES, EPERM, ELOOP, EISDIR, ENXIO};
  return std::ranges::find(kReasons, code) != std::end(kReasons);
}

// The names in the folder of `prefix` that start with its last part, or errno where the folder
// cannot be listed. By readdir: std::filesystem's iterator ends the process when its own memory is
// rejected.
int list_names(const std::string& prefix, std::vector<std::string>& names) {
  const std::string base = base_name_of(prefix);
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(::opendir(folder_of(prefix).c_str()),
                                                    ::closedir);
  if (!entries) return errno;
  for (;;) {
    errno = 0;
    const dirent* const entry = ::readdir(entries.get());
    if (entry == nullptr) return errno;
    const std::string name = entry->d_name;
    if (name == "." || name == "..") continue;
    if (name.compare(0, base.size(), base) == 0) names.push_back(name);
  }
}

class LocalFile final : public StorageFile {
 public:
  explicit LocalFile(std::string path) : path_(std::move(path)) {}
  LocalFile(const LocalFile&) = delete;
  LocalFile& operator=(const LocalFile&) = delete;
  ~LocalFile() override {
    for (const int descriptor : {descriptor_, closed_}) {
      if (descriptor >= 0) ::close(descriptor);
    }
  }

  // Opens `name`; false with errno set when that fails. Needs no memory, so that nothing that was
  // opened is ever without an owner.
  bool open(const std::string& name, int flags, mode_t mode = 0) noexcept {
    descriptor_ = uninterrupted([&] { return ::open(name.c_str(), flags | O_CLOEXEC, mode); });
    return descriptor_ >= 0;
  }

  // The same with a new file whose name is made from the pattern in `name`.
  bool open_unique(std::string& name) noexcept {
    descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
    return descriptor_ >= 0;
  }

  int descriptor() const { return descriptor_; }

  const std::string& path() const override { return path_; }

  std::uint64_t size() const override {
    struct stat status {};
    if (fstat(descriptor_, &status) != 0) fail("cannot get its size", path_, errno);
    return static_cast<std::uint64_t>(status.st_size);
  }

  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    while (!out.empty()) {
      const ssize_t count = uninterrupted([&] {
        return ::pread(descriptor_, out.data(), std::min(out.size(), kMaxCallBytes),
                       static_cast<off_t>(offset));
      });
      if (count < 0) fail("cannot read at byte " + std::to_string(offset), path_, errno);
      if (count == 0) {
        throw Error(ErrorKind::truncated,
                    "ends at byte " + std::to_string(offset) + ", " + std::to_string(out.size()) +
                        " bytes too early",
                    path_, offset);
      }
      offset += static_cast<std::uint64_t>(count);
      out = out.subspan(static_cast<std::size_t>(count));
    }
  }

  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const ssize_t count = uninterrupted([&] {
        return ::pwrite(descriptor_, bytes.data(), std::min(bytes.size(), kMaxCallBytes),
                        static_cast<off_t>(offset));
      });
      if (count < 0 && errno == ENOSPC) {
        throw Error(ErrorKind::io, no_space_detail(descriptor_, bytes.size()), path_, offset);
      }
      if (count < 0) fail("cannot write at byte " + std::to_string(offset), path_, errno);
      if (count == 0) fail("cannot write at byte " + std::to_string(offset), path_, EIO);
      offset += static_cast<std::uint64_t>(count);
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
  }

  void truncate(std::uint64_t size) override {
    if (size >= this->size()) return;
    if (uninterrupted([&] { return ::ftruncate(descriptor_, static_cast<off_t>(size)); }) != 0) {
      fail("cannot cut it to " + std::to_string(size) + " bytes", path_, errno);
    }
  }

  void sync() override {
    if (uninterrupted([&] { return ::fsync(descriptor_); }) == 0) return;
    if (errno == ENOSPC || errno == EDQUOT) {
      throw Error(ErrorKind::io, no_space_detail(descriptor_, 0), path_);
    }
    fail("cannot make what was written durable", path_, errno);
  }

  void close() override {
    const int descriptor = std::exchange(descriptor_, -1);
    if (descriptor < 0) return;
    // The lock lasts while any descriptor of the same opening is left.
    closed_ = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
    if (::close(descriptor) != 0 && errno != EINTR) fail("cannot close", path_, errno);
  }

 private:
  int descriptor_ = -1;
  int closed_ = -1;  ///< keeps the lock of a closed file
  std::string path_;
};

// What stands under a name, open and locked; null when somebody here or on another machine has the
// lock, when the file system has none, and when it is neither a file nor a folder, or not ours.
std::unique_ptr<LocalFile> lock_named(const std::string& path) {
  auto file = std::make_unique<LocalFile>(path);
  constexpr int kFlags = O_NOFOLLOW | O_NONBLOCK;
  if (!file->open(path, O_RDWR | kFlags) && !file->open(path, O_RDONLY | kFlags)) return nullptr;
  struct stat status {};
  if (fstat(file->descriptor(), &status) != 0) return nullptr;
  if (!S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) return nullptr;
  if (::flock(file->descriptor(), LOCK_EX | LOCK_NB) != 0) return nullptr;
  return is_named(file->descriptor(), path) ? std::move(file) : nullptr;
}

// Removes what was left behind. A growing file and its journal are one work: whoever has one of
// them locked may be about to lock the other.
void remove_abandoned(const std::string& path, TemporaryType type) {
  const std::string ending = kJournalEnding;
  const bool is_journal = type == TemporaryType::journal;
  const std::string partner =
      is_journal ? path.substr(0, path.size() - ending.size()) : path + ending;
  const auto own_lock = lock_named(path);
  if (!own_lock) return;
  const auto partner_lock = lock_named(partner);
  struct stat status {};
  if (!partner_lock && (::lstat(partner.c_str(), &status) == 0 || errno != ENOENT)) return;
  // Whoever made it and waits for the lock finds the name gone, and makes it anew.
  if (::unlink(path.c_str()) != 0 && errno == EISDIR) remove_plane_folder(path);
}

class LocalStorage final : public Storage {
 public:
  std::unique_ptr<StorageFile> open_read(const std::string& path) override {
    auto file = std::make_unique<LocalFile>(path);
    // Without O_NONBLOCK opening a pipe would wait for its other end.
    if (!file->open(path, O_RDONLY | O_NONBLOCK)) fail("cannot open", path, errno);
    struct stat status {};
    if (fstat(file->descriptor(), &status) != 0) fail("cannot open", path, errno);
    if (S_ISDIR(status.st_mode)) fail("cannot open", path, EISDIR);
    if (!S_ISREG(status.st_mode)) {
      throw Error(ErrorKind::io, "cannot open: not a regular file", path);
    }
    return file;
  }

  std::unique_ptr<StorageFile> create_exclusive(const std::string& path) override {
    return create_file(path, std::nullopt);
  }

  std::unique_ptr<StorageFile> create_replacement(const std::string& path,
                                                  const std::string& target) override {
    std::optional<FileAccess> access = access_of(target, S_IFREG);
    // Whoever continues or repairs it has to open it again.
    if (access) access->mode |= S_IRUSR | S_IWUSR;
    return create_file(path, access);
  }

  std::unique_ptr<StorageFile> open_update(const std::string& path) override {
    auto file = std::make_unique<LocalFile>(path);
    if (!file->open(path, O_RDWR | O_NOFOLLOW | O_NONBLOCK)) {
      if (is_not_ours(errno)) return nullptr;
      fail("cannot open", path, errno);
    }
    struct stat status {};
    if (fstat(file->descriptor(), &status) != 0) fail("cannot open", path, errno);
    if (!S_ISREG(status.st_mode)) return nullptr;
    if (::flock(file->descriptor(), LOCK_EX | LOCK_NB) != 0) return nullptr;
    // Whoever had the lock may have renamed or removed the file before letting go of it.
    if (!is_named(file->descriptor(), path)) return nullptr;
    return file;
  }

  std::unique_ptr<StorageFile> open_shared(const std::string& path) override {
    auto file = std::make_unique<LocalFile>(path);
    if (!file->open(path, O_RDWR | O_NOFOLLOW | O_NONBLOCK)) fail("cannot open", path, errno);
    struct stat status {};
    if (fstat(file->descriptor(), &status) != 0) fail("cannot open", path, errno);
    if (S_ISREG(status.st_mode)) return file;
    throw Error(ErrorKind::io, "cannot open: not a regular file", path);
  }

  bool has_locks(const std::string& path) override {
    LocalFile tried(path);
    const bool is_open = tried.open(path, O_RDONLY | O_NONBLOCK) ||
                         tried.open(folder_of(path), O_RDONLY | O_DIRECTORY);
    if (!is_open) return true;
    const int result =
        uninterrupted([&] { return ::flock(tried.descriptor(), LOCK_SH | LOCK_NB); });
    return result == 0 || errno == EWOULDBLOCK;
  }

  std::unique_ptr<StorageFile> lock_left(const std::string& path) override {
    return lock_named(path);
  }

  bool is_locked(const std::string& path) override {
    LocalFile tried(path);
    if (!tried.open(path, O_RDONLY | O_NONBLOCK)) return false;
    const int result =
        uninterrupted([&] { return ::flock(tried.descriptor(), LOCK_SH | LOCK_NB); });
    return result != 0 && errno == EWOULDBLOCK;
  }

  std::string why_closed(const std::string& folder) override {
    LocalFile tried(folder);
    return open_scratch(tried, folder) ? std::string()
                                       : std::generic_category().message(errno);
  }

  std::unique_ptr<StorageFile> create_scratch(const std::string& folder) override {
    auto file = std::make_unique<LocalFile>(folder + " (scratch file)");
    if (!open_scratch(*file, folder)) fail("cannot create a scratch file", folder, errno);
    return file;
  }

  bool exists(const std::string& path) override {
    struct stat status {};
    if (lstat(path.c_str(), &status) == 0) return true;
    if (errno != ENOENT && errno != ENOTDIR) fail("cannot look up", path, errno);
    return false;
  }

  PathType path_type(const std::string& path) override {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) {
      if (errno != ENOENT && errno != ENOTDIR) fail("cannot look up", path, errno);
      return exists(path) ? PathType::other : PathType::missing;
    }
    if (S_ISREG(status.st_mode)) return PathType::file;
    return S_ISDIR(status.st_mode) ? PathType::folder : PathType::other;
  }

  void rename(const std::string& from, const std::string& to) override {
    if (::rename(from.c_str(), to.c_str()) != 0) fail("cannot take its final name", to, errno);
  }

  void rename_new(const std::string& from, const std::string& to) override {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
    if (errno == EINVAL || errno == ENOSYS) return Storage::rename_new(from, to);
    if (errno == EEXIST) throw Error(ErrorKind::io, "exists already", to).with_field("overwrite");
    fail("cannot take its final name", to, errno);
  }

  bool exchange(const std::string& a, const std::string& b) override {
    if (::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0) return true;
    if (errno == EINVAL || errno == ENOSYS) return false;
    fail("cannot take its final name", b, errno);
  }

  std::unique_ptr<StorageFile> create_folder(const std::string& path,
                                             const std::string& target) override {
    auto access = access_of(target, S_IFDIR);
    if (access) access->mode |= S_IRWXU;
    for (int attempt = 0; attempt < kMaxCreateTries; ++attempt) {
      auto file = std::make_unique<LocalFile>(path);
      if (::mkdir(path.c_str(), access ? 0700 : 0777) != 0) {
        fail("cannot make the folder", path, errno);
      }
      if (!file->open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW)) fail("cannot open", path, errno);
      if (access) open_to(file->descriptor(), *access);
      if (lock_created(file->descriptor(), path)) return file;
    }
    throw Error(ErrorKind::io, "cannot make the folder: another program removes it again and again",
                path);
  }

  void remove(const std::string& path) override {
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail("cannot remove", path, errno);
  }

  void remove_stale(const std::string& prefix) noexcept override {
    try {
      const std::size_t base_length = base_name_of(prefix).size();
      std::vector<std::string> names;
      list_names(prefix, names);
      for (const std::string& name : names) {
        const auto type = temporary_type(std::string_view(name).substr(base_length));
        if (type) remove_abandoned(folder_of(prefix) + "/" + name, *type);
      }
    } catch (const std::exception&) {
      // A stale file that stays does no harm.
    }
  }

  std::vector<std::string> list(const std::string& prefix) override {
    std::vector<std::string> paths;
    const int code = list_names(prefix, paths);
    if (code != 0 && code != ENOENT && code != ENOTDIR) {
      fail("cannot list the folder", folder_of(prefix), code);
    }
    const std::string folder = prefix.substr(0, prefix.size() - base_name_of(prefix).size());
    for (std::string& path : paths) path.insert(0, folder);
    std::sort(paths.begin(), paths.end());
    return paths;
  }

  std::optional<DiskSpace> disk_space(const std::string& folder) override {
    struct stat status {};
    struct statvfs disk {};
    if (::stat(folder.c_str(), &status) != 0 || ::statvfs(folder.c_str(), &disk) != 0) {
      return std::nullopt;
    }
    return DiskSpace{std::uint64_t{disk.f_bavail} * disk.f_frsize,
                     static_cast<std::uint64_t>(status.st_dev)};
  }

  std::optional<std::uint64_t> stored_bytes(const std::string& path) override {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return std::nullopt;
    constexpr std::uint64_t kBlockBytes = 512;  // whatever the block size of the disk
    return static_cast<std::uint64_t>(status.st_blocks) * kBlockBytes;
  }

  void sync_folder(const std::string& folder) override {
    LocalFile file(folder);
    if (!file.open(folder, O_RDONLY | O_DIRECTORY)) fail("cannot open", folder, errno);
    // Some network file systems cannot sync a folder; they order renames themselves.
    const int result = uninterrupted([&] { return ::fsync(file.descriptor()); });
    if (result != 0 && errno != EINVAL && errno != ENOTSUP) {
      fail("cannot make the new name durable", folder, errno);
    }
  }

  std::unique_ptr<StorageFile> lock_folder(const std::string& folder) override {
    auto file = std::make_unique<LocalFile>(folder);
    if (!file->open(folder, O_RDONLY | O_DIRECTORY)) return nullptr;
    for (int attempt = 0; attempt < kMaxLockTries; ++attempt) {
      if (::flock(file->descriptor(), LOCK_EX | LOCK_NB) == 0) return file;
      if (errno != EWOULDBLOCK && errno != EINTR) return nullptr;
      ::usleep(kMicrosecondsToLock);
    }
    throw Error(ErrorKind::io, "another program has had its folder locked for a minute", folder);
  }

 private:
  // Opens a nameless file; false with errno set when that fails.
  static bool open_scratch(LocalFile& file, const std::string& folder) {
    std::string path = folder + "/.octavo-scratch-XXXXXX";
    if (file.open(folder, O_RDWR | O_TMPFILE, 0600)) return true;
    // File systems without nameless files: a named one loses its name at once.
    return file.open_unique(path) && ::unlink(path.c_str()) == 0;
  }

  static std::unique_ptr<StorageFile> create_file(const std::string& path,
                                                  const std::optional<FileAccess>& access) {
    for (int attempt = 0; attempt < kMaxCreateTries; ++attempt) {
      auto file = std::make_unique<LocalFile>(path);
      if (!file->open(path, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW, access ? 0600 : 0666)) {
        if (errno == ENOENT) {
          throw Error(ErrorKind::io, "cannot create: its folder does not exist; make it first",
                      path);
        }
        fail("cannot create", path, errno);
      }
      if (access) open_to(file->descriptor(), *access);
      if (lock_created(file->descriptor(), path)) return file;
    }
    throw Error(ErrorKind::io, "cannot create: another program removes it again and again", path);
  }
};

}  // namespace

Storage& local_storage() {
  static LocalStorage storage;
  return storage;
}

}  // namespace octavo
