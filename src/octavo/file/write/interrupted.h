// What an interrupted build left behind: the growing file and its journal.
//
// Their lock tells a build that ended from one that runs; what is whole in both is proven, byte by
// byte, before anything continues behind it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/journal.h"

namespace octavo {

/// Both files, open and locked.
struct InterruptedBuild {
  std::unique_ptr<StorageFile> file;     ///< that was to become the .8vo file
  std::unique_ptr<StorageFile> journal;
  JournalHead head;
};

/// The interrupted builds of what was to be `path`, of which at least a head is whole. Those of
/// programs that still run are left out, as are growing files without a journal.
/// held    when given, gets the growing files that another program has locked, or that this one may
///         not lock and write
/// Throws  Error{io}
std::vector<InterruptedBuild> find_interrupted(Storage& storage, const std::string& path,
                                               std::vector<std::string>* held = nullptr);

/// Removes the interrupted builds of `path`. What cannot be removed stays.
void discard_interrupted(Storage& storage, const std::string& path) noexcept;

/// The CRC-32C of bytes begin .. end of a file, continued from `crc`. Throws Error{io, truncated}
std::uint32_t crc_of(const StorageFile& file, std::uint64_t begin, std::uint64_t end,
                     std::uint32_t crc);

/// True when a group follows `before` as the writer would have made it.
bool follows(const JournalGroup& group, const JournalGroup& before, const Levels& levels);

/// The groups that are whole in the journal and in the growing file, both of which are read.
/// levels  of the volume
/// Throws  Error{io}
std::vector<WholeGroup> proven_groups(const StorageFile& file, const StorageFile& journal,
                                      const Levels& levels);

/// The same, with the levels of the build itself; none where its header cannot be understood.
std::vector<WholeGroup> proven_groups(const InterruptedBuild& build);

/// Keeps what interrupted builds of `path` have encoded from being lost.
/// Throws  Error{io} when some of it is whole
void reject_interrupted(Storage& storage, const std::string& path);

/// Keeps two programs from working on the same file.
/// Throws  Error{io} when one has a growing file and journal of `path` locked
void reject_running(Storage& storage, const std::string& path);

/// Lines "NAME: VALUE" of what a header says of the volume, for JournalHead::settings.
std::string settings_of(const FileHeader& header);

/// The first thing in which a build differs from one that it shall continue, stored against now.
/// Returns  nothing when they are alike; Error{source_rejected} when only the first voxels differ,
///          else Error{invalid_argument}
std::optional<Error> difference_of(const JournalHead& stored, const JournalHead& now);

/// The planes in the first `layers` brick layers of tier 0.
std::int64_t planes_in(const Levels& levels, std::int64_t layers);

/// "planes 0 to 127 of 300".
std::string planes_text(std::int64_t first, std::int64_t end, std::int64_t count);

}  // namespace octavo
