#include "octavo/ops/mask/mask_transform.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>
#include <vector>

#include "octavo/ops/mask/mask_pieces.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/ops/mask/word_neighbors.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr MaskCube kFullCube{kFullWord, 0, 0};

std::size_t index(int number) { return static_cast<std::size_t>(number); }

// The rank at which work on a tree is split: the coarsest with work for all, the root for little.
int rank_of_tasks(const MaskTree& mask) {
  const int top = mask.rank_count() - 1;
  const std::size_t tasks = mask.words().size() / kWordsPerTask;
  if (tasks < 2) return top;
  int rank = top - 1;
  while (rank > 1 && mask.cubes(rank).size() < 4 * tasks) --rank;
  return rank;
}

// The tree of `count` cubes, the i-th made by make(i, part), which appends to the part; in runs on
// all threads.
template <class Make>
MaskTree made_in_parts(const Size3& size, int rank, std::size_t count, std::size_t words,
                       const Make& make) {
  const std::size_t tasks = std::max<std::size_t>(words / kWordsPerTask, 1);
  std::vector<MaskPart> parts(std::min(tasks, count));
  parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    parts[i].below = arrays_below(rank);
    const std::size_t end = (i + 1) * count / parts.size();
    for (std::size_t at = i * count / parts.size(); at < end; ++at) make(at, parts[i]);
  });
  return assemble(size, rank, parts);
}

// ---- turns

/// The permutation of 64 children that a turn makes, applied by a table for every byte.
class BitTurn {
 public:
  explicit BitTurn(const AxisTurn& turn) {
    for (int bit = 0; bit < 64; ++bit) {
      const Index3 at = deinterleave(static_cast<std::uint64_t>(bit));
      source_[index(bit)] = static_cast<int>(interleave(source_of(at, {4, 4, 4}, turn)));
    }
    for (int bit = 0; bit < 64; ++bit) {
      const int from = source_[index(bit)];
      auto& table = tables_[index(from / 8)];
      for (std::size_t byte = 0; byte < 256; ++byte) {
        if ((byte >> from % 8 & 1) != 0) table[byte] |= std::uint64_t{1} << bit;
      }
    }
  }

  std::uint64_t operator()(std::uint64_t word) const {
    std::uint64_t result = 0;
    for (std::size_t i = 0; i < 8; ++i) result |= tables_[i][word >> 8 * i & 0xff];
    return result;
  }

  /// The child that comes to stand at `bit`.
  int source(int bit) const { return source_[index(bit)]; }

 private:
  std::array<int, 64> source_{};
  std::array<std::array<std::uint64_t, 256>, 8> tables_{};
};

/// Turns sub-trees; what it makes is appended to `out`.
class Turner {
 public:
  Turner(const MaskTree& from, const BitTurn& bits, MaskArrays& out)
      : from_(from), bits_(bits), out_(out) {}

  MaskCube turn(int rank, const MaskCube& cube) {
    MaskCube made{bits_(cube.full), bits_(cube.mixed), 0};
    if (rank == 0) {
      made.first = out_.words.size();
      for (std::uint64_t left = made.mixed; left != 0; left &= left - 1) {
        const int source = bits_.source(std::countr_zero(left));
        out_.words.push_back(bits_(from_.words()[cube.place_of(source)]));
      }
      return made;
    }
    auto& below = out_.cubes[index(rank - 1)];
    made.first = below.size();
    for (std::uint64_t left = made.mixed; left != 0; left &= left - 1) {
      const int source = bits_.source(std::countr_zero(left));
      const MaskCube child = turn(rank - 1, from_.cubes(rank - 1)[cube.place_of(source)]);
      below.push_back(child);
    }
    return made;
  }

 private:
  const MaskTree& from_;
  const BitTurn& bits_;
  MaskArrays& out_;
};

