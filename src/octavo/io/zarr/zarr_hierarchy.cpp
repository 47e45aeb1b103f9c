#include "octavo/io/zarr/zarr_hierarchy.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <system_error>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/io/source/header_bytes.h"

namespace octavo {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kMostTextBytes = std::uint64_t{16} << 20;

class FolderHierarchy final : public ZarrHierarchy {
 public:
  explicit FolderHierarchy(const std::string& path)
      : ZarrHierarchy(path), root_(fs::canonical(path)) {}

  std::optional<ZarrFile> open(const std::string& key) const override {
    const std::string place = path() + "/" + key;
    std::error_code failure;
    const fs::path real = fs::canonical(place, failure);
    const bool is_absent = failure == std::errc::no_such_file_or_directory ||
                           failure == std::errc::not_a_directory;
    if (is_absent) return std::nullopt;
    if (failure) throw Error(ErrorKind::io, "cannot examine: " + failure.message(), place);
    if (is_folder(place)) reject(place, "is a folder, and a file was expected");
    if (std::mismatch(root_.begin(), root_.end(), real.begin(), real.end()).first !=
        root_.end()) {
      reject(place, "is a link that leads out of the folder");
    }
    auto file = std::make_shared<const SourceFile>(place);
    const std::uint64_t size = file->size();
    return ZarrFile(std::move(file), 0, size);
  }

  std::vector<std::string> files(const std::string& folder) const override {
    const std::string place = folder.empty() ? path() : path() + "/" + folder;
    return is_folder(place) ? files_in_folder(place, true) : std::vector<std::string>{};
  }

 private:
  fs::path root_;
};

// Source  PKWARE .ZIP File Format Specification 6.3.10, sections 4.3.7 to 4.3.16
constexpr std::uint32_t kLocalMagic = 0x04034b50;
constexpr std::uint32_t kEntryMagic = 0x02014b50;
constexpr std::uint32_t kEndMagic = 0x06054b50;
constexpr std::uint32_t kWideEndMagic = 0x06064b50;
constexpr std::uint32_t kWidePlaceMagic = 0x07064b50;
constexpr std::size_t kLocalBytes = 30;
constexpr std::size_t kEntryBytes = 46;
constexpr std::size_t kEndBytes = 22;
constexpr std::size_t kWideEndBytes = 56;
constexpr std::size_t kWidePlaceBytes = 20;
constexpr std::size_t kMostCommentBytes = 65535;
constexpr std::uint64_t kMostDirectoryBytes = std::uint64_t{1} << 30;
constexpr std::uint16_t kWideField = 1;
constexpr std::uint64_t kProvenAtOnceBytes = std::uint64_t{1} << 20;

/// A file in the zip file: where its local header stands.
struct ZipEntry {
  std::uint64_t header_offset = 0;
  std::uint64_t size = 0;
  std::uint32_t crc = 0;
  std::shared_ptr<std::once_flag> is_proven = std::make_shared<std::once_flag>();
};

/// Where the directory of a zip file stands.
struct ZipDirectory {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t entry_count = 0;
  /// Of the bits of that number that stand there: older files hold 16 of them.
  std::uint64_t entry_count_mask = ~std::uint64_t{0};
};

std::vector<std::byte> bytes_at(const SourceFile& file, std::uint64_t offset, std::size_t count) {
  std::vector<std::byte> bytes(count);
  if (offset > file.size() || count > file.size() - offset) {
    reject(file.path(), "is damaged: the directory of the zip file points behind its end");
  }
  file.read_exactly(offset, bytes);
  return bytes;
}

ZipDirectory find_directory(const SourceFile& file) {
  const std::size_t count = static_cast<std::size_t>(
      std::min<std::uint64_t>(file.size(), kEndBytes + kMostCommentBytes));
  const std::uint64_t start = file.size() - count;
  const std::vector<std::byte> tail = bytes_at(file, start, count);
  const HeaderBytes bytes(tail, false);
  std::size_t end = count + 1;
  for (std::size_t at = count < kEndBytes ? 0 : count - kEndBytes + 1; at-- > 0;) {
    if (bytes.at<std::uint32_t>(at) != kEndMagic) continue;
    if (at + kEndBytes + bytes.at<std::uint16_t>(at + 20) != count) continue;
    end = at;
    break;
  }
  if (end > count) reject(file.path(), "is no zip file, or is cut: its end is not there");
  ZipDirectory found{bytes.at<std::uint32_t>(end + 16), bytes.at<std::uint32_t>(end + 12),
                     bytes.at<std::uint16_t>(end + 10), 0xffff};
  if (start + end < kWidePlaceBytes) return found;
  const std::vector<std::byte> wide = bytes_at(file, start + end - kWidePlaceBytes,
                                               kWidePlaceBytes);
  const HeaderBytes place(wide, false);
  if (place.at<std::uint32_t>(0) != kWidePlaceMagic) return found;
  const std::vector<std::byte> record =
      bytes_at(file, place.at<std::uint64_t>(8), kWideEndBytes);
  const HeaderBytes last(record, false);
  if (last.at<std::uint32_t>(0) != kWideEndMagic) {
    reject(file.path(), "is damaged: the end of the zip file is not where it says");
  }
  return {last.at<std::uint64_t>(48), last.at<std::uint64_t>(40), last.at<std::uint64_t>(32)};
}

/// Takes sizes and offsets of 64 bits from the extra field of an entry.
void take_wide_numbers(const HeaderBytes& bytes, std::size_t from, std::size_t end,
                       std::uint64_t& packed, ZipEntry& entry) {
  constexpr std::uint32_t kIsWide = 0xffffffff;
  while (from + 4 <= end) {
    const std::size_t stop = from + 4 + bytes.at<std::uint16_t>(from + 2);
    if (bytes.at<std::uint16_t>(from) == kWideField && stop <= end) {
      std::size_t at = from + 4;
      for (std::uint64_t* const number : {&entry.size, &packed, &entry.header_offset}) {
        if (*number != kIsWide || at + 8 > stop) continue;
        *number = bytes.at<std::uint64_t>(at);
        at += 8;
      }
    }
    from = stop;
  }
}

class ZipHierarchy final : public ZarrHierarchy {
 public:
  explicit ZipHierarchy(const std::string& path)
      : ZarrHierarchy(path), file_(std::make_shared<const SourceFile>(path)) {
    const ZipDirectory place = find_directory(*file_);
    if (place.bytes > kMostDirectoryBytes) {
      reject(path, "the directory of the zip file is longer than 1 GiB");
    }
    const std::uint64_t count =
        read_directory(bytes_at(*file_, place.offset, static_cast<std::size_t>(place.bytes)));
    // A name that is damaged would leave a chunk out, which then has the fill value.
    if (((count ^ place.entry_count) & place.entry_count_mask) != 0) reject_damage();
    for (const auto& [name, entry] : entries_) start_of(name, entry);
  }

