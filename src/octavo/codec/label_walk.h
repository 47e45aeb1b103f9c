// The one walk over the octants of a brick's level that encoder, decoder and training share.
//
// It makes level i from level i+1. Every sample starts as its parent's label; where the parent is
// mixed the octant is visited: for each child, by rising digit, "is it its parent's label?", if not
// which label, and above level 0 "is it uniform?". The Io answers: an encoder writes the truth, a
// decoder reads it.
// Neighbors already visited are seen as they are, the others as their parents.
//
// Answers that follow from what a parent is (the most frequent label below; mixed, so not all
// alike) are not asked. They follow from the answers alone, so that both sides agree whatever the
// bytes are.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "octavo/codec/label_contexts.h"
#include "octavo/codec/label_grid.h"
#include "octavo/codec/label_model.h"
#include "octavo/codec/label_octant.h"

namespace octavo {

inline constexpr std::uint32_t kNoLabelSlot = 0xffffffffu;

/// The probability that a level is plain: coded without neighbors, for labels that are noise.
inline constexpr Probability kPlainOdds = 16;

/// The kinds of questions; every Io is told which one it answers.
enum class LabelAsk : std::uint8_t { same, uniform, candidate, known, fresh };

/// What the Io of a walk must offer (Io is a template parameter, not a base: it is called per bit):
///   bool ask(LabelAsk, bool truth, Probability yes)    the answer
///   void observe(LabelAsk, const LabelQuestion&, bool) the answer to a network's question, for
///   training
///   bool is_plain()                                    whether the encoder wants the next level
///   plain
///   bool is_pair()                                     the brick has two labels in all
///   TrueSample truth(const Index3& child)              what an encoder knows; a decoder returns {}
///   void met(std::int64_t label, std::uint32_t slot)   a label got its slot
struct TrueSample {
  std::int64_t label = 0;
  std::uint32_t slot = kNoLabelSlot;  ///< kNoLabelSlot while the label has none
  bool is_uniform = false;
};

template <class Io>
class LabelWalk {
 public:
  LabelWalk(const LabelModel& model, const ValueRange& range, Io& io)
      : model_(model), range_(range), io_(io), fresh_(model.palette, range) {}

  /// The brick's root: its label, mixed.
  LabelGrid root() {
    LabelGrid grid({1, 1, 1});
    const std::int64_t label = io_.truth({0, 0, 0}).label;
    state_.is_pair = io_.ask(LabelAsk::fresh, io_.is_pair(), kEvenOdds);
    if (state_.is_pair) {
      const bool is_low = io_.ask(LabelAsk::fresh, label == range_.min, kEvenOdds);
      slot_for(is_low ? range_.min : range_.max);
      slot_for(is_low ? range_.max : range_.min);
    } else {
      slot_for(code_fresh(label));
    }
    *grid.at({0, 0, 0}) = label_cell(0, kMixed);
    return grid;
  }

