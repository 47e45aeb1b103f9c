// Octants of a brick of two labels whose eight children all weigh alike: nearly all that masks ask
// about. Included by label_walk-inl.h, which has the traversal of any octant; questions and answers
// are the same, but fewer things have to be known: a child that has not its octant's label has the
// other one, and votes are numbers of children.
//
// Children of the finest level are taken at compile time, one after the other, so that what is
// known around them stays in registers.

/// Which children of an octant have not its label, and which are mixed, bit by digit.
struct PairTargets {
  std::uint32_t others = 0;
  std::uint32_t mixed = 0;
};

/// Around  what is known around the children, as for any octant, but with
///           void see(std::size_t digit)
///           void settle(std::size_t digit, bool is_same, LabelState)   the child got the octant's
///                                                                      label or the other one
template <class Io, class Around>
class PairOctant {
 public:
  /// first   the first child
  /// place   where the children stand, from the first
  /// parent  the slot of the octant's label, 0 or 1
  /// is_tie  the other label wins where children are divided equally
  PairOctant(const LabelModel& model, std::size_t level_category, Io& io,
             const LabelNeighborhood& neighborhood, const std::array<std::ptrdiff_t, 8>& place,
             LabelCell* first, std::uint32_t parent, bool is_tie, const PairTargets& targets)
      : model_(model),
        level_category_(level_category),
        io_(io),
        place_(place),
        first_(first),
        parent_(parent),
        most_others_(is_tie ? 3 : 4),
        targets_(targets),
        around_(first, neighborhood, parent) {}

  /// Visits children of the finest level, which are uniform.
  [[gnu::always_inline]] void visit_voxels() { visit_voxels_from<0>(); }

  /// Visits others. Returns which of them are mixed.
  std::uint32_t visit_octants() {
    for (std::size_t digit = 0; digit < 8; ++digit) {
      around_.see(digit);
      // What follows is there for either answer, so that nothing waits for it that a processor can
      // do before.
      if (others_ == most_others_ || ask_same(digit)) {
        ask_uniform<true>(digit);
      } else {
        ++others_;
        is_one_ = false;
        around_.flip();
        ask_uniform<false>(digit);
      }
    }
    return mixed_;
  }

 private:
  template <std::size_t kDigit>
  [[gnu::always_inline]] void visit_voxels_from() {
    if constexpr (kDigit < 8) {
      if (others_ == most_others_) {
        // One more, and the octant's label would not be that of most.
        for (std::size_t digit = kDigit; digit < 8; ++digit) {
          first_[place_[digit]] = label_cell(parent_, kUniform);
        }
        return;
      }
      bool is_same = false;  // as the last one, where the other label has not been met
      if (kDigit < 7 || others_ > 0) {
        around_.see(kDigit);
        is_same = ask_same(kDigit);
      }
      if (is_same) {
        settle(kDigit, true, kUniform);
      } else {
        ++others_;
        settle(kDigit, false, kUniform);
      }
      visit_voxels_from<kDigit + 1>();
    }
  }

  template <bool kIsSame>
  [[gnu::always_inline]] void ask_uniform(std::size_t digit) {
    const std::size_t history = !kIsSame ? 0 : is_one_ ? 1 : 2;
    const bool must_be_mixed = digit == 7 && is_one_;  // as the octant is
    const bool target = (targets_.mixed >> digit & 1) == 0;
    if (!must_be_mixed && ask(LabelAsk::uniform, digit * 5 + history, target)) {
      settle(digit, kIsSame, kUniform);
    } else {
      is_one_ = false;
      mixed_ |= std::uint32_t{1} << digit;
      settle(digit, kIsSame, kMixed);
    }
  }

  [[gnu::always_inline]] bool ask_same(std::size_t digit) {
    return ask(LabelAsk::same, digit * 5 + others_, (targets_.others >> digit & 1) == 0);
  }

  [[gnu::always_inline]] bool ask(LabelAsk kind, std::size_t first, bool target) {
    const int logit =
        around_.logit(model_.nets[static_cast<std::size_t>(kind)], first, level_category_);
    const bool answer = io_.ask(target, probability_of(logit));
    io_.observe(kind, around_, first, level_category_, answer);
    return answer;
  }

  [[gnu::always_inline]] void settle(std::size_t digit, bool is_same, LabelState state) {
    first_[place_[digit]] = label_cell(is_same ? parent_ : 1 - parent_, state);
    around_.settle(digit, is_same, state);
  }

  const LabelModel& model_;
  std::size_t level_category_;
  Io& io_;
  const std::array<std::ptrdiff_t, 8>& place_;
  LabelCell* first_;
  std::uint32_t parent_;
  std::uint32_t others_ = 0;  ///< children so far that have the other label
  std::uint32_t most_others_;
  bool is_one_ = true;       ///< all of them are uniform and have the octant's label
  std::uint32_t mixed_ = 0;  ///< which of them are
  PairTargets targets_;
  Around around_;
};

/// Whether octants of two labels are visited in a way of their own.
template <class Around>
concept HasPairs = requires { typename Around::Pair; };
