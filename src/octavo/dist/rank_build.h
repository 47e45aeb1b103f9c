// A build by ranks that share a file system: each writes its groups straight into the file.
//
//   round 0      group 0    group 1    ..   group P-1     rank r encodes group i * P + r
//   round 1      group P    group P+1  ..
//     ..         the sum of what ranks before it have encoded gives each its place: level 0 is
//                written once, in place, while the next group is read, trained on and encoded
//   top codes    a sample per brick, and what the index needs, go to rank 0 by a gather plan
//   the rest     coarser levels, which waited in the ranks' journals, go to their places
//   seal         rank 0: coarse tiers, index, header, name
//
// Invariants
//   The file is that of build_file, byte for byte, at any number of ranks.
//   Its name holds a whole file or none.
// Consequences
//   What a job that was interrupted left is continued by one of any other number of ranks: from the
//   longest run of whole groups on, beginning with the first.
//
// Source  thesis 2.6 to 2.9: rank 0 is the farmer, and worker like the others
#pragma once

#include <string>

#include "octavo/dist/build_plan.h"
#include "octavo/dist/communicator.h"
#include "octavo/dist/gather.h"
#include "octavo/dist/parts.h"
#include "octavo/dist/rank_report.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

struct RankBuildOptions {
  GatherPlan gather = GatherPlan::tree;
  bool overwrite = false;
  bool discards_interrupted = false;  ///< otherwise what a job left of the file is continued
  PartWork work = {};                 ///< of each rank
};

/// Proves that ranks have room for whole groups of `source`.
/// Throws Error{limit_exceeded}
void require_rank_memory(const PlaneSource& source, double max_error, const PartWork& work);

/// Collective: builds `path` by the plan, which all ranks have alike.
/// source   of this rank; read at its groups alone
/// storage  in which all ranks see the same files
/// report   when given, gets at rank 0 what the ranks sent, held and did
/// Returns  at rank 0 as build_file, with the clipped voxels of the planes that this job read; at
///          the others without what they do not know
/// Throws   as build_part and FileWriter, and Error{io} where ranks do not share the folder of the
///          file or another job works on it; nothing stands under `path` then, and what is whole is
///          kept for the next job
/// Memory   as build_file and two encoded groups
BuildResult build_by_ranks(const BuildPlan& plan, PlaneSource& source, Communicator& ranks,
                           Storage& storage, const std::string& path,
                           const RankBuildOptions& options, Progress& progress,
                           RankReport* report = nullptr);

}  // namespace octavo
