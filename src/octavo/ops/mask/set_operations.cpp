#include "octavo/ops/mask/set_operations.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/ops/mask/mask_pieces.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

template <SetOperation kOperation>
std::uint64_t apply(std::uint64_t a, std::uint64_t b) {
  switch (kOperation) {
    case SetOperation::unite: return a | b;
    case SetOperation::intersect: return a & b;
    case SetOperation::subtract: return a & ~b;
    case SetOperation::exclusive_or: break;
  }
  return a ^ b;
}

/// What becomes of the children of two cubes, a bit each; what is in none of them is empty.
struct ChildPlan {
  std::uint64_t full;
  std::uint64_t copy_a;
  std::uint64_t copy_b;
  std::uint64_t invert_a;
  std::uint64_t invert_b;
  std::uint64_t both;  ///< to be entered

  /// As they are or inverted.
  std::uint64_t copied() const { return copy_a | copy_b | invert_a | invert_b; }
};

template <SetOperation kOperation>
ChildPlan plan_of(const MaskCube& a, const MaskCube& b) {
  // What is mixed counts as empty and as full in turn: where the result follows, it is copied;
  // where it goes the other way, inverted.
  const std::uint64_t only_a = a.mixed & ~b.mixed;
  const std::uint64_t only_b = b.mixed & ~a.mixed;
  const std::uint64_t a_empty = apply<kOperation>(0, b.full);
  const std::uint64_t a_full = apply<kOperation>(kFullWord, b.full);
  const std::uint64_t b_empty = apply<kOperation>(a.full, 0);
  const std::uint64_t b_full = apply<kOperation>(a.full, kFullWord);
  ChildPlan plan{};
  plan.full = (apply<kOperation>(a.full, b.full) & ~(a.mixed | b.mixed)) |
              (a_empty & a_full & only_a) | (b_empty & b_full & only_b);
  plan.copy_a = ~a_empty & a_full & only_a;
  plan.invert_a = a_empty & ~a_full & only_a;
  plan.copy_b = ~b_empty & b_full & only_b;
  plan.invert_b = b_empty & ~b_full & only_b;
  plan.both = a.mixed & b.mixed;
  return plan;
}

/// The traversal of two sub-trees; what it makes is appended to `out`.
template <SetOperation kOperation>
class Combiner {
 public:
  Combiner(const MaskTree& a, const MaskTree& b, MaskArrays& out) : a_(a), b_(b), out_(out) {}

  MaskCube combine(int rank, const MaskCube& a, const MaskCube& b) {
    return rank == 0 ? combine_words(a, b) : combine_cubes(rank, a, b);
  }

 private:
  MaskCube combine_words(const MaskCube& a, const MaskCube& b) {
    const ChildPlan plan = plan_of<kOperation>(a, b);
    const std::uint64_t* const words_a = a_.words().data();
    const std::uint64_t* const words_b = b_.words().data();
    WordCube words;
    const std::uint64_t kept = plan.copied() | plan.both;
    for (std::uint64_t left = kept; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      words.add(bit, apply<kOperation>(child_word(words_a, a, bit), child_word(words_b, b, bit)));
    }
    MaskCube made = words.finish(out_.words);
    made.full |= plan.full;
    return made;
  }

  static std::uint64_t child_word(const std::uint64_t* words, const MaskCube& cube, int bit) {
    if ((cube.mixed >> bit & 1) != 0) return words[cube.place_of(bit)];
    return -(cube.full >> bit & 1);
  }

  MaskCube combine_cubes(int rank, const MaskCube& a, const MaskCube& b) {
    const ChildPlan plan = plan_of<kOperation>(a, b);
    auto& below = out_.cubes[static_cast<std::size_t>(rank) - 1];
    MaskCube made{plan.full, 0, below.size()};
    const std::uint64_t copied = plan.copied();
    for (std::uint64_t left = copied | plan.both; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      const std::uint64_t here = std::uint64_t{1} << bit;
      if ((copied & here) != 0) {
        const bool is_a = ((plan.copy_a | plan.invert_a) & here) != 0;
        const bool is_inverted = ((plan.invert_a | plan.invert_b) & here) != 0;
        const MaskTree& from = is_a ? a_ : b_;
        const std::uint64_t place = (is_a ? a : b).place_of(bit);
        append_cubes(from, rank - 1, place, place + 1, is_inverted, out_);
        made.mixed |= here;
        continue;
      }
      const MaskCube child = combine(rank - 1, a_.cubes(rank - 1)[a.place_of(bit)],
                                     b_.cubes(rank - 1)[b.place_of(bit)]);
      add_child(child, bit, made, below);
    }
    return made;
  }