  std::optional<ZarrFile> open(const std::string& key) const override {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return std::nullopt;
    const ZipEntry& entry = found->second;
    const std::uint64_t start = start_of(key, entry);
    std::call_once(*entry.is_proven, [&] { prove(key, start, entry); });
    return ZarrFile(file_, start, entry.size);
  }

  std::vector<std::string> files(const std::string&) const override { return {path()}; }

 private:
  [[noreturn]] void reject_damage() const {
    reject(path(), "is damaged: the directory of the zip file does not fit its files");
  }

  /// Where the bytes of a file begin; its name stands in front of them once more.
  std::uint64_t start_of(const std::string& name, const ZipEntry& entry) const {
    const std::vector<std::byte> head =
        bytes_at(*file_, entry.header_offset, kLocalBytes + name.size());
    const HeaderBytes bytes(head, false);
    if (bytes.at<std::uint32_t>(0) != kLocalMagic ||
        bytes.at<std::uint16_t>(26) != name.size() ||
        std::memcmp(head.data() + kLocalBytes, name.data(), name.size()) != 0) {
      reject_damage();
    }
    const std::uint64_t start =
        entry.header_offset + head.size() + bytes.at<std::uint16_t>(28);
    if (start > file_->size() || entry.size > file_->size() - start) reject_damage();
    return start;
  }

  /// Reads a file once, as parts of it are read from then on.
  void prove(const std::string& name, std::uint64_t start, const ZipEntry& entry) const {
    std::vector<std::byte> block;
    uLong crc = 0;
    for (std::uint64_t at = 0; at < entry.size; at += block.size()) {
      block.resize(
          static_cast<std::size_t>(std::min<std::uint64_t>(kProvenAtOnceBytes, entry.size - at)));
      file_->read_exactly(start + at, block);
      crc = crc32(crc, reinterpret_cast<const Bytef*>(block.data()),
                  static_cast<uInt>(block.size()));
    }
    if (checksum_matches(static_cast<std::uint32_t>(crc), entry.crc)) return;
    reject(path() + "/" + name, "is damaged: its CRC-32 in the zip file is wrong");
  }

