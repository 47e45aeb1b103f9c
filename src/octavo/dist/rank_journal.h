// What ranks leave beside the growing file: a journal each, with the groups that stand whole.
//
//   .NAME.ranks            the growing file; who has it locked is the first rank of a job
//   .NAME.ranks-N.journal  a journal (file/write/journal.h) of a rank; no number is given twice
//                          while the growing file lives
//
// A journal's head says which plan it is of. Behind the streams of a run comes one of the squared
// errors of bricks, 8 bytes each.
//
// Invariants
//   A group stands in a journal when its level 0 stands in the growing file, at its place.
//   A group has the same bytes and the same place in whatever job it is made.
// Consequences
//   Journals of several jobs, of whatever numbers of ranks, together say what is whole; of a group
//   that stands in two of them either will do.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "octavo/core/levels.h"
#include "octavo/dist/build_plan.h"
#include "octavo/dist/group_sink.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/journal.h"

namespace octavo {

/// The growing file of ranks that build `path`.
std::string ranks_name(const std::string& path);

/// The numbers of its journals. Throws Error{io}
std::vector<std::int64_t> rank_journals(Storage& storage, const std::string& path);
std::string rank_journal_name(const std::string& path, std::int64_t number);

/// Where a group stands: level 0 in the growing file, its other streams in a journal.
struct PlacedGroup {
  JournalGroup group;  ///< offsets in the growing file
  std::vector<JournalBlock> blocks;
  std::shared_ptr<StorageFile> journal;

  std::uint64_t first_byte() const { return group.models.front().offset; }
};

/// By their numbers.
using PlacedGroups = std::map<std::int64_t, PlacedGroup>;

/// Hands the bytes of one of its streams but level 0 to `sink`.
void copy_stream(const PlacedGroup& group, std::size_t stream,
                 const std::function<void(ByteSpan)>& sink);
std::uint64_t stream_bytes(const PlacedGroup& group, std::size_t stream);
std::vector<double> squared_errors(const PlacedGroup& group, const Levels& levels);

/// The journal that a rank writes.
class RankJournal {
 public:
  /// Throws Error{io}
  RankJournal(Storage& storage, const std::string& path, std::int64_t number,
              const JournalHead& head);

  /// Writes level 0 to byte `first_byte` of the growing file, then the group.
  PlacedGroup place(const EncodedGroup& group, StorageFile& growing, std::uint64_t first_byte,
                    const Levels& levels);

 private:
  std::shared_ptr<Journal> journal_;
};

/// What a job of `plan` writes at the head of each of its journals.
JournalHead rank_head(const BuildPlan& plan, const BuildOutline& outline,
                      const FileHeader& header);

/// The groups of an earlier job's journal that stand whole: both files are read.
/// Throws  Error{io}; Error{invalid_argument, source_rejected} where it is of another plan
PlacedGroups whole_groups(Storage& storage, const std::string& path, std::int64_t number,
                          const StorageFile& growing, const BuildPlan& plan, const Levels& levels,
                          const JournalHead& head);

}  // namespace octavo
