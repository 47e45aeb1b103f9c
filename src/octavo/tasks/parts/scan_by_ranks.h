// A scan built by the ranks of a job, which write into one file.
#pragma once

#include "octavo/dist/communicator.h"
#include "octavo/dist/gather.h"
#include "octavo/dist/rank_report.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/files/scan_planes.h"

namespace octavo {

struct ScanByRanksOptions {
  BuildScanOptions scan;  ///< alike at all ranks, in folders that all see
  GatherPlan gather = GatherPlan::tree;
};

/// A file that was built, as rank 0 knows it.
struct BuiltByRanks {
  BuiltVolume built;
  RankReport report;
};

/// Collective: makes the file of build_scan, byte for byte. Rank 0 plans. What an earlier job left
/// of the same build is continued, and discarded where the output is to be overwritten. Where a
/// rank fails, the caller ends the others, which may wait for it.
/// Throws  as plan_in_memory and build_by_ranks
/// Memory  of each rank, as build_by_ranks
BuiltByRanks scan_by_ranks(const ScanByRanksOptions& options, Communicator& ranks,
                           const TaskContext& context);

}  // namespace octavo
