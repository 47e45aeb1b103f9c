#include "octavo/io/pending_file.h"

#include <utility>

#include "octavo/file/temporary.h"

namespace octavo {

Error with_final_name(const Error& error, const std::string& path) {
  if (error.path().rfind(temporary_prefix(path), 0) != 0) return error;
  return Error(error.kind(), error.detail(), path, error.offset());
}

void remove_quietly(Storage& storage, const std::string& path) noexcept {
  try {
    storage.remove(path);
  } catch (...) {
    // The failure that led here is the one to be told.
  }
}

PendingFile::PendingFile(Storage& storage, std::string path)
    : storage_(storage), path_(std::move(path)) {
  try {
    TemporaryFile temporary = create_temporary(storage_, path_);
    temporary_path_ = std::move(temporary.path);
    file_ = std::move(temporary.file);
  } catch (const Error& failure) {
    throw with_final_name(failure, path_);
  }
}

PendingFile::~PendingFile() { discard(); }

void PendingFile::discard() noexcept {
  if (is_published_) return;
  remove_quietly(storage_, temporary_path_);
}

template <class F>
void PendingFile::named(F f) const {
  try {
    f();
  } catch (const Error& error) {
    throw with_final_name(error, path_);
  }
}

void PendingFile::append(std::span<const std::uint8_t> bytes) {
  named([&] { file_->write(size_, bytes); });
  size_ += bytes.size();
}

void PendingFile::seal() {
  named([&] {
    size_ = file_->size();
    file_->sync();
    file_->close();
  });
}

void PendingFile::publish(bool overwrite) {
  const bool replaces = overwrite && storage_.exists(path_);
  if (overwrite) {
    storage_.rename(temporary_path_, path_);
  } else {
    storage_.rename_new(temporary_path_, path_);
  }
  is_published_ = true;
  try {
    storage_.sync_folder(folder_of(path_));
  } catch (...) {
    if (!replaces) remove_quietly(storage_, path_);
    throw;
  }
}

}  // namespace octavo
