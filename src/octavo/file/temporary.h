// The names under which files grow until they are complete: ".NAME.tmp-PID" beside the final name,
// with ".NAME.tmp-PID.journal" where a build keeps a journal.
#pragma once

#include <memory>
#include <string>

#include "octavo/file/storage.h"

namespace octavo {

/// File systems allow no longer names.
inline constexpr std::size_t kMaxNameBytes = 255;

inline constexpr const char* kJournalEnding = ".journal";

/// The part before the process number: ".NAME.tmp-" in the folder of `path`. A long name is cut so
/// that the whole fits into kMaxNameBytes, and ends in a checksum of all of it.
std::string temporary_prefix(const std::string& path);

/// A file or folder that grows, locked while `file` lives.
struct TemporaryFile {
  std::string path;
  std::unique_ptr<StorageFile> file;
};

/// A new file for what will be `path`. Those that killed processes left behind for the same name
/// are removed first.
/// Throws Error{io}
TemporaryFile create_temporary(Storage& storage, const std::string& path);

/// The same with a new folder.
TemporaryFile create_temporary_folder(Storage& storage, const std::string& path);

}  // namespace octavo
