// A mask, a label map or a condensed volume as the leaves of an octree.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/option_words.h"
#include "octavo/core/volume.h"
#include "octavo/dist/communicator.h"
#include "octavo/dist/gather.h"
#include "octavo/dist/rank_report.h"
#include "octavo/octree/neighbors.h"
#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/task_context.h"
#include "octavo/tasks/value_ranges.h"

namespace octavo {

/// How o-codes are written: o_code.h.
enum class CodeNotation { mixed_octal, hierarchical };

constexpr auto option_words(CodeNotation) { return in_order<CodeNotation>("mixed", "linear"); }

struct CodesOptions {
  std::string input;  ///< an .8vo file or a URL of one
  int level = 0;      ///< whose samples are condensed
  AskedLabels labels = {};                ///< only these; with none: all but 0
  std::optional<AskedRange> range = {};   ///< the mask of these real values
  CodeNotation notation = CodeNotation::mixed_octal;
  /// The cube, in that notation or "-" for the root, whose neighbors are asked for.
  std::optional<std::string> neighbors_of = {};
  /// Memory that the caller takes for each leaf besides, counted against the limit.
  std::uint64_t bytes_per_leaf = 0;
};

/// What fills a cube, and what lies beside it in the order of kDirections.
struct CubeSurroundings {
  OCode cube;
  Neighbor filling;
  std::array<Neighbor, 26> neighbors;
};

struct CodesResult {
  VolumeDescription volume;  ///< of the level; of a mask without names of labels
  LinearOctree octree;
  std::optional<CubeSurroundings> surroundings;
};

/// Condenses a level: label maps by their tree, other voxels plane by plane. Background (0) gets no
/// leaf, except in a volume that condense_volume made.
/// Throws  as open_volume and what reading throws; Error{invalid_argument} for a level that is not
///         there, for label 0, for a name that no label has, for a grey volume without a range, for
///         a bad code; Error{limit_exceeded}
CodesResult codes(const CodesOptions& options, const TaskContext& context);

/// Collective: the same at rank 0 of a job, where every rank condenses planes of its own; at the
/// others without leaves.
/// report  as condense_by_ranks
CodesResult codes_by_ranks(const CodesOptions& options, Communicator& ranks, GatherPlan plan,
                           const TaskContext& context, RankReport* report = nullptr);

/// Leaves of each label, by level from 0 to the root.
std::map<std::int64_t, std::vector<std::int64_t>> leaves_by_label(const LinearOctree& octree);

/// Voxels under so many leaves of level 0, 1, ...
std::uint64_t voxels_under(const std::vector<std::int64_t>& leaves_by_level);

/// An o-code in text; "-" for the root where it has no digits.
std::string code_text(const OCode& cube, int root_level, CodeNotation notation);

}  // namespace octavo
