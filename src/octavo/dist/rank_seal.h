// The end of a build by ranks: what waits goes to its place, and rank 0 seals the file.
#pragma once

#include <string>

#include "octavo/builder/workers.h"
#include "octavo/dist/rank_build.h"
#include "octavo/dist/rank_files.h"
#include "octavo/dist/rank_report.h"

namespace octavo {

/// What all steps of a rank see.
struct RankJob {
  const BuildPlan& plan;
  const BuildOutline& outline;
  const FileHeader& header;
  Communicator& ranks;
  Storage& storage;
  const std::string& path;
  const RankBuildOptions& options;
  Progress& progress;
  RankShare& share;
};

/// Collective: seals the file and gives it its name, once level 0 of all groups stands in it.
/// first_model  as GroupTrainer::first
/// groups       those of this rank
/// result       gets, at rank 0, what is known of the file
void seal_by_ranks(const RankJob& job, Workers& workers, const Model& first_model,
                   const CodecSettings& settings, RankFiles& files, const PlacedGroups& groups,
                   BuildResult& result);

}  // namespace octavo
