// The body of a label traversal, compiled once per instruction set. Include in a namespace of its
// own after defining there
//   class Around          what is known around the children of an octant:
//     Around(const LabelCell* first, const LabelNeighborhood&, std::uint32_t parent_slot)
//     void see(const LabelCell* cell, std::size_t digit)   turns to a child; neighbors are compared
//                                                          to the parent's label
//     void aim(std::uint32_t slot)                         neighbors are compared to another label
//     void flip()                                          neighbors that had the label have not
//                                                          and those that had not have
//     int logit(const LabelNet&, std::size_t first, std::size_t second) const
//     bool propose(LabelCandidates&)                       labels other than the parent's; true
//                                                          where there is just one, so that flip
//                                                          aims at it: its votes count for nothing
//     void settle(std::size_t digit, LabelCell)            the child got its label
//     void tell(LabelQuestion&) const                      the neighbors of the question
//     Pair                                                 that of a PairOctant, if there is one
//
// An Io offers
//   bool ask(bool target, Probability yes)              the answer
//   void observe(LabelAsk, const Around&, first, second, answer)
//   std::int64_t root_label()                           what an encoder knows; to a decoder they
//   void visit(parent, digits)                          mean nothing: the targets of some children
//   TargetSample target(digit)
//   std::int64_t label_of(const TargetSample&)
//   PairTargets pair_targets(parent, parent_slot)       of all children where there are two labels
//   void met(std::int64_t label, std::uint32_t slot)   a label got its slot

inline constexpr std::uint32_t kNoLabelSlot = 0xffffffffu;

struct TargetSample {
  std::uint32_t rank = 0;             ///< of its label among those of the brick
  std::uint32_t slot = kNoLabelSlot;  ///< kNoLabelSlot while the label has none
  bool is_uniform = false;
};

#include "octavo/codec/label/label_pair_walk-inl.h"

template <class Io>
class LabelWalk {
 public:
  LabelWalk(const LabelModel& model, const ValueRange& range, Io& io, LabelWork& work)
      : model_(model), range_(range), io_(io), work_(work), fresh_(model.palette, range) {}

  /// The brick's root: its label, mixed.
  void root(bool is_pair) {
    work_.start();
    const std::int64_t label = io_.root_label();
    work_.is_pair = io_.ask(is_pair, kEvenOdds);
    if (work_.is_pair) {
      const bool is_low = io_.ask(label == range_.min, kEvenOdds);
      slot_for(is_low ? range_.min : range_.max);
      slot_for(is_low ? range_.max : range_.min);
    } else {
      slot_for(code_fresh(label));
    }
    work_.grid.reset({1, 1, 1});
    *work_.grid.at({0, 0, 0}) = label_cell(0, kMixed);
    work_.mixed.assign(1, 1);
  }

  /// Level `level` of the shape from the one above it.
  void descend(const BrickShape& shape, int level) {
    const auto i = static_cast<std::size_t>(level);
    const Size3& size = shape.size[i];
    std::swap(work_.parents, work_.grid);
    std::swap(work_.mixed_parents, work_.mixed);
    work_.mixed.assign(static_cast<std::size_t>(size.y * size.z), 0);
    const LabelGrid& parents = work_.parents;
    LabelGrid& grid = work_.grid;
    level_ = level;
    level_category_ = std::min(i, kLabelSecondCategories - 1);
    mask_ = shape.halving[i];
    weights_ = LevelWeights(shape, level);
    work_.is_sparse = level == 0 && mask_ == kHalveAll;
    if (work_.is_sparse) expand_near_mixed(parents, work_.mixed_parents, size, grid);
    else expand(parents, size, mask_, grid);
    neighborhood_ = &work_.neighborhood(level);
    place_ = child_steps(mask_, grid.row_stride(), grid.plane_stride());
    std::size_t row = 0;
    for (std::int64_t z = 0; z < parents.size().z; ++z) {
      for (std::int64_t y = 0; y < parents.size().y; ++y, ++row) {
        for (auto left = work_.mixed_parents[row]; left != 0; left &= left - 1) {
          const Index3 parent{std::countr_zero(left), y, z};
          visit_any(parent, slot_of(*parents.at(parent)));
        }
      }
    }
  }

