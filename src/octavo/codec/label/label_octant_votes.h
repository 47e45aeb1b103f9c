// What the visited children of an octant say, and what follows from it for the others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace octavo {

class LabelOctant {
 public:
  /// An octant of `child_count` children; `labels` gives the label of a slot.
  LabelOctant(std::uint32_t parent, int child_count, const std::vector<std::int64_t>& labels)
      : labels_(labels), parent_(parent), left_(child_count), room_(child_count) {}

  std::uint32_t parent() const { return parent_; }
  /// Children with the parent's label or not visited yet, the one being visited left out.
  int room() const { return room_; }
  /// Visited children without the parent's label.
  int other_votes() const { return other_votes_; }
  /// All visited children are uniform and have the parent's label.
  bool is_one() const { return is_one_; }
  /// Children not visited yet, the one being visited left out.
  int left() const { return left_; }

  /// The next child is visited.
  void enter() {
    --left_;
    --room_;
  }
  void leave(std::uint32_t slot, bool is_uniform) {
    if (slot == parent_) {
      ++room_;
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
    return wins(other_votes_ + 1, 1 - parent_);
  }

  /// True when one more child of `slot` would outvote the parent.
  [[gnu::always_inline]] bool is_excluded(std::uint32_t slot) const {
    int votes = 1;
    for (std::size_t i = 0; i < other_count_; ++i) {
      if (other_[i] == slot) votes += votes_[i];
    }
    return wins(votes, slot);
  }

 private:
  /// True when `votes` for `slot` beat all that the parent can still get from other children.
  [[gnu::always_inline]] bool wins(int votes, std::uint32_t slot) const {
    return votes > room_ || (votes == room_ && labels_[slot] < labels_[parent_]);
  }

  void count(std::uint32_t slot) {
    ++other_votes_;
    for (std::size_t i = 0; i < other_count_; ++i) {
      if (other_[i] == slot) {
        ++votes_[i];
        return;
      }
    }
    other_[other_count_] = slot;
    votes_[other_count_++] = 1;
  }

  const std::vector<std::int64_t>& labels_;
  std::uint32_t parent_;
  int left_;
  int room_;
  int other_votes_ = 0;
  bool is_one_ = true;
  std::size_t other_count_ = 0;
  std::array<std::uint32_t, 8> other_;  ///< the other labels met; only other_count_ hold anything
  std::array<int, 8> votes_;            ///< how often
};

}  // namespace octavo
