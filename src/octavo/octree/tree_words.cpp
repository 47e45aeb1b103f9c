#include "octavo/octree/tree_words.h"

#include "octavo/octree/o_code.h"
#include "octavo/octree/tree_child.h"
#include "octavo/octree/word_steps.h"

namespace octavo {

namespace {

constexpr std::uint32_t kNoLabel = ~std::uint32_t{0};

// Calls visit(word of the brick, word of its cell, bits in the box) in o-code order until it
// returns false; the bits of words outside are 0.
template <class Visit>
void visit_places(const Box& box, Visit visit) {
  const Size3 size = box.size();
  const Index3 offset{(box.lo.x & 63) / 4, (box.lo.y & 63) / 4, (box.lo.z & 63) / 4};
  const bool is_whole = size == Size3{kCellSide, kCellSide, kCellSide};
  const bool is_first = offset == Index3{0, 0, 0};
  for (std::size_t word = 0; word < LabelWords::kCount; ++word) {
    std::uint64_t place = word;
    std::uint64_t inside = kFullWord;
    if (!is_whole) {
      const Index3 at = deinterleave(word);
      inside = bits_within({size.x - 4 * at.x, size.y - 4 * at.y, size.z - 4 * at.z});
      if (!is_first) place = interleave({at.x + offset.x, at.y + offset.y, at.z + offset.z});
    }
    if (!visit(word, place, inside)) return;
  }
}

// Finds the words of a cell by their codes in it.
template <class Tree>
class CellWords {
 public:
  CellWords(const Tree& tree, const Index3& voxel)
      : tree_(tree), cell_(cell_at(tree, {voxel.x & ~63, voxel.y & ~63, voxel.z & ~63})) {}

  TreeChild at(std::uint64_t word) {
    if (!cell_.is_stored) return cell_;
    const auto bit = static_cast<int>(word >> 6);
    if (bit != bit_) {
      bit_ = bit;
      cube_ = child_at(tree_, kCellRank, cell_.place, bit);
    }
    if (!cube_.is_stored) return cube_;
    return child_at(tree_, 0, cube_.place, static_cast<int>(word & 63));
  }

 private:
  const Tree& tree_;
  TreeChild cell_;
  int bit_ = -1;
  TreeChild cube_;  // of 16^3 voxels, at bit_
};

template <class Tree>
void gather(const Tree& tree, const Box& box, LabelWords& words) {
  words.parts.clear();
  CellWords<Tree> cell(tree, box.lo);
  visit_places(box, [&](std::size_t word, std::uint64_t place, std::uint64_t inside) {
    words.first[word] = static_cast<std::uint32_t>(words.parts.size());
    if (inside == 0) return true;
    const TreeChild child = cell.at(place);
    if (!child.is_stored) {
      words.parts.push_back({static_cast<std::uint32_t>(child.place), inside});
      return true;
    }
    visit_word(tree, child.place, [&](std::uint32_t label, std::uint64_t bits) {
      if ((bits & inside) != 0) words.parts.push_back({label, bits & inside});
    });
    return true;
  });
  words.first.back() = static_cast<std::uint32_t>(words.parts.size());
  choose_labels(labels_of(tree), words);
}

template <class Tree>
std::optional<std::int64_t> find_only_label(const Tree& tree, const Box& box) {
  CellWords<Tree> cell(tree, box.lo);
  std::uint32_t only = kNoLabel;
  bool is_one = true;
  const auto take = [&](std::uint32_t label) {
    is_one = is_one && (only == kNoLabel || only == label);
    only = label;
  };
  visit_places(box, [&](std::size_t, std::uint64_t place, std::uint64_t inside) {
    if (inside == 0) return true;
    const TreeChild child = cell.at(place);
    if (child.is_stored) {
      visit_word(tree, child.place, [&](std::uint32_t label, std::uint64_t bits) {
        if ((bits & inside) != 0) take(label);
      });
    } else {
      take(static_cast<std::uint32_t>(child.place));
    }
    return is_one;
  });
  return is_one ? std::optional(labels_of(tree)[only]) : std::nullopt;
}

}  // namespace

void words_of(const MaskTree& tree, const Box& box, LabelWords& words) {
  gather(tree, box, words);
}

void words_of(const LabelTree& tree, const Box& box, LabelWords& words) {
  gather(tree, box, words);
}

std::optional<std::int64_t> only_label(const MaskTree& tree, const Box& box) {
  return find_only_label(tree, box);
}

std::optional<std::int64_t> only_label(const LabelTree& tree, const Box& box) {
  return find_only_label(tree, box);
}

}  // namespace octavo
