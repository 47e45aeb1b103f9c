#include "octavo/io/zarr/zarr_output.h"

#include <zlib.h>

#include <filesystem>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/file/storage/temporary.h"

namespace octavo {

namespace {

namespace fs = std::filesystem;

constexpr const char* kGroupFile = "zarr.json";

[[noreturn]] void fail_on(const std::string& path, const std::string& what,
                          const std::error_code& reason) {
  throw Error(ErrorKind::io, what + ": " + reason.message(), path);
}

void remove_tree(const std::string& path) noexcept {
  std::error_code none;
  fs::remove_all(path, none);
}

bool is_zarr_number(const std::string& name) {
  return !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
}

/// Whether images have files, or folders, of that name in folders so deep: zarr.json, 0/zarr.json
/// and 0/c/1/2/3.
bool is_of_image(const fs::directory_entry& entry, int depth) {
  std::error_code none;
  const fs::file_type type = entry.symlink_status(none).type();
  const std::string name = entry.path().filename().string();
  if (type == fs::file_type::regular) {
    return depth == 4 ? is_zarr_number(name) : depth < 2 && name == kGroupFile;
  }
  if (type != fs::file_type::directory) return false;
  return depth == 1 ? name == "c" : depth < 4 && is_zarr_number(name);
}

/// What lies in a folder besides the files of an image; empty where nothing does. What cannot be
/// listed is something else.
std::string strange_in_image(const std::string& folder) {
  std::error_code reason;
  fs::recursive_directory_iterator entry(folder, reason);
  const fs::recursive_directory_iterator end;
  for (; !reason && entry != end; entry.increment(reason)) {
    if (!is_of_image(*entry, entry.depth())) {
      return entry->path().lexically_relative(folder).string();
    }
  }
  return reason ? reason.message() : std::string();
}

/// Throws where a name is taken by anything but an image that may be replaced.
void require_replaceable(Storage& storage, const std::string& path, bool overwrite) {
  if (!storage.exists(path)) return;
  if (!overwrite) {
    throw Error(ErrorKind::io, "already exists", path).with_field("output.overwrite");
  }
  if (!storage.exists(path + "/" + kGroupFile)) {
    throw Error(ErrorKind::io, "is no zarr hierarchy, and is not replaced", path);
  }
  const std::string strange = strange_in_image(path);
  if (strange.empty()) return;
  throw Error(ErrorKind::io,
              "holds more than an image, and is not replaced: " + escaped(strange), path);
}

/// Removes what killed processes left for a name, old images that they had replaced included.
void remove_left_images(Storage& storage, const std::string& path) {
  for (const std::string& left : list_temporaries(storage, path)) {
    const auto lock = storage.lock_left(left);
    if (lock && strange_in_image(left).empty()) remove_tree(left);
  }
}

class ZarrFolder final : public ZarrOutput {
 public:
  ZarrFolder(Storage& storage, std::string path, bool overwrite)
      : storage_(storage), path_(std::move(path)), overwrite_(overwrite) {
    require_replaceable(storage_, path_, overwrite_);
    remove_left_images(storage_, path_);
    folder_ = create_temporary_folder(storage_, path_);
  }

  ~ZarrFolder() override {
    if (!is_finished_) remove_tree(folder_.path);
  }

  ZarrFolder(const ZarrFolder&) = delete;
  ZarrFolder& operator=(const ZarrFolder&) = delete;

  void put(const std::string& key, std::span<const std::uint8_t> bytes) override {
    const std::string place = folder_.path + "/" + key;
    const std::string parent = folder_of(place);
    try {
      make_folders(parent);
      const auto file = storage_.create_exclusive(place);
      file->write(0, bytes);
      file->sync();
      file->close();
    } catch (const Error& error) {
      throw with_final_name(error, path_);
    }
    bytes_ += bytes.size();
  }

  void finish() override {
    for (const std::string& parent : parents_) storage_.sync_folder(parent);
    require_replaceable(storage_, path_, overwrite_);
    const bool replaces = storage_.exists(path_);
    if (!replaces) {
      storage_.rename_new(folder_.path, path_);
    } else if (storage_.exchange(folder_.path, path_)) {
      remove_tree(folder_.path);
    } else {
      replace_in_steps();
    }
    is_finished_ = true;
    sync_new_name(storage_, path_);
  }

  std::uint64_t bytes() const override { return bytes_; }

 private:
  /// Makes a folder and those around it, all of which finish() makes durable.
  void make_folders(const std::string& folder) {
    if (parents_.contains(folder)) return;
    std::error_code reason;
    fs::create_directories(folder, reason);
    if (reason) fail_on(folder, "cannot be made", reason);
    std::string made = folder;
    while (parents_.insert(made).second && made != folder_.path) made = folder_of(made);
  }