  /// Returns how many entries there are, folders among them.
  std::uint64_t read_directory(const std::vector<std::byte>& directory) {
    const HeaderBytes bytes(directory, false);
    std::uint64_t count = 0;
    for (std::size_t at = 0; at < directory.size();) {
      if (directory.size() - at < kEntryBytes || bytes.at<std::uint32_t>(at) != kEntryMagic) {
        reject_damage();
      }
      const std::size_t name_bytes = bytes.at<std::uint16_t>(at + 28);
      const std::size_t extra = at + kEntryBytes + name_bytes;
      const std::size_t extra_end = extra + bytes.at<std::uint16_t>(at + 30);
      const std::size_t end = extra_end + bytes.at<std::uint16_t>(at + 32);
      if (end > directory.size()) reject_damage();
      const std::string name(reinterpret_cast<const char*>(directory.data()) + at + kEntryBytes,
                             name_bytes);
      std::uint64_t packed = bytes.at<std::uint32_t>(at + 20);
      ZipEntry entry{bytes.at<std::uint32_t>(at + 42), bytes.at<std::uint32_t>(at + 24),
                     bytes.at<std::uint32_t>(at + 16)};
      take_wide_numbers(bytes, extra, extra_end, packed, entry);
      if (!name.ends_with('/')) add(name, entry, bytes.at<std::uint16_t>(at + 10), packed);
      at = end;
      ++count;
    }
    return count;
  }

  void add(const std::string& name, const ZipEntry& entry, std::uint16_t method,
           std::uint64_t packed) {
    if (method != 0 || packed != entry.size) {
      reject(path(), escaped(name) + " is compressed in the zip file, which OME-Zarr has as it "
                                     "is; pack it anew without (zip -0)");
    }
    if (!is_zarr_key(name)) reject(path(), escaped(name) + " is no name of a file of zarr");
    entries_[name] = entry;
  }

  std::shared_ptr<const SourceFile> file_;
  std::map<std::string, ZipEntry> entries_;
};

}  // namespace

std::vector<std::uint8_t> ZarrFile::read(std::uint64_t offset, std::uint64_t length) const {
  if (offset > size_ || length > size_ - offset) {
    reject(path(), "the file ends early: " + std::to_string(length) + " bytes from " +
                       std::to_string(offset) + " expected, its length is " +
                       std::to_string(size_));
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(length));
  file_->read_exactly(offset_ + offset, std::as_writable_bytes(std::span(bytes)));
  return bytes;
}

ZarrValue ZarrHierarchy::text(const std::string& key) const {
  const std::optional<ZarrFile> file = open(key);
  if (!file) return {};
  const std::string place = path() + "/" + key;
  if (file->size() > kMostTextBytes) {
    reject(place, "is longer than the 16 MiB that are read of a text of zarr");
  }
  const std::vector<std::uint8_t> bytes = file->read(0, file->size());
  return {std::string(bytes.begin(), bytes.end()), place};
}

bool is_zarr_folder(const std::string& path) {
  if (!is_folder(path)) return false;
  std::error_code failure;
  constexpr std::array kTexts = {"zarr.json", ".zgroup", ".zattrs", ".zarray"};
  return std::any_of(kTexts.begin(), kTexts.end(), [&](const char* name) {
    return fs::exists(fs::path(path) / name, failure);
  });
}

std::unique_ptr<ZarrHierarchy> open_zarr_hierarchy(const std::string& path) {
  if (is_folder(path)) return std::make_unique<FolderHierarchy>(path);
  return std::make_unique<ZipHierarchy>(path);
}

std::string key_in(const std::string& folder, const std::string& name) {
  return folder.empty() ? name : folder + "/" + name;
}

bool is_zarr_key(const std::string& key) {
  std::size_t from = 0;
  while (true) {
    const std::size_t slash = std::min(key.find('/', from), key.size());
    const std::string_view name = std::string_view(key).substr(from, slash - from);
    if (name.empty() || name == "." || name == ".." || name.find('\0') != name.npos) return false;
    if (slash == key.size()) return true;
    from = slash + 1;
  }
}

}  // namespace octavo
