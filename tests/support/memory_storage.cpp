#include "support/memory_storage.h"

#include <algorithm>
#include <utility>

#include "octavo/core/error.h"

namespace octavo::testing {

namespace {

class MemoryFile final : public StorageFile {
 public:
  MemoryFile(MemoryStorage& storage, FileBytes bytes, std::string path)
      : storage_(storage), bytes_(std::move(bytes)), path_(std::move(path)) {}

  const std::string& path() const override { return path_; }
  std::uint64_t size() const override { return bytes_->size(); }

  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    storage_.call("read", path_);
    if (offset + out.size() > bytes_->size()) throw Error(ErrorKind::truncated, "ends", path_);
    std::copy_n(bytes_->begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
  }

  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes) override {
    try {
      storage_.call("write", path_);
    } catch (const Error&) {
      if (storage_.calls.size() == storage_.fail_at) store(offset, bytes.first(bytes.size() / 2));
      throw;
    }
    store(offset, bytes);
  }

  void truncate(std::uint64_t size) override {
    storage_.call("truncate", path_);
    if (size < bytes_->size()) bytes_->resize(size);
  }

  void sync() override { storage_.call("sync", path_); }
  void close() override { storage_.call("close", path_); }

 private:
  void store(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
    bytes_->resize(std::max<std::size_t>(bytes_->size(), offset + bytes.size()));
    std::copy(bytes.begin(), bytes.end(), bytes_->begin() + static_cast<std::ptrdiff_t>(offset));
  }

  MemoryStorage& storage_;
  FileBytes bytes_;
  std::string path_;
};

}  // namespace

std::map<std::string, FileBytes> copied(const std::map<std::string, FileBytes>& files) {
  std::map<std::string, FileBytes> copy;
  for (const auto& [name, bytes] : files) {
    copy[name] = std::make_shared<std::vector<std::uint8_t>>(*bytes);
  }
  return copy;
}

void MemoryStorage::call(const std::string& what, const std::string& path) {
  calls.push_back(what);
  if (meanwhile) meanwhile(what);
  const bool is_dead = is_dying && fail_at > 0 && calls.size() > fail_at;
  if (calls.size() != fail_at && !is_dead) return;
  has_failed = true;
  throw Error(ErrorKind::io, "cannot " + what + ": Input/output error", path);
}

std::unique_ptr<StorageFile> MemoryStorage::open_read(const std::string& path) {
  call("open", path);
  const auto found = files.find(path);
  if (found == files.end()) throw Error(ErrorKind::io, "cannot open: no such file", path);
  return std::make_unique<MemoryFile>(*this, found->second, path);
}

std::unique_ptr<StorageFile> MemoryStorage::create_exclusive(const std::string& path) {
  call("create", path);
  if (files.count(path) != 0) throw Error(ErrorKind::io, "cannot create: exists", path);
  files[path] = std::make_shared<std::vector<std::uint8_t>>();
  return std::make_unique<MemoryFile>(*this, files[path], path);
}

std::unique_ptr<StorageFile> MemoryStorage::open_update(const std::string& path) {
  call("open_update", path);
  const auto found = files.find(path);
  if (found == files.end()) return nullptr;
  return std::make_unique<MemoryFile>(*this, found->second, path);
}

std::unique_ptr<StorageFile> MemoryStorage::open_shared(const std::string& path) {
  call("open_shared", path);
  const auto found = files.find(path);
  if (found == files.end()) throw Error(ErrorKind::io, "no such file", path);
  return std::make_unique<MemoryFile>(*this, found->second, path);
}

std::unique_ptr<StorageFile> MemoryStorage::create_scratch(const std::string& folder) {
  call("create_scratch", folder);
  return std::make_unique<MemoryFile>(*this, std::make_shared<std::vector<std::uint8_t>>(),
                                      folder);
}

bool MemoryStorage::exists(const std::string& path) { return files.count(path) != 0; }

void MemoryStorage::rename(const std::string& from, const std::string& to) {
  call("rename", to);
  const auto found = files.find(from);
  if (found == files.end()) throw Error(ErrorKind::io, "cannot rename: no such file", to);
  files[to] = found->second;
  files.erase(from);
}

void MemoryStorage::remove(const std::string& path) {
  if (is_dying && has_failed) call("remove", path);
  files.erase(path);
}

void MemoryStorage::remove_stale(const std::string& prefix) noexcept {
  if (is_dying && has_failed) return;
  for (const std::string& path : list(prefix)) files.erase(path);
}

std::vector<std::string> MemoryStorage::list(const std::string& prefix) {
  std::vector<std::string> paths;
  for (const auto& [path, bytes] : files) {
    if (path.starts_with(prefix)) paths.push_back(path);
  }
  return paths;
}

void MemoryStorage::sync_folder(const std::string& folder) { call("sync_folder", folder); }

}  // namespace octavo::testing
