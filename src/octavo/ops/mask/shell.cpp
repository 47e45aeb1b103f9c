#include "octavo/ops/mask/shell.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

#include "octavo/octree/word_steps.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

// Sub-trees of a cube are visited by tasks of their own down to this rank.
constexpr int kSplitRank = 2;

constexpr std::array<int, 3> kOctantStep = {16, 8, 32};  // bits from an octant to the next, by axis

/// What stands at one place of the grid of cubes of a rank (-1: words): a stored one, or nothing
/// but full or empty ones.
struct ShellItem {
  const MaskCube* cube = nullptr;  ///< null: `bits` says all
  std::uint64_t bits = 0;          ///< the full children
};

/// The six neighbors of an item: [axis][0] on the low side, [axis][1] on the high one.
using Beside = std::array<std::array<ShellItem, 2>, 3>;

/// Bits one step towards the low side, those of the next word coming in at 3.
std::uint64_t from_above(std::uint64_t here, std::uint64_t next, int axis) {
  const int whole = word_detail::kWhole[static_cast<std::size_t>(axis)];
  return step_down(here, axis) | (next & slab_of(axis, 0)) << whole;
}

std::uint64_t from_below(std::uint64_t here, std::uint64_t next, int axis) {
  const int whole = word_detail::kWhole[static_cast<std::size_t>(axis)];
  return step_up(here, axis) | (next & slab_of(axis, 3)) >> whole;
}

/// The full octants of a word, all eight bits of each.
std::uint64_t octants_of(std::uint64_t bits) { return full_octants(bits) * 0xff; }

/// The full children that are seen, of an item whose full children are `bits`.
std::uint64_t seen(std::uint64_t bits, const Beside& beside) {
  const std::uint64_t octants = octants_of(bits);
  std::uint64_t hidden = bits & ~octants;
  std::uint64_t hidden_octants = octants;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const std::uint64_t below = beside[a][0].bits;
    const std::uint64_t above = beside[a][1].bits;
    hidden &= from_above(bits, above, axis) & from_below(bits, below, axis);
    if (hidden_octants == 0) continue;
    const std::uint64_t low = slab_of(axis, 0) | slab_of(axis, 1);
    const int step = kOctantStep[a];
    hidden_octants &= (octants & ~low) >> step | (octants_of(above) & low) << step;
    hidden_octants &= (octants & low) << step | (octants_of(below) & ~low) >> step;
  }
  return bits & ~(hidden | hidden_octants);
}

/// Marks what is seen of every stored cube and word, all sub-trees at once.
class Marker {
 public:
  Marker(const MaskTree& mask, MaskArrays& marked) : mask_(mask), marked_(marked) {}

  void mark() {
    const MaskCube& root = mask_.root();
    mark_cube(mask_.rank_count() - 1, 0, {&root, root.full}, {});
  }

 private:
  // The child of an item at `bit`, an item of `rank` - 1.
  ShellItem child_of(int rank, const ShellItem& item, int bit) const {
    if (item.cube != nullptr && (item.cube->mixed >> bit & 1) != 0) {
      const std::uint64_t place = item.cube->place_of(bit);
      if (rank == 0) return {nullptr, mask_.words()[place]};
      const MaskCube& child = mask_.cubes(rank - 1)[place];
      return {&child, child.full};
    }
    return {nullptr, -(item.bits >> bit & 1)};
  }

  void mark_cube(int rank, std::uint64_t place, const ShellItem& item, const Beside& beside) {
    marked_.cubes[static_cast<std::size_t>(rank)][place].full = seen(item.bits, beside);
    const std::uint64_t mixed = item.cube->mixed;
    if (rank >= kSplitRank && (mixed & (mixed - 1)) != 0) {
      parallel_for(0, 64, [&](int bit) {
        if ((mixed >> bit & 1) != 0) mark_child(rank, item, beside, bit);
      });
      return;
    }
    for (std::uint64_t left = mixed; left != 0; left &= left - 1) {
      mark_child(rank, item, beside, std::countr_zero(left));
    }
  }

  void mark_child(int rank, const ShellItem& item, const Beside& beside, int bit) {
    Beside around;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int low = 1 << kLowPlace[axis];
      const int high = 1 << kHighPlace[axis];
      const int at = ((bit & low) != 0 ? 1 : 0) + ((bit & high) != 0 ? 2 : 0);
      const int rest = bit & ~(low | high);
      const auto number = [&](int where) {
        return rest | ((where & 1) != 0 ? low : 0) | ((where & 2) != 0 ? high : 0);
      };
      around[axis][0] = at > 0 ? child_of(rank, item, number(at - 1))
                               : child_of(rank, beside[axis][0], number(3));
      around[axis][1] = at < 3 ? child_of(rank, item, number(at + 1))
                               : child_of(rank, beside[axis][1], number(0));
    }
    const std::uint64_t place = item.cube->place_of(bit);
    if (rank == 0) {
      marked_.words[place] = seen(mask_.words()[place], around);
    } else {
      mark_cube(rank - 1, place, child_of(rank, item, bit), around);
    }
  }

  const MaskTree& mask_;
  MaskArrays& marked_;
};

/// Takes out the children that have become empty; `is_empty(i)` of those below says which.
template <class Child, class IsEmpty>
void close_gaps(std::vector<MaskCube>& cubes, std::vector<Child>& children, IsEmpty is_empty) {
  std::uint64_t kept = 0;
  for (MaskCube& cube : cubes) {
    const std::uint64_t first = kept;
    std::uint64_t from = cube.first;
    std::uint64_t mixed = 0;
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1, ++from) {
      if (is_empty(children[from])) continue;
      children[kept++] = children[from];
      mixed |= left & (~left + 1);
    }
    cube.mixed = mixed;
    cube.first = first;
  }
  children.resize(kept);
  children.shrink_to_fit();
}

void grow_box(const MaskTree& mask, int rank, const MaskCube& cube, const Index3& corner,
              Box& box) {
  const std::int64_t side = child_side(rank);
  box = united(box, box_of_children(cube.full, corner, side));
  for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    const Box child = child_box(corner, bit, side);
    if (box.contains(child)) continue;
    const std::uint64_t place = cube.place_of(bit);
    if (rank == 0) {
      box = united(box, box_of_children(mask.words()[place], child.lo, 1));
    } else {
      grow_box(mask, rank - 1, mask.cubes(rank - 1)[place], child.lo, box);
    }
  }
}

}  // namespace

MaskTree shell(const MaskTree& mask) {
  // Mark what is seen, at the places of the mask.
  MaskArrays made;
  made.words.resize(mask.words().size());
  for (int rank = 0; rank < mask.rank_count(); ++rank) {
    made.cubes.emplace_back(mask.cubes(rank).begin(), mask.cubes(rank).end());
  }
  Marker(mask, made).mark();

  // Close the gaps, from the words up.
  close_gaps(made.cubes[0], made.words, [](std::uint64_t word) { return word == 0; });
  for (std::size_t rank = 1; rank < made.cubes.size(); ++rank) {
    close_gaps(made.cubes[rank], made.cubes[rank - 1],
               [](const MaskCube& cube) { return cube.is_empty(); });
  }
  return {mask.size(), std::move(made)};
}

std::int64_t leaf_count(const MaskTree& mask) {
  const std::vector<std::int64_t> counts = leaf_counts(mask);
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

Box bounding_box(const MaskTree& mask) {
  Box box;
  grow_box(mask, mask.rank_count() - 1, mask.root(), {0, 0, 0}, box);
  return box;
}

}  // namespace octavo