  const MaskTree& a_;
  const MaskTree& b_;
  MaskArrays& out_;
};

/// Two cubes of the same code, either of which may be empty.
struct Pair {
  std::uint64_t code;
  MaskCube a;
  MaskCube b;
};

std::vector<Pair> pairs_at(const MaskTree& a, const MaskTree& b, int rank) {
  const std::vector<MaskPiece> of_a = pieces_at(a, rank);
  const std::vector<MaskPiece> of_b = pieces_at(b, rank);
  std::vector<Pair> pairs;
  pairs.reserve(std::max(of_a.size(), of_b.size()));
  auto in_a = of_a.begin();
  auto in_b = of_b.begin();
  while (in_a != of_a.end() || in_b != of_b.end()) {
    const bool has_a = in_a != of_a.end() && (in_b == of_b.end() || in_a->code <= in_b->code);
    const bool has_b = in_b != of_b.end() && (in_a == of_a.end() || in_b->code <= in_a->code);
    Pair pair{has_a ? in_a->code : in_b->code, {}, {}};
    if (has_a) pair.a = (in_a++)->cube;
    if (has_b) pair.b = (in_b++)->cube;
    pairs.push_back(pair);
  }
  return pairs;
}

template <SetOperation kOperation>
MaskTree combined(const MaskTree& a, const MaskTree& b) {
  const int top = a.rank_count() - 1;
  const std::size_t tasks = (a.words().size() + b.words().size()) / kWordsPerTask;
  if (tasks < 2) {
    MaskArrays out = arrays_below(top + 1);
    out.words.reserve(std::max(a.words().size(), b.words().size()));
    const MaskCube root = Combiner<kOperation>(a, b, out).combine(top, a.root(), b.root());
    out.cubes.back().push_back(root);
    return {a.size(), std::move(out)};
  }

  // The coarsest rank with work for all.
  int rank = top - 1;
  while (rank > 1 && a.cubes(rank).size() + b.cubes(rank).size() < 4 * tasks) --rank;
  const std::vector<Pair> pairs = pairs_at(a, b, rank);
  std::vector<MaskPart> parts(std::min(tasks, pairs.size()));
  parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    MaskPart& part = parts[i];
    part.below = arrays_below(rank);
    Combiner<kOperation> combiner(a, b, part.below);
    const std::size_t end = (i + 1) * pairs.size() / parts.size();
    for (std::size_t at = i * pairs.size() / parts.size(); at < end; ++at) {
      const MaskCube made = combiner.combine(rank, pairs[at].a, pairs[at].b);
      if (!made.is_empty()) part.pieces.push_back({pairs[at].code, made});
    }
  });
  return assemble(a.size(), rank, parts);
}

}  // namespace

MaskTree combine(const MaskTree& a, const MaskTree& b, SetOperation operation) {
  if (a.size() != b.size()) {
    throw Error(ErrorKind::invalid_argument, "masks of volumes that differ in size");
  }
  switch (operation) {
    case SetOperation::unite: return combined<SetOperation::unite>(a, b);
    case SetOperation::intersect: return combined<SetOperation::intersect>(a, b);
    case SetOperation::subtract: return combined<SetOperation::subtract>(a, b);
    case SetOperation::exclusive_or: break;
  }
  return combined<SetOperation::exclusive_or>(a, b);
}

MaskTree complement(const MaskTree& a) {
  return combine(box_mask(a.size(), box_of(a.size())), a, SetOperation::subtract);
}

}  // namespace octavo