 private:
  [[gnu::always_inline]] void visit_any(const Index3& parent, std::uint32_t parent_slot) {
    if constexpr (HasPairs<Around>) {
      if (is_pair_octant(parent)) return visit_pair<Around>(parent, parent_slot);
    }
    visit(parent, parent_slot);
  }

  /// Whether an octant is that of a PairOctant.
  bool is_pair_octant(const Index3& parent) const {
    return work_.is_pair && child_digits(work_.grid.size(), mask_, parent) == 0xff &&
           weights_.are_alike(parent);
  }

  template <HasPairs Any>
  void visit_pair(const Index3& parent, std::uint32_t parent_slot) {
    const bool is_tie = work_.labels[1 - parent_slot] < work_.labels[parent_slot];
    PairOctant<Io, typename Any::Pair> octant(
        model_, level_category_, io_, *neighborhood_, place_,
        work_.grid.at(child_position(mask_, parent, 0)), parent_slot, is_tie,
        io_.pair_targets(parent, parent_slot));
    if (level_ == 0) {
      octant.visit_voxels();
      return;
    }
    for (std::uint32_t left = octant.visit_octants(); left != 0; left &= left - 1) {
      mark_mixed(parent, static_cast<std::size_t>(std::countr_zero(left)));
    }
  }

  void visit(const Index3& parent, std::uint32_t parent_slot) {
    LabelGrid& grid = work_.grid;
    LabelCell* first = grid.at(child_position(mask_, parent, 0));
    Around around(first, *neighborhood_, parent_slot);
    std::uint32_t digits = child_digits(grid.size(), mask_, parent);
    const bool is_alike = weights_.are_alike(parent);
    const ChildWeights weights = is_alike ? kAlikeChildren : weights_.of(parent);
    const int count = std::popcount(digits);
    LabelOctant octant(parent_slot, count, is_alike ? count : sum_of(weights, digits),
                       work_.labels);
    io_.visit(parent, digits);
    for (; digits != 0; digits &= digits - 1) {
      const auto digit = static_cast<std::size_t>(std::countr_zero(digits));
      octant.enter(weights[digit]);
      const TargetSample target = io_.target(digit);
      LabelCell* cell = first + place_[digit];
      *cell = visit_child(around, cell, octant, digit, target);
      around.settle(digit, *cell);
      if (state_of(*cell) == kMixed) mark_mixed(parent, digit);
    }
  }

  void mark_mixed(const Index3& parent, std::size_t digit) {
    const Index3 at = child_position(mask_, parent, static_cast<int>(digit));
    const auto row = static_cast<std::size_t>(work_.grid.size().y * at.z + at.y);
    work_.mixed[row] |= std::uint64_t{1} << at.x;
  }

  [[gnu::always_inline]] LabelCell visit_child(Around& around, const LabelCell* cell,
                                               LabelOctant& octant, std::size_t digit,
                                               const TargetSample& target) {
    const std::optional<bool> known = is_known_same(octant);
    if (level_ == 0 && known == true) {
      octant.leave(octant.parent(), true);
      return label_cell(octant.parent(), kUniform);
    }
    around.see(cell, digit);
    std::uint32_t slot = octant.parent();
    if (known ? !*known : !ask_same(around, octant, digit, target)) {
      slot = code_other(around, octant, target);
    }
    const bool is_uniform = level_ == 0 || ask_uniform(around, octant, digit, slot, target);
    octant.leave(slot, is_uniform);
    return label_cell(slot, is_uniform ? kUniform : kMixed);
  }

  /// Whether a child has its parent's label, where that follows from the others.
  std::optional<bool> is_known_same(const LabelOctant& octant) const {
    // A mixed parent has two labels below it; with a single child they are further down.
    if (octant.is_one() && octant.left() == 0 && level_ == 0 && octant.room() > 0) return false;
    const bool must_be = work_.is_pair ? octant.is_pair_decided() : octant.must_be_same();
    return must_be ? std::optional(true) : std::nullopt;
  }

  bool ask_same(const Around& around, const LabelOctant& octant, std::size_t digit,
                const TargetSample& target) {
    const auto others = static_cast<std::size_t>(std::min(octant.others(), 4));
    return ask_network(LabelAsk::same, around, digit * 5 + others, level_category_,
                       target.slot == octant.parent());
  }

