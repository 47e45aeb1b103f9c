// The corners of the cells of a mesh, numbered, and those that hang.
//
// Corners are bits: a word for 4 x 4 x 4 points in o-code order, 64 words for a block of 16^3
// points. The number of a corner is the count of those before its word and of the bits before its
// own; those that hang are counted after all others. A node hangs when it is the middle of an edge
// or a face of a cell; its position says of which, and so what it depends on:
//
//     the lowest bit that any coordinate has, 2^t, is the side of the smaller cells;
//     one coordinate has it:   the middle of an edge, of the nodes 2^t before and behind
//     two coordinates have it: the middle of a face, of the nodes 2^t away along both
//
// Requires  cells that touch differ by one level at most (leaf_balance.h)
// Source    ranks of bits: Jacobson, Space-efficient static trees and graphs, 1989
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/mesh/hexahedra/hex_cell.h"

namespace octavo {

/// The largest number of nodes or elements: solvers count in 32 bits.
inline constexpr std::uint64_t kMostHexNodes = 0x7fffffff;

/// What a hanging node is the mean of: two nodes or four.
struct HexMasters {
  std::array<std::uint32_t, 4> nodes{};
  int count = 0;
};

/// Of a point in its block of 16^3: a word of the block, and one bit of it.
struct NodePlace {
  std::size_t word = 0;
  std::uint64_t bit = 0;
};

class HexNodes {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  /// Of the 27 points of a cell the corners.
  static constexpr std::uint32_t kCornerPoints =
      1u | 1u << 2 | 1u << 6 | 1u << 8 | 1u << 18 | 1u << 20 | 1u << 24 | 1u << 26;

  /// Remembers the blocks around the last cell that was asked for, which are mostly those of the
  /// next one. Of one HexNodes and one thread.
  struct Near {
    GridPoint at = {kNone, kNone, kNone};  ///< of the lowest block, in blocks
    std::array<std::uint32_t, 8> blocks{};
  };

  HexNodes() = default;

  /// Uses the threads of the calling task arena; the numbers do not depend on them.
  /// Throws Error{limit_exceeded} above kMostHexNodes, Error{cancelled}.
  explicit HexNodes(std::span<const HexCell> cells, const Progress& watcher = NoProgress());

  std::uint64_t count() const noexcept { return count_; }
  std::uint64_t hanging_count() const noexcept { return hanging_count_; }

  /// The number of the node at a point; kNone where there is none.
  std::uint32_t number_at(const GridPoint& point) const noexcept;

  /// Whether the node of a number hangs.
  bool is_hanging(std::uint32_t number) const noexcept { return number >= count_ - hanging_count_; }

  /// The corners of a cell in the order of kHexCorners.
  std::array<std::uint32_t, 8> corners_of(const HexCell& cell, Near& near) const noexcept;

  /// What the hanging node at `point` depends on; none of it hangs.
  HexMasters masters_of(const GridPoint& point) const noexcept;

  /// Which of the 27 points of a cell, [z][y][x] of its corners, middles and center, are nodes: a
  /// bit each. Requires a cell above level 0.
  std::uint32_t points_of(const HexCell& cell, Near& near) const noexcept;

  /// Calls visit(point, number) for the nodes that do not hang, then for those that do, as they are
  /// numbered.
  template <class Visit>
  void visit(Visit&& visit) const;

  /// The same for those that hang alone.
  template <class Visit>
  void visit_hanging(Visit&& visit) const;

  /// Bytes per block of 16^3 points, its entry in the table included.
  static constexpr std::uint64_t kBlockBytes = 1650;
  std::uint64_t memory_bytes() const noexcept { return blocks_.size() * kBlockBytes; }

 private:
  struct Block {
    std::uint64_t code = 0;
    /// Those that do not hang, and those that do.
    std::array<std::array<std::uint64_t, 64>, 2> nodes{};
    /// Of each of the two the number of the first node of each word.
    std::array<std::array<std::uint32_t, 64>, 2> first{};
  };
  std::uint32_t find(const GridPoint& block) const noexcept;
  void look_around(const HexCell& cell, Near& near) const noexcept;
  std::uint32_t block_of(const GridPoint& point, const Near& near) const noexcept;
  std::uint32_t number_in(std::uint32_t block, const NodePlace& place) const noexcept;
  template <class Visit>
  void visit_corners(const HexCell& cell, const Near& near, Visit&& visit) const;
  template <class Visit>
  void visit_middles(const HexCell& cell, const Near& near, Visit&& visit) const;
  void make_blocks(std::span<const HexCell> cells, const Progress& watcher);
  void set_corners(std::span<const HexCell> cells, const Progress& watcher);
  void find_hanging(std::span<const HexCell> cells, const Progress& watcher);
  void number_nodes();
  template <class Visit>
  void visit_kind(std::size_t kind, Visit& visit) const;

  std::vector<Block> blocks_;  ///< by code
  std::unordered_map<std::uint64_t, std::uint32_t> places_;
  std::uint64_t count_ = 0;
  std::uint64_t hanging_count_ = 0;
};

// ---- implementation of the templates

template <class Visit>
void HexNodes::visit_kind(std::size_t kind, Visit& visit) const {
  auto number = static_cast<std::uint32_t>(kind == 0 ? 0 : count_ - hanging_count_);
  for (const Block& block : blocks_) {
    for (std::size_t word = 0; word < 64; ++word) {
      for (std::uint64_t left = block.nodes[kind][word]; left != 0; left &= left - 1) {
        const auto bit = static_cast<std::uint64_t>(std::countr_zero(left));
        const Index3 at = deinterleave(block.code << 12 | word << 6 | bit);
        visit(GridPoint{static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y),
                        static_cast<std::uint32_t>(at.z)},
              number++);
      }
    }
  }
}

template <class Visit>
void HexNodes::visit(Visit&& visit) const {
  visit_kind(0, visit);
  visit_kind(1, visit);
}

template <class Visit>
void HexNodes::visit_hanging(Visit&& visit) const {
  visit_kind(1, visit);
}

}  // namespace octavo
