#include "octavo/file/storage/storage.h"

#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

class StorageSource final : public ByteSource {
 public:
  explicit StorageSource(std::unique_ptr<StorageFile> file)
      : file_(std::move(file)), size_(file_->size()) {}

  std::uint64_t size() const override { return size_; }
  const std::string& name() const override { return file_->path(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    file_->read(offset, out);
  }

 private:
  std::unique_ptr<StorageFile> file_;
  std::uint64_t size_;
};

}  // namespace

PathType Storage::path_type(const std::string& path) {
  return exists(path) ? PathType::file : PathType::missing;
}

void Storage::rename_new(const std::string& from, const std::string& to) {
  if (exists(to)) throw Error(ErrorKind::io, "exists already", to).with_field("overwrite");
  rename(from, to);
}

bool Storage::exchange(const std::string&, const std::string&) { return false; }

std::unique_ptr<StorageFile> Storage::create_replacement(const std::string& path,
                                                         const std::string&) {
  return create_exclusive(path);
}

std::unique_ptr<StorageFile> Storage::open_shared(const std::string& path) {
  throw Error(ErrorKind::io, "cannot be shared: this storage has one user at a time", path);
}

std::optional<DiskSpace> Storage::disk_space(const std::string&) { return std::nullopt; }

std::unique_ptr<StorageFile> Storage::create_folder(const std::string& path, const std::string&) {
  throw Error(ErrorKind::io, "cannot make the folder: this storage has none", path);
}

std::optional<std::uint64_t> Storage::stored_bytes(const std::string&) { return std::nullopt; }

std::string Storage::why_closed(const std::string&) { return {}; }

bool Storage::has_locks(const std::string&) { return true; }

bool Storage::is_locked(const std::string&) { return false; }

std::unique_ptr<StorageFile> Storage::lock_left(const std::string&) { return nullptr; }

std::unique_ptr<StorageFile> Storage::lock_folder(const std::string&) { return nullptr; }

void Storage::remove_stale(const std::string&) noexcept {}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::string base_name_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

std::shared_ptr<ByteSource> open_byte_source(Storage& storage, const std::string& path) {
  return std::make_shared<StorageSource>(storage.open_read(path));
}

}  // namespace octavo