  bool ask_uniform(const Around& around, const LabelOctant& octant, std::size_t digit,
                   std::uint32_t slot, const TargetSample& target) {
    const bool is_same = slot == octant.parent();
    if (octant.is_one() && octant.left() == 0 && is_same) return false;
    const std::size_t history = !is_same ? 0 : octant.is_one() ? 1 : 2;
    return ask_network(LabelAsk::uniform, around, digit * 5 + history, level_category_,
                       target.is_uniform);
  }

  [[gnu::always_inline]] bool ask_network(LabelAsk kind, const Around& around, std::size_t first,
                                          std::size_t second, bool target) {
    const int logit = around.logit(model_.nets[static_cast<std::size_t>(kind)], first, second);
    const bool answer = io_.ask(target, probability_of(logit));
    io_.observe(kind, around, first, second, answer);
    return answer;
  }

  /// Which label, when it is not the parent's: one of the neighbors' by falling votes, else one
  /// known in the brick, else a fresh one. Above level 0, neighbors are compared to it afterwards.
  std::uint32_t code_other(Around& around, const LabelOctant& octant, const TargetSample& target) {
    if (work_.is_pair) {
      around.flip();
      return 1 - octant.parent();
    }
    LabelCandidates candidates;
    const bool is_single = around.propose(candidates);
    candidates.drop_if([&](std::uint32_t slot) { return octant.is_excluded(slot); });
    if (!is_single) candidates.sort();
    for (std::size_t j = 0; j < candidates.count(); ++j) {
      const std::uint32_t slot = candidates.slot(j);
      if (is_single) around.flip();
      else around.aim(slot);
      const std::size_t first =
          8 * std::min<std::size_t>(j, 3) + static_cast<std::size_t>(candidates.share(j));
      const std::size_t second = std::min<std::size_t>(candidates.count() - 1 - j, 3);
      if (ask_network(LabelAsk::candidate, around, first, second, target.slot == slot)) return slot;
    }
    const std::uint32_t slot = code_distant(target);
    if (level_ > 0) around.aim(slot);
    return slot;
  }

  std::uint32_t code_distant(const TargetSample& target) {
    const bool has_none = target.slot == kNoLabelSlot;
    if (ask_adaptive(work_.is_fresh, has_none)) return slot_for(code_fresh(io_.label_of(target)));
    return static_cast<std::uint32_t>(
        code_uniform(has_none ? 0 : target.slot, work_.labels.size()));
  }

  /// A label from the palette within the brick's range, else any value of the range.
  std::int64_t code_fresh(std::int64_t label) {
    if (fresh_.count > 0) {
      const std::int64_t rank = fresh_.rank_of(label);
      if (ask_adaptive(work_.in_palette, rank >= 0)) {
        const auto number = static_cast<std::uint64_t>(std::max<std::int64_t>(rank, 0));
        return fresh_.first[code_uniform(number, fresh_.count)];
      }
    }
    const auto span = static_cast<std::uint64_t>(range_.max - range_.min) + 1;
    const auto offset = static_cast<std::uint64_t>(label - range_.min);
    return range_.min + static_cast<std::int64_t>(code_uniform(offset, span));
  }

  /// A number below `count` (at most 2^32), all alike.
  std::uint64_t code_uniform(std::uint64_t number, std::uint64_t count) {
    std::uint64_t low = 0;
    while (count > 1) {
      const std::uint64_t half = count >> 1;
      const auto upper = static_cast<Probability>(((count - half) << 16) / count);
      if (io_.ask(number >= low + half, upper)) {
        low += half;
        count -= half;
      } else {
        count = half;
      }
    }
    return low;
  }

  bool ask_adaptive(AdaptiveBit& bit, bool target) {
    const bool answer = io_.ask(target, bit.probability());
    bit.update(answer);
    return answer;
  }

  /// A new slot for `label`.
  std::uint32_t slot_for(std::int64_t label) {
    const auto slot = static_cast<std::uint32_t>(work_.labels.size());
    if (slot == kMaxLabelSlots) {
      throw Error(ErrorKind::corrupt, "brick: it has more labels than a coded brick may have");
    }
    work_.labels.push_back(label);
    io_.met(label, slot);
    return slot;
  }