// Turns the whole universe of the tree.
MaskTree turned_universe(const MaskTree& mask, const AxisTurn& turn) {
  const BitTurn bits(turn);
  const int rank = rank_of_tasks(mask);
  std::vector<MaskPiece> pieces = pieces_at(mask, rank);
  // Cubes of the rank along the universe.
  const std::int64_t side = child_side(mask.rank_count() - 1 - rank) / 4;
  AxisTurn back;  // from a source cube to its place in the turned universe
  for (int a = 0; a < 3; ++a) {
    back.from[index(turn.from[index(a)])] = a;
    back.is_reversed[index(turn.from[index(a)])] = turn.is_reversed[index(a)];
  }
  for (MaskPiece& piece : pieces) {
    piece.code = interleave(source_of(deinterleave(piece.code), {side, side, side}, back));
  }
  std::sort(pieces.begin(), pieces.end(),
            [](const MaskPiece& a, const MaskPiece& b) { return a.code < b.code; });
  return made_in_parts(turned(mask.size(), turn), rank, pieces.size(), mask.words().size(),
                       [&](std::size_t i, MaskPart& part) {
                         Turner turner(mask, bits, part.below);
                         const MaskCube made = turner.turn(rank, pieces[i].cube);
                         if (!made.is_empty()) part.pieces.push_back({pieces[i].code, made});
                       });
}

// ---- shifts

/// Eight neighboring words, at 4z + 2x + y, of which one is taken that begins inside the first.
using Eight = std::array<std::uint64_t, 8>;

// The 4 slabs from slab `from` (0..4) on of two words that follow each other on an axis.
inline std::uint64_t joined(std::uint64_t low, std::uint64_t high, int axis, std::int64_t from) {
  constexpr std::array<int, 3> kTwoSteps = {16, 8, 32};
  const int whole = word_detail::kWhole[index(axis)];  // three steps
  switch (from) {
    case 0: return low;
    case 1: return step_down(low, axis) | (high & slab_of(axis, 0)) << whole;
    case 2: {
      const std::uint64_t lower = slab_of(axis, 0) | slab_of(axis, 1);
      return (low & ~lower) >> kTwoSteps[index(axis)] | (high & lower) << kTwoSteps[index(axis)];
    }
    case 3: return (low & slab_of(axis, 3)) >> whole | step_up(high, axis);
    default: return high;
  }
}

// The word that begins at `from`, 0..4 on each axis.
std::uint64_t word_within(const Eight& words, const Index3& from) {
  std::array<std::uint64_t, 2> halves{};
  for (std::size_t z = 0; z < 2; ++z) {
    const std::uint64_t y0 = joined(words[4 * z], words[4 * z + 2], 0, from.x);
    const std::uint64_t y1 = joined(words[4 * z + 1], words[4 * z + 3], 0, from.x);
    halves[z] = joined(y0, y1, 1, from.y);
  }
  return joined(halves[0], halves[1], 2, from.z);
}

std::int64_t floor_of(std::int64_t number, std::int64_t side) {
  return number >= 0 ? number / side : -((side - 1 - number) / side);
}

/// Eight neighboring cubes of the source, at 4z + 2x + y, empty ones where there are none.
using Window = std::array<MaskCube, 8>;

/// Makes cubes out of windows of source cubes; what it makes is appended to `out`.
class Shifter {
 public:
  Shifter(const MaskTree& from, MaskArrays& out) : from_(from), out_(out) {}

  /// The cube that begins `offset` voxels inside the first cube of the window.
  /// offset  below the side of a cube of the rank on every axis
  MaskCube cube(int rank, const Window& window, const Index3& offset) {
    const std::int64_t side = child_side(rank);
    const Index3 first{offset.x / side, offset.y / side, offset.z / side};
    const Index3 rest{offset.x % side, offset.y % side, offset.z % side};
    const auto [full, some] = children_of(window, first, rest);
    if (full == kFullWord || some == 0) return {full, 0, 0};
    if (rank == 0) return cube_of_words(window, first, rest, full, some);

    auto& below = out_.cubes[index(rank - 1)];
    MaskCube made{full, 0, below.size()};
    for (std::uint64_t left = some & ~full; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      const Index3 at = place(first, bit);
      if (rest == Index3{}) {
        const std::uint64_t stored = window[half(at, 0)].place_of(child_bit(at, 0));
        append_cubes(from_, rank - 1, stored, stored + 1, false, out_);
        made.mixed |= std::uint64_t{1} << bit;
        continue;
      }
      Window children;
      for (int i = 0; i < 8; ++i) {
        if (is_needed(i, rest)) children[index(i)] = child(rank, window[half(at, i)], at, i);
      }
      add_child(cube(rank - 1, children, rest), bit, made, below);
    }
    return made;
  }

