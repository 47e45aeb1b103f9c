#include "octavo/io/pending_file.h"

#include <unistd.h>

#include <utility>

#include "octavo/core/error.h"

namespace octavo {

std::string temporary_path(const std::string& path) {
  const std::string name = base_name_of(path);
  return path.substr(0, path.size() - name.size()) + "." + name + ".tmp-" +
         std::to_string(::getpid());
}

void remove_quietly(Storage& storage, const std::string& path) noexcept {
  try {
    storage.remove(path);
  } catch (...) {
    // The failure that led here is the one to be told.
  }
}

PendingFile::PendingFile(Storage& storage, std::string path)
    : storage_(storage), path_(std::move(path)), temporary_path_(temporary_path(path_)) {
  try {
    file_ = storage_.create_exclusive(temporary_path_);
  } catch (const Error& failure) {
    // The name that was asked for says more, unless the temporary one is what stands in the way.
    if (storage_.exists(temporary_path_)) throw;
    throw Error(failure.kind(), failure.detail(), path_);
  }
}

PendingFile::~PendingFile() { discard(); }

void PendingFile::discard() noexcept {
  if (is_published_) return;
  file_.reset();
  remove_quietly(storage_, temporary_path_);
}

void PendingFile::append(std::span<const std::uint8_t> bytes) {
  file_->write(size_, bytes);
  size_ += bytes.size();
}

void PendingFile::seal() {
  size_ = file_->size();
  file_->sync();
  file_->close();
  file_.reset();
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
