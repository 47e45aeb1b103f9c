#include "octavo/io/pending_file.h"

#include <utility>

#include "octavo/file/temporary.h"

namespace octavo {

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

void PendingFile::take_name(bool overwrite) {
  if (overwrite) {
    storage_.rename(temporary_path_, path_);
  } else {
    storage_.rename_new(temporary_path_, path_);
  }
  is_published_ = true;
  file_.reset();
}

void PendingFile::publish(bool overwrite) {
  const bool replaces = overwrite && storage_.exists(path_);
  take_name(overwrite);
  settle_new_name(storage_, path_, replaces);
}

namespace {

// Both names are free: without its header the data are of no use.
void publish_new_pair(Storage& storage, PendingFile& header, PendingFile& data, bool overwrite) {
  const bool replaces_data = overwrite && storage.exists(data.path());
  data.publish(overwrite);
  try {
    header.publish(overwrite);
  } catch (...) {
    if (!replaces_data) remove_quietly(storage, data.path());
    throw;
  }
}

// Puts the earlier header back; when that fails, none stands there.
void put_back(Storage& storage, const std::string& earlier, const std::string& path) noexcept {
  try {
    storage.rename(earlier, path);
    storage.sync_folder(folder_of(path));
  } catch (...) {
    // The failure that led here is the one to be told.
  }
}

void replace_pair(Storage& storage, PendingFile& header, PendingFile& data) {
  // The earlier header, locked so that nobody takes it for one that was left behind.
  const auto lock = storage.open_update(header.path());
  const std::string earlier = free_temporary_name(storage, header.path());
  storage.rename(header.path(), earlier);
  bool has_new_data = false;
  try {
    storage.sync_folder(folder_of(header.path()));
    data.take_name(true);
    has_new_data = true;
    storage.sync_folder(folder_of(data.path()));
    header.take_name(true);
  } catch (const Error& error) {
    if (!has_new_data) {
      put_back(storage, earlier, header.path());
      throw;
    }
    remove_quietly(storage, earlier);
    throw Error(error.kind(),
                error.detail() + "; " + escaped(base_name_of(data.path())) +
                    " holds the new voxels and has no header; write both again",
                header.path(), error.offset());
  }
  remove_quietly(storage, earlier);
  sync_new_name(storage, header.path());
}

}  // namespace

void publish_pair(Storage& storage, PendingFile& header, PendingFile& data, bool overwrite) {
  if (!overwrite || !storage.exists(header.path())) {
    return publish_new_pair(storage, header, data, overwrite);
  }
  try {
    replace_pair(storage, header, data);
  } catch (const Error& error) {
    const std::string& path = error.path() == data.path() ? data.path() : header.path();
    throw Error(error.kind(), error.detail(), path, error.offset());
  }
}

}  // namespace octavo