  const LabelModel& model_;
  ValueRange range_;
  Io& io_;
  LabelWork& work_;
  LabelPaletteRange fresh_;
  const LabelNeighborhood* neighborhood_ = nullptr;
  std::array<std::ptrdiff_t, 8> place_{};  ///< of the children of an octant, from the first
  int level_ = 0;
  std::size_t level_category_ = 0;
  HalvingMask mask_ = 0;
  LevelWeights weights_;
};

/// Reads the answers; knows no target.
class DecodingIo {
 public:
  explicit DecodingIo(ByteSpan segment) : coder_(segment) {}

  bool ask(bool, Probability yes) { return coder_.get(yes); }
  template <class Seen>
  void observe(LabelAsk, const Seen&, std::size_t, std::size_t, bool) {}
  std::int64_t root_label() const { return 0; }
  PairTargets pair_targets(const Index3&, std::uint32_t) const { return {}; }
  void visit(const Index3&, std::uint32_t) {}
  TargetSample target(std::size_t) const { return {}; }
  std::int64_t label_of(const TargetSample&) const { return 0; }
  void met(std::int64_t, std::uint32_t) {}

  void next(ByteSpan segment) { coder_ = BinaryDecoder(segment); }
  bool is_consumed() const { return coder_.is_consumed_short(); }

 private:
  BinaryDecoder coder_;
};

/// The answers of a pyramid.
class TargetIo {
 public:
  explicit TargetIo(const LabelPyramid& pyramid)
      : pyramid_(pyramid), slot_of_rank_(pyramid.labels.size(), kNoLabelSlot) {}

  void enter(const BrickShape& shape, int level) {
    level_ = &pyramid_.levels[static_cast<std::size_t>(level)];
    mask_ = shape.halving[static_cast<std::size_t>(level)];
    is_finest_ = level == 0;
    steps_ = child_steps(mask_, level_->size.x, level_->size.x * level_->size.y);
  }

  std::int64_t root_label() const { return pyramid_.labels[pyramid_.root().rank[0]]; }
  std::int64_t label_of(const TargetSample& target) const { return pyramid_.labels[target.rank]; }

  void visit(const Index3& parent, std::uint32_t digits) {
    if (is_finest_ && pyramid_.words != nullptr) {
      take_octant(interleave(parent));
      return;
    }
    first_ = dense_offset(level_->size, child_position(mask_, parent, 0));
    for (std::uint32_t left = digits; left != 0; left &= left - 1) {
      const auto digit = static_cast<std::size_t>(std::countr_zero(left));
      rank_[digit] = level_->rank[at(digit)];
    }
  }

  PairTargets pair_targets(const Index3& parent, std::uint32_t parent_slot) const {
    PairTargets targets;
    if (is_finest_ && pyramid_.words != nullptr) {
      const std::uint64_t octant = interleave(parent);
      for (const LabelWordPart& part : pyramid_.words->parts_of(octant >> 3)) {
        if (slot_of_rank_[part.label] == parent_slot) continue;
        targets.others = static_cast<std::uint32_t>(part.bits >> 8 * (octant & 7) & 0xff);
      }
      return targets;
    }
    const std::size_t first = dense_offset(level_->size, child_position(mask_, parent, 0));
    for (std::size_t digit = 0; digit < 8; ++digit) {
      const std::size_t child = first + static_cast<std::size_t>(steps_[digit]);
      const bool is_other = slot_of_rank_[level_->rank[child]] != parent_slot;
      targets.others |= std::uint32_t{is_other} << digit;
      targets.mixed |= std::uint32_t{level_->is_uniform[child] == 0} << digit;
    }
    return targets;
  }

  TargetSample target(std::size_t digit) const {
    const std::uint32_t rank = rank_[digit];
    return {rank, slot_of_rank_[rank], is_finest_ || level_->is_uniform[at(digit)] != 0};
  }

  void met(std::int64_t label, std::uint32_t slot) {
    const auto& labels = pyramid_.labels;
    const auto rank = std::lower_bound(labels.begin(), labels.end(), label) - labels.begin();
    slot_of_rank_[static_cast<std::size_t>(rank)] = slot;
  }