 private:
  // Of the children: those that are full, and those that are not empty but for what is below.
  static std::pair<std::uint64_t, std::uint64_t> children_of(const Window& window,
                                                             const Index3& first,
                                                             const Index3& rest) {
    Eight full_words{};
    Eight some_words{};
    for (std::size_t i = 0; i < 8; ++i) {
      full_words[i] = window[i].full;
      some_words[i] = window[i].full | window[i].mixed;
    }
    std::uint64_t full = kFullWord;
    std::uint64_t some = 0;
    for (int i = 0; i < 8; ++i) {
      if (!is_needed(i, rest)) continue;
      const Index3 from = beyond(first, i);
      full &= word_within(full_words, from);
      some |= word_within(some_words, from);
    }
    return {full, some};
  }

  // Which of eight neighbors a child that begins at `rest` reaches into.
  static bool is_needed(int i, const Index3& rest) {
    return ((i & 2) == 0 || rest.x != 0) && ((i & 1) == 0 || rest.y != 0) &&
           ((i & 4) == 0 || rest.z != 0);
  }

  static Index3 beyond(const Index3& at, int i) {
    return {at.x + (i >> 1 & 1), at.y + (i & 1), at.z + (i >> 2 & 1)};
  }

  // The first source child of the child at `bit`, 0..7 over two cubes on each axis.
  static Index3 place(const Index3& first, int bit) {
    // Bits z1 x1 y1 z0 x0 y0, as deinterleave reads them.
    return {first.x + ((bit >> 1 & 1) | (bit >> 3 & 2)), first.y + ((bit & 1) | (bit >> 2 & 2)),
            first.z + ((bit >> 2 & 1) | (bit >> 4 & 2))};
  }

  // The cube of the window, and the child of it, that hold the i-th neighbor of `at`.
  static std::size_t half(const Index3& at, int i) {
    const Index3 p = beyond(at, i);
    return static_cast<std::size_t>((p.z >> 2) << 2 | (p.x >> 2) << 1 | p.y >> 2);
  }
  static int child_bit(const Index3& at, int i) {
    const Index3 p = beyond(at, i);
    // Two bits of a coordinate, as interleave spreads them.
    constexpr std::array<int, 4> kSpread = {0, 1, 8, 9};
    return kSpread[static_cast<std::size_t>(p.z & 3)] << 2 |
           kSpread[static_cast<std::size_t>(p.x & 3)] << 1 |
           kSpread[static_cast<std::size_t>(p.y & 3)];
  }

  MaskCube child(int rank, const MaskCube& parent, const Index3& at, int i) const {
    const int bit = child_bit(at, i);
    if ((parent.mixed >> bit & 1) != 0) return from_.cubes(rank - 1)[parent.place_of(bit)];
    return (parent.full >> bit & 1) != 0 ? kFullCube : MaskCube{};
  }

  MaskCube cube_of_words(const Window& window, const Index3& first, const Index3& rest,
                         std::uint64_t full, std::uint64_t some) {
    WordCube words;
    for (std::uint64_t left = some & ~full; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      const Index3 at = place(first, bit);
      Eight eight{};
      for (int i = 0; i < 8; ++i) {
        if (!is_needed(i, rest)) continue;
        const MaskCube& parent = window[half(at, i)];
        const int source = child_bit(at, i);
        eight[index(i)] = (parent.mixed >> source & 1) != 0
                              ? from_.words()[parent.place_of(source)]
                              : -(parent.full >> source & 1);
      }
      words.add(bit, word_within(eight, rest));
    }
    MaskCube made = words.finish(out_.words);
    made.full |= full;
    return made;
  }

  const MaskTree& from_;
  MaskArrays& out_;
};

