#include "octavo/ops/label/label_overlaps.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <unordered_map>

#include "octavo/core/error.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

// Voxels by pair of labels, each a place in the labels of its tree.
class PairCounts {
 public:
  void add(std::uint32_t first, std::uint32_t second, std::uint64_t voxels) {
    counts_[std::uint64_t{first} << 32 | second] += voxels;
  }
  const std::unordered_map<std::uint64_t, std::uint64_t>& counts() const { return counts_; }

 private:
  std::unordered_map<std::uint64_t, std::uint64_t> counts_;
};

// A cube or a word of a tree: of one label, or stored.
struct LabelItem {
  bool is_uniform = true;
  std::uint32_t label = 0;
  std::uint64_t place = 0;
};

LabelItem root_of(const LabelTree& tree) {
  if (!tree.root().is_uniform()) return {false, 0, 0};
  return {true, tree.label_of_child(tree.rank_count() - 1, tree.root(), 0), 0};
}

// The children of an item of `rank` as items.
class Children {
 public:
  Children(const LabelTree& tree, int rank, const LabelItem& item)
      : tree_(tree), rank_(rank), item_(item) {
    if (!item.is_uniform) cube_ = &tree.cubes(rank)[item.place];
  }

  LabelItem at(int bit) const {
    if (cube_ == nullptr) return item_;
    if ((cube_->mixed >> bit & 1) != 0) return {false, 0, cube_->place_of(bit)};
    return {true, tree_.label_of_child(rank_, *cube_, bit), 0};
  }

  /// Those that are stored.
  std::uint64_t mixed() const { return cube_ == nullptr ? 0 : cube_->mixed; }

  /// Calls visit(label, bits) for the others.
  template <class Visit>
  void visit_uniform(Visit&& visit) const {
    if (cube_ == nullptr) {
      visit(item_.label, kFullWord);
    } else {
      tree_.visit_runs(rank_, *cube_, visit);
    }
  }

 private:
  const LabelTree& tree_;
  int rank_;
  LabelItem item_;
  const LabelCube* cube_ = nullptr;
};

class Overlaps {
 public:
  Overlaps(const LabelTree& a, const LabelTree& b) : a_(a), b_(b) {}

  std::vector<LabelOverlap> make() {
    PairCounts above;
    collect(a_.rank_count() - 1, root_of(a_), root_of(b_), above);
    PerThread<PairCounts> of_threads;
    parallel_for(std::size_t{0}, places_.size(), [&](std::size_t i) {
      count_cubes(1, places_[i].first, places_[i].second, of_threads.local());
    });
    std::map<std::uint64_t, std::uint64_t> all(above.counts().begin(), above.counts().end());
    for (const PairCounts& counts : of_threads) {
      for (const auto& [pair, voxels] : counts.counts()) all[pair] += voxels;
    }
    std::vector<LabelOverlap> overlaps;
    for (const auto& [pair, voxels] : all) {
      LabelOverlap overlap{a_.labels()[pair >> 32], b_.labels()[pair & 0xffffffff], voxels};
      // What is not in the volume was counted as 0 of both.
      if (overlap.first == 0 && overlap.second == 0) {
        overlap.voxel_count += static_cast<std::uint64_t>(a_.size().voxel_count());
        overlap.voxel_count -= std::uint64_t{64} << 6 * a_.rank_count();
      }
      if (overlap.voxel_count != 0) overlaps.push_back(overlap);
    }
    return overlaps;
  }

 private:
  // The pairs of cubes of rank 1 to work on; what is above them is counted.
  void collect(int rank, const LabelItem& a, const LabelItem& b, PairCounts& counts) {
    if (rank == 1) {
      places_.emplace_back(a, b);
      return;
    }
    const Children of_a(a_, rank, a);
    const Children of_b(b_, rank, b);
    count_uniform(rank, of_a, of_b, counts);
    for (std::uint64_t left = of_a.mixed() | of_b.mixed(); left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      collect(rank - 1, of_a.at(bit), of_b.at(bit), counts);
    }
  }

  void count_cubes(int rank, const LabelItem& a, const LabelItem& b, PairCounts& counts) const {
    const Children of_a(a_, rank, a);
    const Children of_b(b_, rank, b);
    count_uniform(rank, of_a, of_b, counts);
    for (std::uint64_t left = of_a.mixed() | of_b.mixed(); left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      if (rank > 0) {
        count_cubes(rank - 1, of_a.at(bit), of_b.at(bit), counts);
      } else {
        count_words(of_a.at(bit), of_b.at(bit), counts);
      }
    }
  }

  // The children that have one label in both.
  static void count_uniform(int rank, const Children& a, const Children& b, PairCounts& counts) {
    a.visit_uniform([&](std::uint32_t first, std::uint64_t bits_a) {
      b.visit_uniform([&](std::uint32_t second, std::uint64_t bits_b) {
        const auto both = static_cast<std::uint64_t>(std::popcount(bits_a & bits_b));
        if (both != 0) counts.add(first, second, both << 6 * (rank + 1));
      });
    });
  }

  void count_words(const LabelItem& a, const LabelItem& b, PairCounts& counts) const {
    visit(a_, a, [&](std::uint32_t first, std::uint64_t bits_a) {
      visit(b_, b, [&](std::uint32_t second, std::uint64_t bits_b) {
        const auto both = static_cast<std::uint64_t>(std::popcount(bits_a & bits_b));
        if (both != 0) counts.add(first, second, both);
      });
    });
  }

  // The labels of a word.
  template <class Take>
  static void visit(const LabelTree& tree, const LabelItem& word, Take&& take) {
    if (word.is_uniform) {
      take(word.label, kFullWord);
    } else {
      tree.visit_word(word.place, take);
    }
  }

  const LabelTree& a_;
  const LabelTree& b_;
  std::vector<std::pair<LabelItem, LabelItem>> places_;
};

}  // namespace

std::vector<LabelOverlap> label_overlaps(const LabelTree& a, const LabelTree& b) {
  if (a.size() != b.size()) {
    throw Error(ErrorKind::invalid_argument, "the label maps differ in size");
  }
  return Overlaps(a, b).make();
}

std::vector<LabelAgreement> label_agreements(const std::vector<LabelOverlap>& overlaps) {
  std::map<std::int64_t, LabelAgreement> by_label;
  for (const LabelOverlap& overlap : overlaps) {
    by_label[overlap.first].first_voxels += overlap.voxel_count;
    by_label[overlap.second].second_voxels += overlap.voxel_count;
    if (overlap.first == overlap.second) {
      by_label[overlap.first].both_voxels += overlap.voxel_count;
    }
  }
  by_label.erase(0);
  std::vector<LabelAgreement> agreements;
  for (auto& [label, agreement] : by_label) {
    agreement.label = label;
    agreements.push_back(agreement);
  }
  return agreements;
}

}  // namespace octavo
