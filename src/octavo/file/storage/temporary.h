// The names under which files grow until they are complete: ".NAME.tmp-PID" beside the final name,
// or ".NAME.tmp-PID-N" where that is taken, and ".journal" behind it where a build keeps a journal.
//
// Whoever works on such a file has it locked, and its journal. One that nobody has locked was left
// behind, whatever process has its number by now.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

/// File systems allow no longer names.
inline constexpr std::size_t kMaxNameBytes = 255;

inline constexpr const char* kJournalEnding = ".journal";

/// ".NAME" in the folder of `path`, for names that have up to `longest_ending` bytes more. A long
/// name is cut so that the whole fits into kMaxNameBytes, and ends in a checksum of all of it.
std::string hidden_prefix(const std::string& path, std::size_t longest_ending);

/// The part before the process number: ".NAME.tmp-" as a hidden_prefix.
std::string temporary_prefix(const std::string& path);

/// What stands at `path` is called so while another thing takes its place: ".NAME.tmp-earlier". It
/// may be all there is, so no temporary_type knows it; whoever replaces `path` next settles it.
std::string earlier_name(const std::string& path);

enum class TemporaryType { growing, journal };

/// What is called prefix + `ending`: PID, PID-N, or the journal of one. Nothing for any other
/// ending: such a name was not made here.
std::optional<TemporaryType> temporary_type(std::string_view ending);

/// What grows or is left behind in the folder of `path` for its name, journals included.
/// Throws Error{io}
std::vector<std::string> list_temporaries(Storage& storage, const std::string& path);

/// A name of that kind, of this process, which nothing has.
/// Throws Error{io}
std::string free_temporary_name(Storage& storage, const std::string& path);

/// A file or folder that grows, locked while `file` lives.
struct TemporaryFile {
  std::string path;
  std::unique_ptr<StorageFile> file;
};

/// A new file for what will be `path`, open to nobody to whom a file that stands at `target` is
/// not. What was left behind for the same name is removed first.
/// Throws Error{io}
TemporaryFile create_temporary(Storage& storage, const std::string& path,
                               const std::string& target);
/// The same where the file at `path` is replaced.
TemporaryFile create_temporary(Storage& storage, const std::string& path);

/// The same with a new folder.
TemporaryFile create_temporary_folder(Storage& storage, const std::string& path);

/// A failure of `kind` in other words, about the same place and options as `error`.
Error retold(const Error& error, ErrorKind kind, const std::string& detail,
             const std::string& path);

/// `error` with the name that was asked for, where it carries the temporary one of `path`.
Error with_final_name(const Error& error, const std::string& path);

/// Makes what just took the name `path` durable there.
/// Throws Error{io} that names `path` and says that the new one stands there
void sync_new_name(Storage& storage, const std::string& path);

/// The same; a file that did not replace another is taken away again where that fails.
void settle_new_name(Storage& storage, const std::string& path, bool has_replaced);

/// Removes a file on the way out of a failure; a second failure is not reported.
void remove_quietly(Storage& storage, const std::string& path) noexcept;

}  // namespace octavo
