// A file put together of what a layout of a join says.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "octavo/dist/join_steps.h"
#include "support/memory_storage.h"

namespace octavo::testing {

struct LaidOutFile {
  std::vector<std::uint8_t> file;
  std::uint64_t bytes = 0;  ///< that were put into it
};

/// Own bytes of the file at `path` come from where it is joined, the others from parts.
/// name_of  of the place of a part
template <class NameOf>
LaidOutFile laid_out_file(const JoinLayout& layout, const MemoryStorage& storage,
                          const std::string& path, NameOf&& name_of) {
  LaidOutFile made{std::vector<std::uint8_t>(layout.file_bytes)};
  const auto put = [&](const std::vector<std::uint8_t>& from, std::uint64_t at,
                       std::uint64_t length, std::uint64_t to) {
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(at), length,
                made.file.begin() + static_cast<std::ptrdiff_t>(to));
    made.bytes += length;
  };
  const std::vector<std::uint8_t>& hollow = *storage.files.at(joined_name(path));
  for (const Section& own : own_bytes_of(layout)) put(hollow, own.offset, own.length, own.offset);
  for (const CopiedRun& run : layout.runs) {
    put(*storage.files.at(name_of(run.part)), run.part_offset, run.length, run.file_offset);
  }
  return made;
}

}  // namespace octavo::testing
