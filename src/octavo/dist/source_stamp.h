// What tells that a file of a source was changed: its length, and when it was last written or what
// it holds.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/progress.h"

namespace octavo {

/// What is looked at besides lengths.
enum class FileCheck {
  times,    ///< which copies may have lost
  content,  ///< all bytes, which are read for it
};

struct SourceStamp {
  std::string path;
  std::int64_t bytes = 0;
  std::int64_t written_ns = 0;       ///< since 1970, by the clock of whoever wrote it
  std::optional<std::uint32_t> crc;  ///< CRC-32C of all bytes, in place of the time, which is 0

  bool operator==(const SourceStamp&) const = default;
};

/// The stamps of files, in their order.
/// Throws Error{io} that names a file that is not there; Error{cancelled}
std::vector<SourceStamp> stamps_of(const std::vector<std::string>& paths);
std::vector<SourceStamp> stamps_of(const std::vector<std::string>& paths, FileCheck check,
                                   Progress& progress);

/// Files that are read as they were planned.
class UnchangedFiles {
 public:
  /// Times are compared with times, never with a clock of here.
  /// Throws  Error{source_rejected} that names the first file that is no longer as it was, with
  ///         both lengths and times; Error{io}; Error{cancelled}
  UnchangedFiles(const std::vector<SourceStamp>& planned, Progress& progress);
  /// Files as they are now. Throws as stamps_of
  explicit UnchangedFiles(const std::vector<std::string>& paths) : seen_(stamps_of(paths)) {}

  /// Proves by lengths and times that the same files are still there. Throws as the constructor
  void require_still() const;

 private:
  std::vector<SourceStamp> seen_;
};

}  // namespace octavo
