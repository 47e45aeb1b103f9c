// Which samples around a child count as its neighbors, and the labels they propose for it.
//
// Neighbors are named as seen from the child's place in its octant: along each axis +1 is away from
// its siblings, -1 towards them. So one set of weights serves all eight places as far as geometry
// goes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/codec/label_grid.h"
#include "octavo/codec/label_net.h"

namespace octavo {

/// Offsets from a child to its neighbors, by digit and neighbor. Neighbors 0 .. 25 are the cube of
/// 3^3 around it, x fastest and -1 before 0 before 1, the centre left out; 26 .. 31 are two steps
/// away: -x, +x, -y, +y, -z, +z.
using LabelNeighborhood = std::array<std::array<std::ptrdiff_t, kLabelNeighbors>, 8>;
LabelNeighborhood label_neighborhood(std::ptrdiff_t row_stride, std::ptrdiff_t plane_stride);

/// How much a neighbor's label counts as a proposal.
int label_vote(std::size_t neighbor, LabelState state);

/// The distinct labels proposed for one child, by falling votes; of equal votes, the first
/// proposed.
class LabelCandidates {
 public:
  void add(std::uint32_t slot, int votes) {
    for (int i = 0; i < count_; ++i) {
      Candidate& known = list_[static_cast<std::size_t>(i)];
      if (known.slot == slot) {
        known.votes += votes;
        return;
      }
    }
    list_[static_cast<std::size_t>(count_++)] = {slot, votes};
  }

  template <class Predicate>
  void drop_if(Predicate&& predicate) {
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      const Candidate candidate = list_[static_cast<std::size_t>(i)];
      if (!predicate(candidate.slot)) list_[static_cast<std::size_t>(kept++)] = candidate;
    }
    count_ = kept;
  }

  void sort();

  int count() const { return count_; }
  std::uint32_t slot(int i) const { return list_[static_cast<std::size_t>(i)].slot; }

  /// The share of candidate i in the votes of those from i on, in eighths, 7 for all of them.
  int share(int i) const;

 private:
  struct Candidate {
    std::uint32_t slot = 0;
    int votes = 0;
  };

  std::array<Candidate, kLabelNeighbors> list_{};
  int count_ = 0;
};

}  // namespace octavo
