// What is known around a child, in plain C++: the reference for every instruction set.
#pragma once

#include <algorithm>
#include <bit>
#include <string>

#include "octavo/codec/encoders.h"
#include "octavo/codec/label/label_contexts.h"
#include "octavo/codec/label/label_octant.h"
#include "octavo/codec/label/label_octant_votes.h"
#include "octavo/codec/label/label_walk.h"

namespace octavo::portable {

class Around {
 public:
  Around(const LabelCell*, const LabelNeighborhood& offsets, std::uint32_t parent)
      : offsets_(offsets), parent_(parent) {}
  void see(const LabelCell* cell, std::size_t digit) {
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) near_[i] = cell[offsets_[digit][i]];
    aim(parent_);
  }
  void aim(std::uint32_t slot) {
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      const bool is_equal = slot_of(near_[i]) == slot;
      question_.neighbor[i] = static_cast<std::uint8_t>(2 * state_of(near_[i]) + is_equal);
    }
  }
  void flip() {
    for (std::uint8_t& code : question_.neighbor) code ^= 1;
  }
  int logit(const LabelNet& net, std::size_t first, std::size_t second) const {
    LabelQuestion question = question_;
    question.first = static_cast<std::uint8_t>(first);
    question.second = static_cast<std::uint8_t>(second);
    return label_logit(net, question);
  }
  bool propose(LabelCandidates& candidates) const {
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      if (state_of(near_[i]) == kOutside || slot_of(near_[i]) == parent_) continue;
      candidates.add(slot_of(near_[i]), label_vote(i, state_of(near_[i])));
    }
    return candidates.count() == 1;
  }
  void settle(std::size_t, LabelCell) {}
  void tell(LabelQuestion& question) const { question.neighbor = question_.neighbor; }

 private:
  const LabelNeighborhood& offsets_;
  std::uint32_t parent_;
  std::array<LabelCell, kLabelNeighbors> near_{};
  LabelQuestion question_{};
};

}  // namespace octavo::portable
