// A storage that dies in the middle of its work, whoever of several threads uses it.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"

namespace octavo::testing {

/// Passes everything on but syncs, which take long and matter to power cuts alone; from call
/// number `fail_at` (from 1) on every call throws Error{io} and changes nothing: what is left is
/// what a killed process leaves.
class DyingStorage final : public Storage {
 public:
  DyingStorage(Storage& storage, std::size_t fail_at) : storage_(storage), fail_at_(fail_at) {}

  /// Of a file system without locks.
  void lose_locks() { has_locks_ = false; }
  /// Of one that cannot let two names change places.
  void lose_exchange() { has_exchange_ = false; }
  /// Calls behind the one that fails work again: it is a failure and no death.
  void fail_once() { fails_once_ = true; }

  std::size_t calls() const { return calls_; }
  bool is_dead() const { return fail_at_ > 0 && calls_ >= fail_at_ && !fails_once_; }

  std::unique_ptr<StorageFile> open_read(const std::string& path) override {
    return file(storage_.open_read(counted(path)));
  }
  std::unique_ptr<StorageFile> create_exclusive(const std::string& path) override {
    return file(storage_.create_exclusive(counted(path)));
  }
  std::unique_ptr<StorageFile> create_replacement(const std::string& path,
                                                  const std::string& target) override {
    return file(storage_.create_replacement(counted(path), target));
  }
  std::unique_ptr<StorageFile> open_update(const std::string& path) override {
    if (!has_locks_) return nullptr;
    return file(storage_.open_update(counted(path)));
  }
  bool has_locks(const std::string& path) override {
    return has_locks_ && storage_.has_locks(path);
  }
  std::unique_ptr<StorageFile> open_shared(const std::string& path) override {
    return file(storage_.open_shared(counted(path)));
  }
  std::unique_ptr<StorageFile> create_scratch(const std::string& folder) override {
    return file(storage_.create_scratch(counted(folder)));
  }
  bool exists(const std::string& path) override { return storage_.exists(path); }
  PathType path_type(const std::string& path) override { return storage_.path_type(path); }
  void rename(const std::string& from, const std::string& to) override {
    counted(to);
    storage_.rename(from, to);
  }
  void rename_new(const std::string& from, const std::string& to) override {
    counted(to);
    storage_.rename_new(from, to);
  }
  bool exchange(const std::string& a, const std::string& b) override {
    return has_exchange_ && storage_.exchange(a, counted(b));
  }
  void remove(const std::string& path) override { storage_.remove(counted(path)); }
  std::unique_ptr<StorageFile> create_folder(const std::string& path,
                                             const std::string& target) override {
    return file(storage_.create_folder(counted(path), target));
  }
  std::unique_ptr<StorageFile> lock_left(const std::string& path) override {
    return has_locks_ ? file(storage_.lock_left(path)) : nullptr;
  }
  std::vector<std::string> list(const std::string& prefix) override {
    return storage_.list(prefix);
  }
  void sync_folder(const std::string& folder) override { counted(folder); }

 private:
  bool has_locks_ = true;
  bool has_exchange_ = true;
  bool fails_once_ = false;

  class File final : public StorageFile {
   public:
    File(DyingStorage& storage, std::unique_ptr<StorageFile> file)
        : storage_(storage), file_(std::move(file)) {}
    const std::string& path() const override { return file_->path(); }
    std::uint64_t size() const override { return file_->size(); }
    void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
      storage_.counted(path());
      file_->read(offset, out);
    }
    void write(std::uint64_t offset, std::span<const std::uint8_t> bytes) override {
      try {
        storage_.counted(path());
      } catch (const Error&) {
        const bool fails_here = storage_.calls_ == storage_.fail_at_;
        if (fails_here) file_->write(offset, bytes.first(bytes.size() / 2));
        throw;
      }
      file_->write(offset, bytes);
    }
    void truncate(std::uint64_t size) override {
      storage_.counted(path());
      file_->truncate(size);
    }
    void sync() override { storage_.counted(path()); }
    void close() override {
      storage_.counted(path());
      file_->close();
    }

   private:
    DyingStorage& storage_;
    std::unique_ptr<StorageFile> file_;
  };

  const std::string& counted(const std::string& path) {
    const std::size_t call = ++calls_;
    if (fail_at_ == 0 || call < fail_at_ || (fails_once_ && call > fail_at_)) return path;
    throw Error(ErrorKind::io, "the storage is gone", path);
  }

  std::unique_ptr<StorageFile> file(std::unique_ptr<StorageFile> file) {
    if (!file) return nullptr;
    return std::make_unique<File>(*this, std::move(file));
  }

  Storage& storage_;
  std::size_t fail_at_;  ///< 0: never
  std::atomic<std::size_t> calls_ = 0;
};

}  // namespace octavo::testing
