// What ranks sent, held and did, to be set beside the model of the thesis (2.8, 2.9).
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/levels.h"
#include "octavo/dist/communicator.h"
#include "octavo/dist/gather.h"

namespace octavo {

/// A level of the volume or of its octree.
struct LevelTraffic {
  int level = 0;
  std::uint64_t codes = 0;  ///< of the whole
  std::uint64_t sent = 0;   ///< from rank to rank; one that is passed on counts again
};

/// The part of one rank in the work.
struct RankShare {
  std::uint64_t units = 0;          ///< groups or planes
  std::uint64_t top_codes = 0;      ///< that it gave
  std::uint64_t message_bytes = 0;  ///< that it sent, those passed on included
  std::uint64_t held = 0;           ///< beside the result: bytes of a build, codes of an octree
  double processor_seconds = 0;
};

struct RankReport {
  GatherPlan gather = GatherPlan::tree;
  std::vector<LevelTraffic> levels;
  std::vector<RankShare> ranks;

  /// Of all levels: B in the thesis.
  std::uint64_t codes() const;
  std::uint64_t codes_sent() const;
  /// Over all messages of the gather.
  std::uint64_t bytes_sent() const;
  std::uint64_t held() const;
  /// The work of all over that of the busiest: what P machines would gain.
  double speed_up() const;
};

/// How often what a rank gives is sent until rank 0 has it.
int hop_count(GatherPlan plan, int rank, int size);

/// Collective: the shares of all ranks, at rank 0.
std::vector<RankShare> collect_shares(Communicator& ranks, const RankShare& own);

/// Processor time of this process so far, and of those it has waited for.
double processor_seconds();

}  // namespace octavo
