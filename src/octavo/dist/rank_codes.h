// An octree condensed by ranks, as the thesis does it.
//
//   rank r    condenses runs of 2^p planes alone: levels 0 .. p
//   step 1    codes of level p go up by the plan, and are condensed there: levels p + 1 .. n
//   step 2    harvest: the lists of levels below p follow the same way, merged level by level
//
// Invariants
//   The octree at rank 0 is that of PlaneCondenser over all planes.
//
// Source  thesis 2.6, 2.7, Fig. 2.8 to 2.10
#pragma once

#include <cstdint>
#include <functional>

#include "octavo/core/box.h"
#include "octavo/core/progress.h"
#include "octavo/dist/communicator.h"
#include "octavo/dist/gather.h"
#include "octavo/dist/rank_report.h"
#include "octavo/octree/condense.h"

namespace octavo {

/// The planes of a rank.
struct CondensedPlanes {
  Size3 size;  ///< of the volume
  std::function<void(std::int64_t first, std::int64_t end)> seek;
  /// Gives the next plane to a condenser.
  std::function<void(PlaneCondenser&)> add_next;
};

/// p: as many planes as leave a run for each rank, if there are so many.
int run_level(std::int64_t planes, int ranks);

/// Collective: the octree at rank 0; without leaves at the others.
/// background  as CondenseOptions; homogeneous is equal
/// report      when given, gets at rank 0 what the ranks sent and held, in codes
/// Throws      as PlaneCondenser, Communicator::send and what gives the planes; Error{cancelled}
LinearOctree condense_by_ranks(const CondensedPlanes& planes,
                               std::optional<std::int64_t> background, Communicator& ranks,
                               GatherPlan plan, Progress& progress, RankReport* report = nullptr);

}  // namespace octavo