// The cube of `rank` at a place among the cubes of its rank; empty outside the universe.
MaskCube cube_at(const MaskTree& mask, int rank, const Index3& place) {
  const int top = mask.rank_count() - 1;
  const std::int64_t side = child_side(top - rank) / 4;
  if (!Box{{0, 0, 0}, {side, side, side}}.contains(place)) return {};
  const std::uint64_t code = interleave(place);
  MaskCube cube = mask.root();
  for (int r = top; r > rank; --r) {
    const auto bit = static_cast<int>(code >> 6 * (r - 1 - rank) & 63);
    if ((cube.full >> bit & 1) != 0) return kFullCube;
    if ((cube.mixed >> bit & 1) == 0) return {};
    cube = mask.cubes(r - 1)[cube.place_of(bit)];
  }
  return cube;
}

// The codes of all cubes of `rank` that moved pieces reach into.
std::vector<std::uint64_t> reached(const MaskTree& mask, int rank, const Index3& by) {
  const std::int64_t side = child_side(rank + 1);
  const std::int64_t across = child_side(mask.rank_count() - 1 - rank) / 4;
  const Box universe{{0, 0, 0}, {across, across, across}};
  std::vector<std::uint64_t> codes;
  for (const MaskPiece& piece : pieces_at(mask, rank)) {
    const Index3 from = deinterleave(piece.code);
    for (int i = 0; i < 8; ++i) {
      Index3 to;
      bool is_met = true;
      for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t whole = floor_of(by[axis], side);
        const bool is_second = (i >> axis & 1) != 0;
        is_met = is_met && (!is_second || whole * side != by[axis]);
        to[axis] = from[axis] + whole + (is_second ? 1 : 0);
      }
      if (is_met && universe.contains(to)) codes.push_back(interleave(to));
    }
  }
  std::sort(codes.begin(), codes.end());
  codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
  return codes;
}

// Moves voxels in the universe of the tree; those that come to lie outside the volume stay.
MaskTree shifted_universe(const MaskTree& mask, const Index3& by) {
  const int rank = rank_of_tasks(mask);
  const std::int64_t side = child_side(rank + 1);
  const std::vector<std::uint64_t> codes = reached(mask, rank, by);
  return made_in_parts(
      mask.size(), rank, codes.size(), mask.words().size(), [&](std::size_t i, MaskPart& part) {
        const Index3 at = deinterleave(codes[i]);
        Index3 first;
        Index3 offset;
        for (int axis = 0; axis < 3; ++axis) {
          const std::int64_t start = at[axis] * side - by[axis];
          first[axis] = floor_of(start, side);
          offset[axis] = start - first[axis] * side;
        }
        Window window;
        for (int k = 0; k < 8; ++k) {
          window[index(k)] =
              cube_at(mask, rank,
                      {first.x + (k >> 1 & 1), first.y + (k & 1), first.z + (k >> 2 & 1)});
        }
        const MaskCube made = Shifter(mask, part.below).cube(rank, window, offset);
        if (!made.is_empty()) part.pieces.push_back({codes[i], made});
      });
}

}  // namespace

MaskTree turned(const MaskTree& mask, const AxisTurn& turn) {
  MaskTree result = turned_universe(mask, turn);
  // Reversed axes end where the universe ends: back to the corner.
  const std::int64_t universe = child_side(mask.rank_count());
  Index3 by;
  for (int axis = 0; axis < 3; ++axis) {
    if (turn.is_reversed[index(axis)]) by[axis] = result.size()[axis] - universe;
  }
  return by == Index3{} ? result : shifted_universe(result, by);
}

MaskTree shifted(const MaskTree& mask, const Index3& by) {
  bool reaches_out = false;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(by[axis]) >= mask.size()[axis]) return MaskTree(mask.size());
    reaches_out = reaches_out || by[axis] > 0;
  }
  if (by == Index3{}) return mask;
  MaskTree moved = shifted_universe(mask, by);
  if (!reaches_out) return moved;
  return combine(moved, box_mask(mask.size(), box_of(mask.size())), SetOperation::intersect);
}

}  // namespace octavo
