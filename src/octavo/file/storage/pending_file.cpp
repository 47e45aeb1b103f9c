#include "octavo/file/storage/pending_file.h"

#include <utility>

#include "octavo/file/storage/temporary.h"
#include "octavo/file/storage/unchanged.h"

namespace octavo {

PendingFile::PendingFile(Storage& storage, std::string path)
    : PendingFile(storage, path, path) {}

PendingFile::PendingFile(Storage& storage, std::string path, const std::string& target)
    : storage_(storage), path_(std::move(path)) {
  try {
    TemporaryFile temporary = create_temporary(storage_, path_, target);
    temporary_path_ = std::move(temporary.path);
    file_ = std::move(temporary.file);
  } catch (const Error& failure) {
    throw with_unchanged(storage_, with_final_name(failure, path_), path_);
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
    throw with_unchanged(storage_, with_final_name(error, path_), path_);
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

// The two earlier files come back under their names; what has not left its own stays.
void put_back(Storage& storage, const std::string& header, const std::string& data,
              const std::string& earlier_header) {
  const std::string earlier_data = earlier_name(data);
  if (storage.exists(earlier_data)) storage.rename(earlier_data, data);
  if (storage.exists(earlier_header)) storage.rename(earlier_header, header);
}

// Ends what a program left that was stopped while it replaced a pair: before the new header had its
// name the earlier pair comes back, whole; afterwards it goes. Requires the folder's lock.
void settle_locked(Storage& storage, const std::string& header, const std::string& data) {
  const std::string earlier_header = earlier_name(header);
  if (storage.exists(earlier_header) && !storage.exists(header)) {
    put_back(storage, header, data, earlier_header);
    return storage.sync_folder(folder_of(header));
  }
  storage.remove(earlier_header);
  storage.remove(earlier_name(data));
}

// Replaces an earlier pair, or a header that has no data beside it.
class PairSwap {
 public:
  PairSwap(Storage& storage, PendingFile& header, PendingFile& data)
      : storage_(storage),
        header_(header),
        data_(data),
        has_earlier_data_(storage.exists(data.path())),
        // The earlier data say later on whether the new ones stand there. A header
        // without goes as what is left behind does.
        earlier_header_(has_earlier_data_ ? earlier_name(header.path())
                                          : free_temporary_name(storage, header.path())),
        lock_(storage.open_update(header.path())) {}

  void run() {
    try {
      take_names();
    } catch (const Error& error) {
      if (undo() || !has_earlier_data_) throw;
      throw error.with_detail(error.detail() + "; the earlier pair lies beside it, " +
                              escaped(base_name_of(earlier_header_)) +
                              " and its voxels: the next export of this name puts them back");
    } catch (...) {
      undo();
      throw;
    }
    sync_new_name(storage_, header_.path());
    remove_quietly(storage_, earlier_header_);
    if (has_earlier_data_) remove_quietly(storage_, earlier_name(data_.path()));
  }

 private:
  void take_names() {
    storage_.rename(header_.path(), earlier_header_);
    storage_.sync_folder(folder_of(header_.path()));
    if (has_earlier_data_) storage_.rename(data_.path(), earlier_name(data_.path()));
    data_.take_name(true);
    has_new_data_ = true;
    storage_.sync_folder(folder_of(data_.path()));
    header_.take_name(true);
  }

  // Returns whether the earlier pair has its names again.
  bool undo() noexcept {
    try {
      if (has_new_data_ && !has_earlier_data_) storage_.remove(data_.path());
      put_back(storage_, header_.path(), data_.path(), earlier_header_);
    } catch (...) {
      return false;
    }
    try {
      storage_.sync_folder(folder_of(header_.path()));
    } catch (...) {
      // The failure that led here is the one to report; after a power cut settle_pair does it.
    }
    return true;
  }

  Storage& storage_;
  PendingFile& header_;
  PendingFile& data_;
  bool has_earlier_data_;
  bool has_new_data_ = false;
  std::string earlier_header_;
  std::unique_ptr<StorageFile> lock_;  ///< says that the earlier header is not left behind
};

// Calls `f` with the containing folder locked; what fails carries one of the two names.
template <class F>
void with_folder(Storage& storage, const std::string& header, const std::string& data, F f) {
  try {
    const auto lock = storage.lock_folder(folder_of(header));
    f();
  } catch (const Error& error) {
    throw retold(error, error.kind(), error.detail(), error.path() == data ? data : header);
  }
}

}  // namespace

void settle_pair(Storage& storage, const std::string& header, const std::string& data) {
  if (!storage.exists(earlier_name(header)) && !storage.exists(earlier_name(data))) return;
  with_folder(storage, header, data, [&] { settle_locked(storage, header, data); });
}

void publish_pair(Storage& storage, PendingFile& header, PendingFile& data, bool overwrite) {
  with_folder(storage, header.path(), data.path(), [&] {
    settle_locked(storage, header.path(), data.path());
    if (overwrite && storage.exists(header.path())) {
      PairSwap(storage, header, data).run();
    } else {
      publish_new_pair(storage, header, data, overwrite);
    }
  });
}

}  // namespace octavo