 private:
  std::size_t at(std::size_t digit) const {
    return first_ + static_cast<std::size_t>(steps_[digit]);
  }

  /// The voxels of an octant, by its o-code.
  void take_octant(std::uint64_t octant) {
    for (const LabelWordPart& part : pyramid_.words->parts_of(octant >> 3)) {
      for (auto left = part.bits >> 8 * (octant & 7) & 0xff; left != 0; left &= left - 1) {
        rank_[static_cast<std::size_t>(std::countr_zero(left))] = part.label;
      }
    }
  }

  const LabelPyramid& pyramid_;
  const LabelPyramid::Level* level_ = nullptr;
  HalvingMask mask_ = 0;
  bool is_finest_ = false;
  std::array<std::ptrdiff_t, 8> steps_{};  ///< to the children of an octant, from the first
  std::size_t first_ = 0;
  std::array<std::uint32_t, 8> rank_{};  ///< of the children of the octant visited
  std::vector<std::uint32_t> slot_of_rank_;
};

class EncodingIo : public TargetIo {
 public:
  EncodingIo(const LabelPyramid& pyramid, Bytes& bytes) : TargetIo(pyramid), coder_(bytes) {}

  bool ask(bool target, Probability yes) {
    coder_.put(target, yes);
    return target;
  }
  template <class Seen>
  void observe(LabelAsk, const Seen&, std::size_t, std::size_t, bool) {}

  BinaryEncoder& coder() { return coder_; }

 private:
  BinaryEncoder coder_;
};

class ObservingIo : public TargetIo {
 public:
  ObservingIo(const LabelPyramid& pyramid, LabelObserver& observer)
      : TargetIo(pyramid), observer_(observer) {}

  bool ask(bool target, Probability) { return target; }
  template <class Seen>
  void observe(LabelAsk kind, const Seen& around, std::size_t first, std::size_t second,
               bool answer) {
    if (!observer_.wants_next(kind)) return;
    around.tell(question_);
    question_.first = static_cast<std::uint8_t>(first);
    question_.second = static_cast<std::uint8_t>(second);
    observer_.observe(kind, question_, answer);
  }

 private:
  LabelObserver& observer_;
  LabelQuestion question_{};
};

void decode_labels(const LabelModel& model, const BrickShape& shape, const ValueRange& range,
                   std::span<const ByteSpan> segments, int level, LabelWork& work) {
  DecodingIo io(segments.back());
  LabelWalk<DecodingIo> walk(model, range, io, work);
  walk.root(false);
  for (int i = shape.level_count - 1;; --i) {
    walk.descend(shape, i);
    if (!io.is_consumed()) {
      throw Error(ErrorKind::corrupt, "brick: the length of level " + std::to_string(i) +
                                          " does not fit its labels");
    }
    if (i == level) return;
    io.next(segments[static_cast<std::size_t>(i - 1)]);
  }
}

void encode_labels(const LabelModel& model, const BrickShape& shape, const LabelPyramid& pyramid,
                   std::vector<Bytes>& segments, LabelWork& work) {
  require_encoders();
  Bytes bytes;
  EncodingIo io(pyramid, bytes);
  LabelWalk<EncodingIo> walk(model, {pyramid.labels.front(), pyramid.labels.back()}, io, work);
  walk.root(pyramid.labels.size() == 2);
  for (int i = shape.level_count - 1; i >= 0; --i) {
    io.enter(shape, i);
    walk.descend(shape, i);
    io.coder().finish_short();
    segments[static_cast<std::size_t>(i)] = bytes;
    bytes.clear();
    io.coder() = BinaryEncoder(bytes);
  }
}

void observe_labels(const LabelModel& model, const BrickShape& shape, const LabelPyramid& pyramid,
                    LabelObserver& observer, LabelWork& work) {
  require_encoders();
  ObservingIo io(pyramid, observer);
  LabelWalk<ObservingIo> walk(model, {pyramid.labels.front(), pyramid.labels.back()}, io, work);
  walk.root(pyramid.labels.size() == 2);
  for (int i = shape.level_count - 1; i >= 0; --i) {
    io.enter(shape, i);
    walk.descend(shape, i);
  }
}