  /// Where two names cannot change places in one step: the old image goes when the new one stands.
  void replace_in_steps() {
    const std::string old = free_temporary_name(storage_, path_);
    storage_.rename(path_, old);
    try {
      storage_.rename_new(folder_.path, path_);
    } catch (...) {
      storage_.rename(old, path_);
      throw;
    }
    remove_tree(old);
  }

  Storage& storage_;
  std::string path_;
  bool overwrite_;
  TemporaryFile folder_;
  std::set<std::string> parents_;  ///< folders that were made
  std::uint64_t bytes_ = 0;
  bool is_finished_ = false;
};

/// Numbers of 16, 32 and 64 bits, the low byte first.
class ZipRecord {
 public:
  ZipRecord& u16(std::uint64_t value) { return put(value, 2); }
  ZipRecord& u32(std::uint64_t value) { return put(value, 4); }
  ZipRecord& u64(std::uint64_t value) { return put(value, 8); }
  ZipRecord& text(const std::string& text) {
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  ZipRecord& put(std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> 8 * i));
    return *this;
  }
  std::vector<std::uint8_t> bytes_;
};

class ZarrZip final : public ZarrOutput {
 public:
  ZarrZip(Storage& storage, const std::string& path, bool overwrite)
      : overwrite_(overwrite), file_(storage, path) {
    if (storage.path_type(path) == PathType::folder) {
      throw Error(ErrorKind::io, "is a folder; name the file to write", path);
    }
    if (storage.exists(path) && !overwrite) {
      throw Error(ErrorKind::io, "already exists", path).with_field("output.overwrite");
    }
  }

  void put(const std::string& key, std::span<const std::uint8_t> bytes) override {
    if (bytes.size() > kMost32) {
      throw Error(ErrorKind::limit_exceeded, "a file of 4 GiB or more in a zip file", file_.path());
    }
    const auto crc = crc32(0, bytes.data(), static_cast<uInt>(bytes.size()));
    entries_.push_back({key, file_.size(), bytes.size(), crc});
    ZipRecord head;
    head.u32(0x04034b50).u16(kVersion).u16(kUtf8).u16(0).u16(0).u16(kFirstDay);
    head.u32(crc).u32(bytes.size()).u32(bytes.size()).u16(key.size()).u16(0).text(key);
    file_.append(head.bytes());
    file_.append(bytes);
  }

  void finish() override {
    const std::uint64_t start = file_.size();
    for (const Entry& entry : entries_) file_.append(central_record(entry));
    const std::uint64_t end = file_.size();
    ZipRecord tail;
    // The 64-bit form always: readers look for it first.
    tail.u32(0x06064b50).u64(44).u16(kVersion).u16(kVersion).u32(0).u32(0);
    tail.u64(entries_.size()).u64(entries_.size()).u64(end - start).u64(start);
    tail.u32(0x07064b50).u32(0).u64(end).u32(1);
    const std::string comment = "{\"ome\":{\"version\":\"0.5\",\"zipFile\":{\"centralDirectory\":"
                                "{\"jsonFirst\":true}}}}";
    tail.u32(0x06054b50).u16(0).u16(0).u16(kMost16).u16(kMost16).u32(kMost32).u32(kMost32);
    tail.u16(comment.size()).text(comment);
    file_.append(tail.bytes());
    file_.seal();
    file_.publish(overwrite_);
  }

  std::uint64_t bytes() const override { return file_.size(); }

 private:
  static constexpr std::uint64_t kMost16 = 0xffff;
  static constexpr std::uint64_t kMost32 = 0xffffffff;
  static constexpr std::uint64_t kVersion = 45;
  static constexpr std::uint64_t kUtf8 = 1 << 11;
  static constexpr std::uint64_t kFirstDay = 0x21;

  struct Entry {
    std::string key;
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
    std::uint64_t crc = 0;
  };

  static std::vector<std::uint8_t> central_record(const Entry& entry) {
    const bool is_far = entry.offset >= kMost32;
    ZipRecord record;
    record.u32(0x02014b50).u16(kVersion | 3 << 8).u16(kVersion).u16(kUtf8).u16(0);
    record.u16(0).u16(kFirstDay).u32(entry.crc).u32(entry.length).u32(entry.length);
    record.u16(entry.key.size()).u16(is_far ? 12 : 0).u16(0).u16(0).u16(0);
    record.u32(std::uint64_t{0100644} << 16).u32(is_far ? kMost32 : entry.offset).text(entry.key);
    if (is_far) record.u16(1).u16(8).u64(entry.offset);
    return record.bytes();
  }

  bool overwrite_;
  PendingFile file_;
  std::vector<Entry> entries_;
};

}  // namespace

std::unique_ptr<ZarrOutput> make_zarr_folder(Storage& storage, const std::string& path,
                                             bool overwrite) {
  return std::make_unique<ZarrFolder>(storage, path, overwrite);
}

std::unique_ptr<ZarrOutput> make_zarr_zip(Storage& storage, const std::string& path,
                                          bool overwrite) {
  return std::make_unique<ZarrZip>(storage, path, overwrite);
}

}  // namespace octavo
