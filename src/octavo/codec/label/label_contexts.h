// Which samples around a child count as its neighbors, and the labels they propose for it.
//
// Neighbors are named as seen from the child's place in its octant: along each axis +1 is away from
// its siblings, -1 towards them. So one set of weights serves all eight places as far as geometry
// goes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/codec/label/label_grid.h"
#include "octavo/codec/label/label_net.h"

namespace octavo {

/// Offsets from a child to its neighbors, by digit and neighbor. The eight rows of three around the
/// row of the child, by rising z, then y, then x, are neighbors 0 .. 11 and 16 .. 27; 12 .. 15 are
/// -2, -1, +1, +2 along x, 28 .. 31 are -2 and +2 along y, -2 and +2 along z.
using LabelNeighborhood = std::array<std::array<std::ptrdiff_t, kLabelNeighbors>, 8>;
LabelNeighborhood label_neighborhood(std::ptrdiff_t row_stride, std::ptrdiff_t plane_stride);

namespace detail {

/// Votes of an exactly known neighbor: one that shares a face, an edge or a corner counts 12, 5 or
/// 3, one two steps away 2.
inline constexpr std::array<std::uint8_t, kLabelNeighbors> kLabelVotes = {
    3, 5, 3, 5, 12, 5, 3, 5, 3, 5, 12, 5, 2, 12, 12, 2,
    5, 12, 5, 3, 5, 3, 5, 12, 5, 3, 5, 3, 2, 2, 2, 2};

}  // namespace detail

/// How much a neighbor's label counts as a proposal.
constexpr int label_vote(std::size_t neighbor, LabelState state) {
  const int exact = detail::kLabelVotes[neighbor];
  return state == kParent ? (exact + 1) / 2 : exact;
}

/// The distinct labels proposed for one child, by falling votes; of equal votes, the smaller slot.
class LabelCandidates {
 public:
  /// Adds votes for a slot.
  void add(std::uint32_t slot, int votes) {
    for (std::size_t i = 0; i < count_; ++i) {
      if (list_[i].slot == slot) {
        list_[i].votes += votes;
        return;
      }
    }
    append(slot, votes);
  }
  /// Adds votes for a slot that has none yet.
  void append(std::uint32_t slot, int votes) { list_[count_++] = {slot, votes}; }

  template <class Predicate>
  void drop_if(Predicate&& predicate) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (!predicate(list_[i].slot)) list_[kept++] = list_[i];
    }
    count_ = kept;
  }

  void sort() {
    for (std::size_t i = 1; i < count_; ++i) {
      const Candidate candidate = list_[i];
      std::size_t place = i;
      for (; place > 0 && is_before(candidate, list_[place - 1]); --place) {
        list_[place] = list_[place - 1];
      }
      list_[place] = candidate;
    }
  }

  std::size_t count() const { return count_; }
  std::uint32_t slot(std::size_t i) const { return list_[i].slot; }

  /// The share of candidate i in the votes of those from i on, in eighths, 7 for all of them.
  int share(std::size_t i) const {
    int left = 0;
    for (std::size_t j = i; j < count_; ++j) left += list_[j].votes;
    return std::min(8 * list_[i].votes / left, 7);
  }

 private:
  struct Candidate {
    std::uint32_t slot;
    int votes;
  };

  static bool is_before(const Candidate& a, const Candidate& b) {
    return a.votes > b.votes || (a.votes == b.votes && a.slot < b.slot);
  }

  std::array<Candidate, kLabelNeighbors> list_;  // only the first count_ hold anything
  std::size_t count_ = 0;
};

}  // namespace octavo
