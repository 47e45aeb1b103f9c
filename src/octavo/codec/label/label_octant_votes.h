// What the visited children of an octant say, and what follows from it for the others. A child has
// as many votes as voxels lie below it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace octavo {

class LabelOctant {
 public:
  /// An octant of `child_count` children that together weigh `weight`; `labels` gives the label of
  /// a slot.
  LabelOctant(std::uint32_t parent, int child_count, std::int64_t weight,
              const std::vector<std::int64_t>& labels)
      : labels_(labels), parent_(parent), left_(child_count), room_(weight) {}

  std::uint32_t parent() const { return parent_; }
  /// The weight of children with the parent's label or not visited yet, the one being visited left
  /// out.
  std::int64_t room() const { return room_; }
  /// Visited children without the parent's label.
  int others() const { return others_; }
  /// All visited children are uniform and have the parent's label.
  bool is_one() const { return is_one_; }
  /// Children not visited yet, the one being visited left out.
  int left() const { return left_; }

  /// The next child is visited.
  void enter(std::int64_t weight) {
    --left_;
    weight_ = weight;
    room_ -= weight;
  }
  void leave(std::uint32_t slot, bool is_uniform) {
    if (slot == parent_) {
      room_ += weight_;
      is_one_ = is_one_ && is_uniform;
    } else {
      is_one_ = false;
      count(slot);
    }
  }

  /// True when the parent's label can no longer win the vote without the child being visited.
  [[gnu::always_inline]] bool must_be_same() const {
    if (room_ == 0) return true;
    for (std::size_t i = 0; i < other_count_; ++i) {
      if (wins(votes_[i], other_[i])) return true;
    }
    return false;
  }

  /// As must_be_same where a brick has slots 0 and 1 alone.
  [[gnu::always_inline]] bool is_pair_decided() const {
    return wins(other_votes_ + weight_, 1 - parent_);
  }

  /// True when the child being visited would, with the label of `slot`, outvote the parent.
  [[gnu::always_inline]] bool is_excluded(std::uint32_t slot) const {
    std::int64_t votes = weight_;
    for (std::size_t i = 0; i < other_count_; ++i) {
      if (other_[i] == slot) votes += votes_[i];
    }
    return wins(votes, slot);
  }

 private:
  /// True when `votes` for `slot` beat all that the parent can still get from other children.
  [[gnu::always_inline]] bool wins(std::int64_t votes, std::uint32_t slot) const {
    return votes > room_ || (votes == room_ && labels_[slot] < labels_[parent_]);
  }

  void count(std::uint32_t slot) {
    ++others_;
    other_votes_ += weight_;
    for (std::size_t i = 0; i < other_count_; ++i) {
      if (other_[i] == slot) {
        votes_[i] += weight_;
        return;
      }
    }
    other_[other_count_] = slot;
    votes_[other_count_++] = weight_;
  }

  const std::vector<std::int64_t>& labels_;
  std::uint32_t parent_;
  int left_;
  int others_ = 0;
  std::int64_t room_;
  std::int64_t other_votes_ = 0;
  std::int64_t weight_ = 0;  ///< of the child being visited
  bool is_one_ = true;
  std::size_t other_count_ = 0;
  std::array<std::uint32_t, 8> other_;  ///< the other labels met; only other_count_ hold anything
  std::array<std::int64_t, 8> votes_;   ///< and what the children with them weigh
};

}  // namespace octavo
