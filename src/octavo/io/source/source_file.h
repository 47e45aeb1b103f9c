// Files as sources read them: opened by exactly the name given, every read complete or an Error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace octavo {

/// A regular file open for reading. Movable; closes itself.
class SourceFile {
 public:
  /// Throws Error{io} when `path` is missing, unreadable or not a regular file.
  explicit SourceFile(const std::string& path);
  ~SourceFile();
  SourceFile(SourceFile&& other) noexcept;
  SourceFile& operator=(SourceFile&&) = delete;
  SourceFile(const SourceFile&) = delete;
  SourceFile& operator=(const SourceFile&) = delete;

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }

  /// Reads up to bytes.size() bytes at `offset`; returns how many there were. Throws Error{io}.
  /// Thread-safe.
  std::size_t read_some(std::uint64_t offset, std::span<std::byte> bytes) const;

  /// Fills `bytes` from `offset`. Throws Error{source_rejected} when the file ends earlier,
  /// Error{io}.
  /// Thread-safe.
  void read_exactly(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// Throws Error{source_rejected} that names the file.
[[noreturn]] void reject(const std::string& path, const std::string& why);

/// The first bytes of a file, at most `count`. Throws Error{io}.
std::vector<std::byte> file_head(const std::string& path, std::size_t count);

/// Regular files in a folder in natural order of their paths; links to files count, hidden names do
/// not.
/// recursive  goes into sub-folders, never through links to folders
/// Throws     Error{io} when the folder cannot be listed
std::vector<std::string> files_in_folder(const std::string& folder, bool recursive);

bool is_folder(const std::string& path);

/// The name behind the last '/'.
std::string base_name(const std::string& path);

/// The name in lower case; ASCII only.
std::string lower_case(std::string text);

/// True when the lower-case name ends in `ending` (given in lower case, with its dot).
bool has_ending(const std::string& path, const std::string& ending);

/// The path of the data file `name`, beneath the folder of `header` also where links are followed.
/// Throws Error{source_rejected} when `name` is absolute, empty, climbs with "..", leads out of the
/// folder by a link, is not there, or is no regular file.
std::string sibling_path(const std::string& header, const std::string& name);

}  // namespace octavo
