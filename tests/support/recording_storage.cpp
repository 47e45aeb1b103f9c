#include "support/recording_storage.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "octavo/core/error.h"

namespace octavo::testing {

namespace {

constexpr std::size_t kPageBytes = 4096;
constexpr std::size_t kLoggedBytes = 8 * kPageBytes;
constexpr std::size_t kOldFile = ~std::size_t{0};

using Content = std::vector<std::uint8_t>;

void store(Content& content, std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  content.resize(std::max<std::size_t>(content.size(), offset + bytes.size()));
  std::copy(bytes.begin(), bytes.end(), content.begin() + static_cast<std::ptrdiff_t>(offset));
}

class RecordedFile final : public StorageFile {
 public:
  // log  nullptr for scratch files
  RecordedFile(std::string path, std::shared_ptr<Content> content, std::vector<Change>* log,
               std::size_t number)
      : path_(std::move(path)), content_(std::move(content)), log_(log), number_(number) {}

  const std::string& path() const override { return path_; }
  std::uint64_t size() const override { return content_->size(); }

  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (offset + out.size() > content_->size()) throw Error(ErrorKind::truncated, "ends", path_);
    std::copy_n(content_->begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
  }

  void write(std::uint64_t offset, std::span<const std::uint8_t> bytes) override {
    store(*content_, offset, bytes);
    while (log_ != nullptr && !bytes.empty()) {
      const auto part = bytes.first(std::min(bytes.size(), kLoggedBytes));
      log_->push_back({.what = Change::What::write,
                       .file = number_,
                       .name = {},
                       .new_name = {},
                       .offset = offset,
                       .bytes = {part.begin(), part.end()}});
      offset += part.size();
      bytes = bytes.subspan(part.size());
    }
  }

  // Only a build that continues another one cuts files; the log holds whole builds.
  void truncate(std::uint64_t) override {
    throw Error(ErrorKind::io, "cannot be cut: the log has no such change", path_);
  }

  void sync() override {
    if (log_ == nullptr) return;
    Change change;
    change.what = Change::What::sync;
    change.file = number_;
    log_->push_back(change);
  }

  void close() override {}

 private:
  std::string path_;
  std::shared_ptr<Content> content_;
  std::vector<Change>* log_;
  std::size_t number_;
};

// The disk while changes reach it.
class Disk {
 public:
  Disk(const std::string& name, const Content* old_bytes) {
    if (old_bytes == nullptr) return;
    names_[name] = kOldFile;
    on_disk_[kOldFile] = *old_bytes;
  }

  void take(const Change& change) {
    switch (change.what) {
      case Change::What::write: waiting_[change.file].push_back(&change); break;
      case Change::What::sync: sync(change.file); break;
      case Change::What::sync_folder: apply_names(waiting_names_.size()); break;
      default: waiting_names_.push_back(&change);
    }
  }

  // The cut.
  void lose(Outlasting outlasting, std::mt19937_64& random) {
    const bool has_random_names = outlasting == Outlasting::some_of_all;
    const bool loses_names = outlasting == Outlasting::nothing ||
                             outlasting == Outlasting::data_before_names;
    const std::size_t all = waiting_names_.size();
    apply_names(has_random_names ? random() % (all + 1) : loses_names ? 0 : all);
    for (auto& [file, writes] : waiting_) {
      for (const Change* write : writes) {
        for (std::size_t at = 0; at < write->bytes.size(); at += kPageBytes) {
          if (outlasts(outlasting, random)) store_page(file, *write, at);
        }
      }
    }
  }

  std::unique_ptr<Content> file(const std::string& name) {
    const auto found = names_.find(name);
    if (found == names_.end()) return nullptr;
    return std::make_unique<Content>(on_disk_[found->second]);
  }

 private:
  static bool outlasts(Outlasting outlasting, std::mt19937_64& random) {
    switch (outlasting) {
      case Outlasting::everything:
      case Outlasting::data_before_names: return true;
      case Outlasting::nothing:
      case Outlasting::names_before_data: return false;
      default: return random() % 2 == 0;
    }
  }

