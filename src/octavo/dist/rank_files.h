// The files that the ranks of a job have open, and what earlier jobs left in them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "octavo/dist/build_plan.h"
#include "octavo/dist/communicator.h"
#include "octavo/dist/rank_journal.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

struct RankFiles {
  std::unique_ptr<StorageFile> growing;  ///< one for all ranks; the first one has it locked
  std::unique_ptr<RankJournal> journal;
  PlacedGroups groups;                   ///< of earlier jobs, that this rank brings to their places
  std::int64_t first_group = 0;          ///< that is not whole
  std::uint64_t first_byte = 0;          ///< where its level 0 begins
};

/// Collective: opens them, and finds how far earlier jobs came.
/// discards  what they left is removed
/// Throws    Error{io} where another job works on the file, or where ranks see different folders;
///           as whole_groups
RankFiles open_rank_files(Communicator& ranks, Storage& storage, const std::string& path,
                          const BuildPlan& plan, const Levels& levels, const JournalHead& head,
                          bool discards);

/// Removes all that the ranks of a job had open, once the file has its name.
void remove_journals(Storage& storage, const std::string& path) noexcept;

}  // namespace octavo
