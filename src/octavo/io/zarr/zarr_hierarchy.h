// Where the files of a zarr hierarchy are read from: a folder, or one zip file of them (.ozx).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "octavo/io/source/source_file.h"
#include "octavo/io/zarr/zarr_value.h"

namespace octavo {

/// A file of a hierarchy, open for reading. Movable.
class ZarrFile {
 public:
  ZarrFile(std::shared_ptr<const SourceFile> file, std::uint64_t offset, std::uint64_t size)
      : file_(std::move(file)), offset_(offset), size_(size) {}

  const std::string& path() const { return file_->path(); }
  std::uint64_t size() const { return size_; }
  /// `length` bytes from `offset` on.
  /// Throws  Error{source_rejected} where there are fewer; Error{io}
  std::vector<std::uint8_t> read(std::uint64_t offset, std::uint64_t length) const;

 private:
  std::shared_ptr<const SourceFile> file_;
  std::uint64_t offset_;
  std::uint64_t size_;
};

/// Immutable; thread-safe.
class ZarrHierarchy {
 public:
  virtual ~ZarrHierarchy() = default;

  /// What it is called in messages.
  const std::string& path() const { return path_; }
  /// The file under a key; nothing where there is none.
  /// key     "0/c/1/2/3": names with slashes between, none of them "." or ".."
  /// Throws  Error{source_rejected} where it leads out of the folder by a link, or its checksum in
  ///         the zip file is wrong; Error{io}
  virtual std::optional<ZarrFile> open(const std::string& key) const = 0;
  /// The JSON under a key; a value that is not there where there is no such file.
  /// Throws  as open; Error{source_rejected} for what is no JSON, or longer than 16 MiB
  ZarrValue text(const std::string& key) const;
  /// Paths of all files that `folder` of the hierarchy is read from.
  virtual std::vector<std::string> files(const std::string& folder) const = 0;

 protected:
  explicit ZarrHierarchy(std::string path) : path_(std::move(path)) {}

 private:
  std::string path_;
};

/// True for folders that hold zarr.json, .zgroup, .zattrs or .zarray.
bool is_zarr_folder(const std::string& path);

/// A folder, or a zip file that is not compressed. Each file of a zip file is read once as a whole,
/// when it is first opened, and proven by its CRC-32.
/// Throws  Error{source_rejected} for a zip file that is damaged, compressed, or has names that
///         climb; Error{io}
/// Memory  of a zip file: that of its directory
std::unique_ptr<ZarrHierarchy> open_zarr_hierarchy(const std::string& path);

/// The key of a file in a folder of a hierarchy, which is empty where it is all of it.
std::string key_in(const std::string& folder, const std::string& name);

/// Whether `key` consists of names with slashes between that stay in the hierarchy.
bool is_zarr_key(const std::string& key);

}  // namespace octavo