  /// Level `level` of the shape from the one above it.
  LabelGrid descend(const LabelGrid& parents, const BrickShape& shape, int level) {
    const auto i = static_cast<std::size_t>(level);
    LabelGrid grid = expanded(parents, shape.size[i], shape.halving[i]);
    level_ = level;
    is_plain_ = io_.ask(LabelAsk::fresh, io_.is_plain(), kPlainOdds);
    mask_ = shape.halving[i];
    neighborhood_ = label_neighborhood(grid.row_stride(), grid.plane_stride());
    const Size3& size = parents.size();
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        const LabelCell* row = parents.at({0, y, z});
        for (std::int64_t x = 0; x < size.x; ++x) {
          if (state_of(row[x]) == kMixed) visit(grid, {x, y, z}, slot_of(row[x]));
        }
      }
    }
    return grid;
  }

  /// The labels by slot.
  const std::vector<std::int64_t>& labels() const { return state_.slots; }

  /// What has been learned so far, to take a level back.
  struct State {
    std::vector<std::int64_t> slots;
    bool is_pair = false;  ///< the brick has no labels but range.min and range.max
    AdaptiveBit is_fresh;
    AdaptiveBit in_palette{65000};
    std::array<std::array<AdaptiveBit, 8>, 8> plain_same;  ///< by children left and others met
    AdaptiveBit plain_uniform;
  };
  const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }

 private:
  /// What the visited children of the octant say.
  struct Octant {
    std::uint32_t parent = 0;
    int left = 0;       ///< children not visited yet
    int same = 0;       ///< visited children with the parent's label
    int other_count = 0;
    bool is_one = true; ///< all visited children are uniform and have the parent's label
    std::array<std::uint32_t, 8> other{};  ///< the other labels met
    std::array<int, 8> votes{};            ///< how often
  };

  void visit(LabelGrid& grid, const Index3& parent, std::uint32_t parent_slot) {
    Octant octant;
    octant.parent = parent_slot;
    for_each_child(grid.size(), mask_, parent, [&](int, const Index3&) { ++octant.left; });
    for_each_child(grid.size(), mask_, parent, [&](int digit, const Index3& child) {
      --octant.left;
      visit_child(grid, octant, digit, child);
    });
  }

  void visit_child(LabelGrid& grid, Octant& octant, int digit, const Index3& child) {
    LabelCell* cell = grid.at(child);
    const TrueSample truth = io_.truth(child);
    if (!is_plain_) look(cell, digit, octant.parent);
    std::uint32_t slot = octant.parent;
    if (ask_same(octant, digit, truth)) {
      ++octant.same;
    } else {
      slot = code_other(cell, octant, digit, truth);
      count_other(octant, slot);
      if (level_ > 0 && !is_plain_) look(cell, digit, slot);
    }
    const bool is_uniform = level_ == 0 || ask_uniform(octant, digit, slot, truth);
    octant.is_one = octant.is_one && is_uniform && slot == octant.parent;
    *cell = label_cell(slot, is_uniform ? kUniform : kMixed);
  }

  /// Fills the question with what is known around `cell`.
  void look(const LabelCell* cell, int digit, std::uint32_t slot) {
    const auto& offsets = neighborhood_[static_cast<std::size_t>(digit)];
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      const LabelCell near = cell[offsets[i]];
      question_.neighbor[i] =
          static_cast<std::uint8_t>(2 * (near & 3) + (slot_of(near) == slot ? 1u : 0u));
    }
  }

  std::uint8_t level_category() const {
    return static_cast<std::uint8_t>(std::min(level_, kLabelSecondCategories - 1));
  }

  bool ask_same(const Octant& octant, int digit, const TrueSample& truth) {
    if (octant.is_one && octant.left == 0 && level_ == 0 && octant.same > 0) return false;
    if (must_be_same(octant)) return true;
    const int others = other_votes(octant);
    const bool is_same = truth.label == state_.slots[octant.parent];
    if (is_plain_) {
      auto& bits = state_.plain_same[static_cast<std::size_t>(octant.left)];
      return ask_adaptive(LabelAsk::fresh, bits[static_cast<std::size_t>(others)], is_same);
    }
    question_.first = static_cast<std::uint8_t>(digit * 5 + std::min(others, 4));
    question_.second = level_category();
    return ask_network(LabelAsk::same, is_same);
  }

  bool ask_uniform(const Octant& octant, int digit, std::uint32_t slot, const TrueSample& truth) {
    if (octant.is_one && octant.left == 0 && slot == octant.parent) return false;
    if (is_plain_) return ask_adaptive(LabelAsk::fresh, state_.plain_uniform, truth.is_uniform);
    const int history = slot != octant.parent ? 0 : octant.is_one ? 1 : 2;
    question_.first = static_cast<std::uint8_t>(digit * 5 + history);
    question_.second = level_category();
    return ask_network(LabelAsk::uniform, truth.is_uniform);
  }

  bool ask_network(LabelAsk kind, bool truth) {
    const int logit = model_.nets[static_cast<std::size_t>(kind)].logit(question_);
    const bool answer = io_.ask(kind, truth, probability_of(logit));
    io_.observe(kind, question_, answer);
    return answer;
  }

  static int other_votes(const Octant& octant) {
    int others = 0;
    for (int i = 0; i < octant.other_count; ++i)
      others += octant.votes[static_cast<std::size_t>(i)];
    return others;
  }

  /// True when the parent's label can no longer win the vote without this child.
  bool must_be_same(const Octant& octant) const {
    const int most = octant.same + octant.left;
    if (most == 0) return true;
    for (int i = 0; i < octant.other_count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (wins(octant.votes[k], octant.other[k], most, octant.parent)) return true;
    }
    return state_.is_pair && is_excluded(octant, 1 - octant.parent);
  }

  /// True when `votes` for `slot` beat `most` for `parent`.
  bool wins(int votes, std::uint32_t slot, int most, std::uint32_t parent) const {
    return votes > most || (votes == most && state_.slots[slot] < state_.slots[parent]);
  }

  /// True when another child of `slot` would outvote the parent.
  bool is_excluded(const Octant& octant, std::uint32_t slot) const {
    int votes = 1;
    for (int i = 0; i < octant.other_count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (octant.other[k] == slot) votes += octant.votes[k];
    }
    return wins(votes, slot, octant.same + octant.left, octant.parent);
  }

  static void count_other(Octant& octant, std::uint32_t slot) {
    for (int i = 0; i < octant.other_count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (octant.other[k] == slot) {
        ++octant.votes[k];
        return;
      }
    }
    const auto k = static_cast<std::size_t>(octant.other_count++);
    octant.other[k] = slot;
    octant.votes[k] = 1;
  }

  /// Which label, when it is not the parent's: one of the neighbors' by falling votes, else one
  /// known in the brick, else a fresh one.
  std::uint32_t code_other(const LabelCell* cell, const Octant& octant, int digit,
                           const TrueSample& truth) {
    if (state_.is_pair) return 1 - octant.parent;
    if (is_plain_) return slot_for(code_fresh(truth.label));
    LabelCandidates candidates;
    const auto& offsets = neighborhood_[static_cast<std::size_t>(digit)];
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      const LabelCell near = cell[offsets[i]];
      if (state_of(near) == kOutside || slot_of(near) == octant.parent) continue;
      candidates.add(slot_of(near), label_vote(i, state_of(near)));
    }
    candidates.drop_if([&](std::uint32_t slot) { return is_excluded(octant, slot); });
    candidates.sort();
    for (int j = 0; j < candidates.count(); ++j) {
      const std::uint32_t slot = candidates.slot(j);
      look(cell, digit, slot);
      question_.first = static_cast<std::uint8_t>(8 * std::min(j, 3) + candidates.share(j));
      question_.second = static_cast<std::uint8_t>(std::min(candidates.count() - 1 - j, 3));
      const bool is_it = state_.slots[slot] == truth.label;
      if (ask_network(LabelAsk::candidate, is_it)) return slot;
    }
    return code_distant(truth.slot, truth.label);
  }

  std::uint32_t code_distant(std::uint32_t true_slot, std::int64_t true_label) {
    const bool is_fresh = ask_adaptive(LabelAsk::fresh, state_.is_fresh, true_slot == kNoLabelSlot);
    if (is_fresh) return slot_for(code_fresh(true_label));
    return static_cast<std::uint32_t>(code_uniform(
        LabelAsk::known, true_slot == kNoLabelSlot ? 0 : true_slot, state_.slots.size()));
  }

  /// A label from the palette within the brick's range, else any value of the range.
  std::int64_t code_fresh(std::int64_t label) {
    if (fresh_.count > 0) {
      const std::int64_t rank = fresh_.rank_of(label);
      if (ask_adaptive(LabelAsk::fresh, state_.in_palette, rank >= 0)) {
        const auto number = static_cast<std::uint64_t>(std::max<std::int64_t>(rank, 0));
        return fresh_.first[code_uniform(LabelAsk::fresh, number, fresh_.count)];
      }
    }
    const auto span = static_cast<std::uint64_t>(range_.max - range_.min) + 1;
    const auto offset = static_cast<std::uint64_t>(label - range_.min);
    return range_.min + static_cast<std::int64_t>(code_uniform(LabelAsk::fresh, offset, span));
  }

  /// A number below `count` (at most 2^32), all alike.
  std::uint64_t code_uniform(LabelAsk kind, std::uint64_t number, std::uint64_t count) {
    std::uint64_t low = 0;
    while (count > 1) {
      const std::uint64_t half = count >> 1;
      const auto upper = static_cast<Probability>(((count - half) << 16) / count);
      if (io_.ask(kind, number >= low + half, upper)) {
        low += half;
        count -= half;
      } else {
        count = half;
      }
    }
    return low;
  }

  bool ask_adaptive(LabelAsk kind, AdaptiveBit& bit, bool truth) {
    const bool answer = io_.ask(kind, truth, bit.probability());
    bit.update(answer);
    return answer;
  }

  /// A new slot for `label`.
  std::uint32_t slot_for(std::int64_t label) {
    const auto slot = static_cast<std::uint32_t>(state_.slots.size());
    state_.slots.push_back(label);
    io_.met(label, slot);
    return slot;
  }

  const LabelModel& model_;
  ValueRange range_;
  Io& io_;
  LabelPaletteRange fresh_;
  State state_;
  std::array<std::array<std::ptrdiff_t, kLabelNeighbors>, 8> neighborhood_{};
  LabelQuestion question_{};
  bool is_plain_ = false;
  int level_ = 0;
  HalvingMask mask_ = 0;
};

}  // namespace octavo
