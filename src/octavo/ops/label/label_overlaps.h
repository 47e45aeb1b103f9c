// How many voxels two label maps have under each pair of labels.
//
// Two trees are visited side by side and entered where one of them has several labels; words are
// compared label by label, 64 voxels at a time.
//
// Source  thesis 1.2
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/octree/label_tree.h"

namespace octavo {

/// The voxels that have one label in a map and one in another.
struct LabelOverlap {
  std::int64_t first = 0;
  std::int64_t second = 0;
  std::uint64_t voxel_count = 0;

  bool operator==(const LabelOverlap&) const = default;
};

/// The pairs of labels that share voxels, 0 among them, ascending by the first and then by the
/// second. Uses the threads of the calling task arena; the result does not depend on their number.
/// Throws  Error{invalid_argument} when the maps differ in size
/// Memory  64 bytes per pair and thread
std::vector<LabelOverlap> label_overlaps(const LabelTree& a, const LabelTree& b);

/// How alike a label of one map and the same label of another are.
struct LabelAgreement {
  std::int64_t label = 0;
  std::uint64_t first_voxels = 0;   ///< in the first map
  std::uint64_t second_voxels = 0;  ///< in the second map
  std::uint64_t both_voxels = 0;

  bool operator==(const LabelAgreement&) const = default;

  /// Twice the voxels in both over the sum of the voxels of each (Dice 1945), 0..1.
  double dice() const {
    return 2 * static_cast<double>(both_voxels) /
           (static_cast<double>(first_voxels) + static_cast<double>(second_voxels));
  }
};

/// The labels other than 0 of two maps, ascending.
/// overlaps  all pairs of the maps
std::vector<LabelAgreement> label_agreements(const std::vector<LabelOverlap>& overlaps);

}  // namespace octavo
