// What tells that a file of a source was changed: its length and when it was last written.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace octavo {

struct SourceStamp {
  std::string path;
  std::int64_t bytes = 0;
  std::int64_t written_ns = 0;  ///< since 1970, by the clock of whoever wrote it

  bool operator==(const SourceStamp&) const = default;
};

/// The stamps of files, in their order. Throws Error{io} that names a file that is not there.
std::vector<SourceStamp> stamps_of(const std::vector<std::string>& paths);

/// Times are compared with times, never with a clock of here.
/// Throws  Error{source_rejected} that names the first file that is no longer as it was, with both
///         lengths and times; Error{io}
void require_unchanged(const std::vector<SourceStamp>& stamps);

}  // namespace octavo