  void store_page(std::size_t file, const Change& write, std::size_t at) {
    const auto bytes = std::span(write.bytes).subspan(at);
    store(on_disk_[file], write.offset + at, bytes.first(std::min(bytes.size(), kPageBytes)));
  }

  void sync(std::size_t file) {
    for (const Change* write : waiting_[file]) {
      store(on_disk_[file], write->offset, write->bytes);
    }
    waiting_[file].clear();
  }

  void apply_names(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const Change& change = *waiting_names_[i];
      if (change.what == Change::What::create) {
        names_[change.name] = change.file;
        continue;
      }
      if (change.what == Change::What::rename) names_[change.new_name] = names_.at(change.name);
      names_.erase(change.name);
    }
    waiting_names_.clear();
  }

  std::map<std::string, std::size_t> names_;
  std::map<std::size_t, Content> on_disk_;
  std::map<std::size_t, std::vector<const Change*>> waiting_;
  std::vector<const Change*> waiting_names_;
};

}  // namespace

void RecordingStorage::add_file(const std::string& name, std::vector<std::uint8_t> bytes) {
  names_[name] = contents_.size();
  contents_.push_back(std::make_shared<Content>(std::move(bytes)));
}

std::unique_ptr<StorageFile> RecordingStorage::open_read(const std::string& path) {
  const auto found = names_.find(path);
  if (found == names_.end()) throw Error(ErrorKind::io, "cannot open: no such file", path);
  return std::make_unique<RecordedFile>(path, contents_[found->second], nullptr, 0);
}

std::unique_ptr<StorageFile> RecordingStorage::create_exclusive(const std::string& path) {
  if (exists(path)) throw Error(ErrorKind::io, "cannot create: exists", path);
  add_file(path, {});
  Change change;
  change.what = Change::What::create;
  change.file = contents_.size() - 1;
  change.name = path;
  changes.push_back(change);
  return std::make_unique<RecordedFile>(path, contents_.back(), &changes, change.file);
}

std::unique_ptr<StorageFile> RecordingStorage::open_update(const std::string& path) {
  const auto found = names_.find(path);
  if (found == names_.end()) return nullptr;
  return std::make_unique<RecordedFile>(path, contents_[found->second], &changes, found->second);
}

std::unique_ptr<StorageFile> RecordingStorage::create_scratch(const std::string& folder) {
  return std::make_unique<RecordedFile>(folder, std::make_shared<Content>(), nullptr, 0);
}

bool RecordingStorage::exists(const std::string& path) { return names_.count(path) != 0; }

void RecordingStorage::rename(const std::string& from, const std::string& to) {
  Change change;
  change.what = Change::What::rename;
  change.name = from;
  change.new_name = to;
  changes.push_back(change);
  names_[to] = names_.at(from);
  names_.erase(from);
}

void RecordingStorage::remove(const std::string& path) {
  if (names_.erase(path) == 0) return;
  Change change;
  change.what = Change::What::remove;
  change.name = path;
  changes.push_back(change);
}

std::vector<std::string> RecordingStorage::list(const std::string& prefix) {
  std::vector<std::string> paths;
  for (const auto& [name, file] : names_) {
    if (name.compare(0, prefix.size(), prefix) == 0) paths.push_back(name);
  }
  return paths;
}

void RecordingStorage::sync_folder(const std::string&) {
  Change change;
  change.what = Change::What::sync_folder;
  changes.push_back(change);
}

std::unique_ptr<std::vector<std::uint8_t>> after_power_cut(
    const std::vector<Change>& changes, std::size_t count, const std::string& name,
    const std::vector<std::uint8_t>* old_bytes, Outlasting outlasting, std::mt19937_64& random) {
  Disk disk(name, old_bytes);
  for (std::size_t i = 0; i < count; ++i) disk.take(changes[i]);
  disk.lose(outlasting, random);
  return disk.file(name);
}

}  // namespace octavo::testing
