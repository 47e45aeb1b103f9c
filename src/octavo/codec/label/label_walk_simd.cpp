// The label traversal for every instruction set that Highway knows, chosen at run time.

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

#include "octavo/codec/label/label_portable.h"
#include "octavo/codec/simd_level.h"

#include "octavo/codec/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/codec/label/label_walk_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

using portable::Around;

#else

namespace hn = hwy::HWY_NAMESPACE;

/// Where the neighbors of a child lie among the 64 cells around its octant, and their votes.
///
/// The cells at -1 .. 2 along z, y and x from the first child form four planes of four rows of
/// four. The codes of a plane are 16 bytes: those of rows 0 and 2 alternate, then those of rows 1
/// and 3.
struct Layout {
  /// Bytes for neighbors 0 .. 15 (low) and 16 .. 31 (high): from the plane towards the siblings,
  /// the child's own, the one away from them and the one beyond the siblings; from the cells two
  /// steps away from the siblings.
  alignas(16) std::uint8_t low_inner[16], low_own[16], low_far[16];
  alignas(16) std::uint8_t high_own[16], high_outer[16], high_beyond[16], high_far[16];
  alignas(16) std::uint8_t child[16];  ///< 0xff at the child itself in its plane
};

constexpr int kNone = 0x80;

constexpr int plane_byte(int y, int x) { return 2 * (4 * (y & 1) + x) + y / 2; }

constexpr Layout layout(int digit) {
  Layout result{};
  const int x = 1 + (digit >> 1 & 1);
  const int y = 1 + (digit & 1);
  const int step_x = x == 1 ? -1 : 1;
  const int step_y = y == 1 ? -1 : 1;
  // Byte of the cell so many steps away from the siblings.
  const auto at = [&](int steps_x, int steps_y) {
    return static_cast<std::uint8_t>(plane_byte(y + step_y * steps_y, x + step_x * steps_x));
  };
  // Those two steps away along x lie in the odd bytes, along y and then z in the even ones.
  const auto far = [&](int axis) {
    const int child = 2 * (digit & 1) + (digit >> 1 & 1);
    return static_cast<std::uint8_t>(2 * child + (axis == 0 ? 1 : 8 * (axis - 1)));
  };
  for (auto* bytes : {result.low_inner, result.low_own, result.low_far, result.high_own,
                      result.high_outer, result.high_beyond, result.high_far}) {
    for (int k = 0; k < 16; ++k) bytes[k] = kNone;
  }
  for (int k = 0; k < 9; ++k) result.low_inner[k] = at(k % 3 - 1, k / 3 - 1);
  for (int k = 0; k < 3; ++k) result.low_own[9 + k] = at(k - 1, -1);
  for (int k = 0; k < 3; ++k) result.low_own[12 + k] = at(k == 2 ? 1 : k - 2, 0);
  result.low_far[15] = far(0);
  for (int k = 0; k < 3; ++k) result.high_own[k] = at(k - 1, 1);
  for (int k = 0; k < 9; ++k) result.high_outer[3 + k] = at(k % 3 - 1, k / 3 - 1);
  result.high_own[12] = at(0, -2);
  result.high_far[13] = far(1);
  result.high_beyond[14] = at(0, 0);
  result.high_far[15] = far(2);
  result.child[plane_byte(y, x)] = 0xff;
  return result;
}

constexpr Layout kLayouts[8] = {layout(0), layout(1), layout(2), layout(3),
                                layout(4), layout(5), layout(6), layout(7)};

/// The same for comparisons with other labels, from the rows around a child at the lower and at the
/// upper place along x.
///
///     lane           0    1    2    3
///     x             -1    0    1    2
///     own row, low  -1   -2    1    2        the child's own lane holds the far cell that its row
///     own row, up   -1    0    3    2        of four leaves out
struct RowLayout {
  alignas(16) std::uint8_t rows[16];    ///< bytes of four rows as neighbors 0 .. 11
  alignas(16) std::uint8_t along[16];   ///< bytes of the own row as neighbors 12 .. 15
  alignas(16) std::uint8_t across[16];  ///< bytes of those far along y and z as neighbors 28 .. 31
  alignas(16) LabelCell votes[5][8];    ///< of exactly known cells; 0 in lanes without a neighbor
  alignas(16) LabelCell halved[5][8];   ///< of cells that stand in for their parents
  alignas(16) LabelCell used[5][8];     ///< 0xffff in lanes with a neighbor
};

constexpr RowLayout row_layout(bool is_upper) {
  RowLayout result{};
  const int along[2][4] = {{3, 2, 0, 1}, {0, 1, 3, 2}};
  for (int k = 0; k < 16; ++k) {
    const int row = k / 3;
    const int lane = is_upper ? 1 + k % 3 : 2 - k % 3;
    // Two pairs of rows lie as a0 c0 a1 c1 .. b0 d0 b1 d1 ..
    const int row_byte = 2 * (4 * (row & 1) + lane) + row / 2;
    const int along_byte = 2 * along[is_upper][k & 3];
    result.rows[k] = static_cast<std::uint8_t>(k < 12 ? row_byte : 0x80);
    result.along[k] = static_cast<std::uint8_t>(k < 12 ? 0x80 : along_byte);
    result.across[k] = static_cast<std::uint8_t>(k < 12 ? 0x80 : 8 + 2 * (k - 12));
  }
  for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
    const std::size_t k = i & 15;
    const std::size_t row = k < 12 ? i / 16 * 2 + k / 6 : 4;
    const int lane = k < 12   ? result.rows[k] % 8 / 2 + 4 * (k / 3 & 1)
                     : i < 16 ? result.along[k] / 2
                              : result.across[k] / 2;
    result.votes[row][lane] = static_cast<LabelCell>(label_vote(i, kUniform));
    result.halved[row][lane] = static_cast<LabelCell>(label_vote(i, kParent));
    result.used[row][lane] = 0xffff;
  }
  return result;
}

constexpr RowLayout kRowLayouts[2] = {row_layout(false), row_layout(true)};

constexpr hn::FixedTag<LabelCell, 8> kCells{};
constexpr hn::FixedTag<std::uint8_t, 16> kBytes{};
using Cells = hn::Vec<hn::FixedTag<LabelCell, 8>>;
using CodeBytes = hn::Vec<hn::FixedTag<std::uint8_t, 16>>;

HWY_INLINE Cells two_rows(std::uint64_t low, std::uint64_t high) {
  const hn::FixedTag<std::uint64_t, 1> half;
  return hn::BitCast(kCells, hn::Combine(hn::FixedTag<std::uint64_t, 2>(), hn::Set(half, high),
                                         hn::Set(half, low)));
}

/// A code is 2 * state + equal. A byte holds it twice, in bits 0 .. 2 and 5 .. 7, so that what two
/// bytes say is the place of a row of weights as it stands.
constexpr unsigned twice(unsigned code) { return code | code << 5; }
constexpr LabelCell kPairBits = 0x07e0;   ///< of two bytes: 32 times the first code, 256 the second
constexpr LabelCell kEqualBits = 0x0120;  ///< those of "equal"
static_assert(2 * LabelNet::pair_offset(0, 1, 1) == kEqualBits);
static_assert(2 * LabelNet::pair_offset(0, 7, 7) == kPairBits);

/// The codes of cells compared to a slot.
HWY_INLINE Cells codes(Cells cells, Cells slot) {
  const auto state = hn::And(cells, hn::Set(kCells, 3));
  const auto is_equal = hn::VecFromMask(kCells, hn::Eq(hn::ShiftRight<2>(cells), slot));
  return hn::Sub(hn::Add(state, state), is_equal);
}

/// Codes of `low` in the even bytes, of `high` in the odd ones.
HWY_INLINE CodeBytes joined(Cells low, Cells high) {
  const auto both = hn::Or(low, hn::ShiftLeft<8>(high));
  return hn::BitCast(kBytes, hn::Or(both, hn::ShiftLeft<5>(both)));
}

HWY_INLINE CodeBytes shuffled(CodeBytes bytes, const std::uint8_t* order) {
  return hn::TableLookupBytesOr0(bytes, hn::Load(kBytes, order));
}

/// The neighbors of a child as a network is asked about them.
class Neighbors {
 public:
  HWY_INLINE void place(CodeBytes low, CodeBytes high) {
    const auto pair_bits = hn::Set(kCells, kPairBits);
    hn::Store(hn::And(hn::BitCast(kCells, low), pair_bits), kCells, pair_);
    hn::Store(hn::And(hn::BitCast(kCells, high), pair_bits), kCells, pair_ + 8);
    // Loading the offsets costs less than extracting them from the register, which is what
    // compilers make of it when they may.
    asm("" : "+m"(pair_));
  }

  /// As compared to the other label, where the neighbors have two.
  HWY_INLINE void flip() {
    for (std::size_t k = 0; k < kLabelPairs; k += 8) {
      hn::Store(hn::Xor(hn::Load(kCells, pair_ + k), hn::Set(kCells, kEqualBits)), kCells,
                pair_ + k);
    }
  }

  HWY_INLINE int logit(const LabelNet& net, std::size_t first, std::size_t second) const {
    const hn::CappedTag<std::int16_t, kLabelHidden> lanes;
    const hn::Repartition<std::int32_t, decltype(lanes)> sums;
    auto total = hn::Zero(sums);
    auto unused = hn::Zero(sums);
    for (std::size_t j = 0; j < kLabelHidden; j += hn::Lanes(lanes)) {
      auto even = hn::Load(lanes, net.categories(first, second) + j);
      auto odd = hn::Load(lanes, row(net, 0) + j);
      for (std::size_t k = 1; k + 1 < kLabelPairs; k += 2) {
        even = hn::Add(even, hn::Load(lanes, row(net, k) + j));
        odd = hn::Add(odd, hn::Load(lanes, row(net, k + 1) + j));
      }
      even = hn::Add(even, hn::Load(lanes, row(net, kLabelPairs - 1) + j));
      const auto sum = hn::Max(hn::Add(even, odd), hn::Zero(lanes));
      total = hn::ReorderWidenMulAccumulate(sums, sum, hn::Load(lanes, net.out() + j), total,
                                            unused);
    }
    return hn::GetLane(hn::SumOfLanes(sums, hn::Add(total, unused)));
  }

  void tell(LabelQuestion& question) const {
    for (std::size_t k = 0; k < kLabelPairs; ++k) {
      question.neighbor[2 * k] = static_cast<std::uint8_t>(pair_[k] >> 5 & 7);
      question.neighbor[2 * k + 1] = static_cast<std::uint8_t>(pair_[k] >> 8 & 7);
    }
  }

 private:
  /// Of weights of pair k.
  HWY_INLINE const std::int16_t* row(const LabelNet& net, std::size_t k) const {
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(net.pairs());
    constexpr std::size_t kPairBytes = 2 * LabelNet::pair_offset(1, 0, 0);
    return reinterpret_cast<const std::int16_t*>(bytes + kPairBytes * k + pair_[k]);
  }

  alignas(16) LabelCell pair_[kLabelPairs];  ///< bytes from the first row of each pair
};

/// Two cells in a row.
HWY_INLINE std::uint64_t two_cells(const LabelCell* at) {
  std::uint32_t two;
  std::memcpy(&two, at, sizeof two);
  return two;
}

/// Two cells, and two others.
HWY_INLINE std::uint64_t two_and_two(const LabelCell* low, const LabelCell* high) {
  return two_cells(low) | two_cells(high) << 32;
}

/// Makes codes of cells compared to a slot: of `low` in the even bytes, of `high` in the odd ones.
struct AnyCodes {
  explicit HWY_INLINE AnyCodes(std::uint32_t slot)
      : own(hn::Set(kCells, static_cast<LabelCell>(slot))) {}
  HWY_INLINE CodeBytes operator()(Cells low, Cells high) const {
    return joined(codes(low, own), codes(high, own));
  }
  Cells own;
};

/// The codes of cells where there are slots 0 and 1 alone: a cell is a number below 8 then.
struct CodesOfPairs {
  alignas(16) std::uint8_t of_cell[16];
};
constexpr CodesOfPairs codes_of_pairs(unsigned slot) {
  CodesOfPairs codes{};
  for (unsigned cell = 0; cell < 8; ++cell) {
    const unsigned is_equal = cell >> 2 == slot ? 1 : 0;
    codes.of_cell[cell] = static_cast<std::uint8_t>(twice(2 * (cell & 3) + is_equal));
  }
  return codes;
}
constexpr CodesOfPairs kCodesOfPairs[2] = {codes_of_pairs(0), codes_of_pairs(1)};

/// The same as AnyCodes there.
struct PairCodes {
  explicit HWY_INLINE PairCodes(std::uint32_t slot)
      : table(hn::Load(kBytes, kCodesOfPairs[slot].of_cell)) {}
  HWY_INLINE CodeBytes operator()(Cells low, Cells high) const {
    return hn::TableLookupBytes(table, hn::BitCast(kBytes, hn::Or(low, hn::ShiftLeft<8>(high))));
  }
  CodeBytes table;
};

/// The codes of the cells around an octant, compared to the label of its parent; they serve all
/// children.
class NearCodes {
 public:
  /// rows  gets the rows of four cells through the octant and beside it, [z][y], cells -1 .. 2
  ///       along x, from -1 along y and z
  template <class Codes>
  HWY_INLINE void look(const LabelCell* first, const LabelNeighborhood& offsets,
                       const Codes& codes_of, std::uint64_t (&rows)[4][4]) {
    const std::ptrdiff_t row_stride = offsets[1][29] / 2;
    const std::ptrdiff_t plane_stride = offsets[4][31] / 2;
    for (std::size_t z = 0; z < 4; ++z) {
      const LabelCell* plane = first + (static_cast<std::ptrdiff_t>(z) - 1) * plane_stride;
      for (std::size_t y = 0; y < 4; ++y) {
        const LabelCell* row = plane + (static_cast<std::ptrdiff_t>(y) - 1) * row_stride;
        std::uint64_t four;
        if ((z == 1 || z == 2) && (y == 1 || y == 2)) {
          // The cell before the first may belong to the octant visited just now.
          std::memcpy(&four, row, sizeof four);
          rows[z][y] = four << 16 | row[-1];
        } else {
          std::memcpy(&rows[z][y], row - 1, sizeof four);
        }
      }
      planes_[z] = codes_of(two_rows(rows[z][0], rows[z][1]), two_rows(rows[z][2], rows[z][3]));
    }
    for (std::size_t z = 0; z < 2; ++z) {
      const LabelCell* const plane = first + static_cast<std::ptrdiff_t>(z) * plane_stride;
      const LabelCell* const far_plane = first + (z == 0 ? -2 : 3) * plane_stride;
      const auto ends = [](const LabelCell* row) {
        return std::uint64_t{row[-2]} | std::uint64_t{row[3]} << 16;
      };
      const auto along_y_and_z =
          two_rows(two_and_two(plane - 2 * row_stride, plane + 3 * row_stride),
                   two_and_two(far_plane, far_plane + row_stride));
      const auto along_x = two_rows(ends(plane) | ends(plane + row_stride) << 32, 0);
      far_[z] = codes_of(along_y_and_z, along_x);
    }
  }

  /// The codes of the neighbors of a child. Where an axis is not halved, the places of the missing
  /// children are seen, but not asked for.
  HWY_INLINE void see(std::size_t digit, Neighbors& neighbors) const {
    const Layout& from = kLayouts[digit];
    const std::size_t z = digit >> 2 & 1;
    const CodeBytes own = planes_[1 + z];
    neighbors.place(
        hn::Or(hn::Or(shuffled(planes_[2 - z], from.low_inner), shuffled(own, from.low_own)),
               shuffled(far_[z], from.low_far)),
        hn::Or(hn::Or(shuffled(planes_[3 * z], from.high_outer), shuffled(own, from.high_own)),
               hn::Or(shuffled(planes_[3 - 3 * z], from.high_beyond),
                      shuffled(far_[z], from.high_far))));
  }

  /// A child has that code now.
  HWY_INLINE void settle(std::size_t digit, unsigned code) {
    CodeBytes& plane = planes_[1 + (digit >> 2 & 1)];
    const auto child = hn::Load(kBytes, kLayouts[digit].child);
    const auto settled = hn::Set(kBytes, static_cast<std::uint8_t>(twice(code)));
    plane = hn::Or(hn::AndNot(child, plane), hn::And(child, settled));
  }

 private:
  CodeBytes planes_[4];
  CodeBytes far_[2];  ///< of the far cells of lower and upper children
};

/// What is known around the children of an octant in a brick of two labels.
class PairAround {
 public:
  HWY_INLINE PairAround(const LabelCell* first, const LabelNeighborhood& offsets,
                        std::uint32_t parent) {
    std::uint64_t rows[4][4];
    near_.look(first, offsets, PairCodes(parent), rows);
  }

  HWY_INLINE void see(std::size_t digit) { near_.see(digit, neighbors_); }
  HWY_INLINE void flip() { neighbors_.flip(); }
  HWY_INLINE int logit(const LabelNet& net, std::size_t first, std::size_t second) const {
    return neighbors_.logit(net, first, second);
  }
  HWY_INLINE void settle(std::size_t digit, bool is_same, LabelState state) {
    near_.settle(digit, 2u * state + (is_same ? 1u : 0u));
  }
  void tell(LabelQuestion& question) const { neighbors_.tell(question); }

 private:
  NearCodes near_;
  Neighbors neighbors_;
};

/// What is known around the children of an octant.
///
/// The rows of four cells through an octant are kept beside the grid: loading them back from there
/// so soon after the narrow stores of single cells would stall.
class Around {
 public:
  using Pair = PairAround;

  HWY_INLINE Around(const LabelCell* first, const LabelNeighborhood& offsets, std::uint32_t parent)
      : offsets_(offsets), parent_(parent) {
    near_.look(first, offsets, AnyCodes(parent), rows_);
  }

  HWY_INLINE void see(const LabelCell* cell, std::size_t digit) {
    cell_ = cell;
    digit_ = digit;
    near_.see(digit, neighbors_);
  }

  HWY_INLINE void settle(std::size_t digit, LabelCell cell) {
    const std::size_t z = 1 + (digit >> 2 & 1);
    std::uint64_t& row = rows_[z][1 + (digit & 1)];
    row = with(row, digit, cell);
    near_.settle(digit, 2u * state_of(cell) + (slot_of(cell) == parent_ ? 1u : 0u));
  }

  /// As aim at the other label, where the neighbors have two.
  HWY_INLINE void flip() { neighbors_.flip(); }

  /// Requires propose before it.
  HWY_INLINE void aim(std::uint32_t slot) {
    const auto own = hn::Set(kCells, static_cast<LabelCell>(slot));
    const RowLayout& from = kRowLayouts[digit_ >> 1 & 1];
    const auto two = [&](std::size_t i) HWY_ATTR {
      return joined(codes(cells_[i], own), codes(cells_[i + 1], own));
    };
    const auto own_row = codes(cells_[4], own);
    const auto others = hn::BitCast(kBytes, hn::Or(own_row, hn::ShiftLeft<5>(own_row)));
    neighbors_.place(hn::Or(shuffled(two(0), from.rows), shuffled(others, from.along)),
                     hn::Or(shuffled(two(2), from.rows), shuffled(others, from.across)));
  }

  HWY_INLINE int logit(const LabelNet& net, std::size_t first, std::size_t second) const {
    return neighbors_.logit(net, first, second);
  }

  HWY_INLINE bool propose(LabelCandidates& candidates) {
    gather();
    const RowLayout& layout = kRowLayouts[digit_ >> 1 & 1];
    const auto own = hn::Set(kCells, static_cast<LabelCell>(parent_));
    // The complement of the label, which is not 0, of cells that propose something else than the
    // parent's; 0 in all other lanes.
    Cells open[5];
    for (std::size_t i = 0; i < 5; ++i) {
      const auto label = hn::ShiftRight<2>(cells_[i]);
      const auto is_closed = hn::Or(hn::Eq(cells_[i], hn::Zero(kCells)), hn::Eq(label, own));
      const auto proposed = hn::AndNot(label, hn::Load(kCells, layout.used[i]));
      open[i] = hn::IfThenZeroElse(is_closed, proposed);
    }
    LabelCell found = any_of(open);
    if (found == 0) return false;
    Cells rest[5];
    without(open, found, rest);
    LabelCell next = any_of(rest);
    if (next == 0) {
      candidates.append(label_of(found), 1);
      return true;
    }

    Cells votes[5];
    for (std::size_t i = 0; i < 5; ++i) {
      const auto state = hn::And(cells_[i], hn::Set(kCells, 3));
      votes[i] = hn::IfThenElse(hn::Eq(state, hn::Set(kCells, kParent)),
                                hn::Load(kCells, layout.halved[i]),
                                hn::Load(kCells, layout.votes[i]));
    }
    candidates.append(label_of(found), votes_for(found, open, votes));
    do {
      candidates.append(label_of(next), votes_for(next, rest, votes));
      without(rest, next, rest);
      next = any_of(rest);
    } while (next != 0);
    return false;
  }

  void tell(LabelQuestion& question) const { neighbors_.tell(question); }

 private:
  /// The rows around the child and the cells far from it.
  HWY_INLINE void gather() {
    const auto& at = offsets_[digit_];
    const std::size_t y = 1 + (digit_ & 1), z = 1 + (digit_ >> 2 & 1);
    // Towards the siblings and away from them, as rows.
    const std::size_t y_in = 3 - y, z_in = 3 - z;
    const std::size_t y_out = y == 1 ? 0 : 3, z_out = z == 1 ? 0 : 3;
    cells_[0] = two_rows(rows_[z_in][y_in], rows_[z_in][y]);
    cells_[1] = two_rows(rows_[z_in][y_out], rows_[z][y_in]);
    cells_[2] = two_rows(rows_[z][y_out], rows_[z_out][y_in]);
    cells_[3] = two_rows(rows_[z_out][y], rows_[z_out][y_out]);
    const std::uint64_t across =
        std::uint64_t{cell_[at[28]]} | std::uint64_t{cell_[at[29]]} << 16 |
        std::uint64_t{cell_[at[30]]} << 32 | std::uint64_t{cell_[at[31]]} << 48;
    cells_[4] = two_rows(with(rows_[z][y], digit_, cell_[at[15]]), across);
  }

  /// A row with the cell of the child of `digit` replaced.
  static HWY_INLINE std::uint64_t with(std::uint64_t row, std::size_t digit, LabelCell cell) {
    const std::size_t shift = (digit >> 1 & 1) != 0 ? 32 : 16;
    return (row & ~(std::uint64_t{0xffff} << shift)) | std::uint64_t{cell} << shift;
  }

  static std::uint32_t label_of(LabelCell proposed) {
    return static_cast<LabelCell>(~proposed);
  }

  /// One of the proposals; 0 where there is none.
  static HWY_INLINE LabelCell any_of(const Cells* open) {
    const hn::FixedTag<std::uint64_t, 2> halves;
    const auto most = hn::Max(hn::Max(hn::Max(open[0], open[1]), hn::Max(open[2], open[3])),
                              open[4]);
    const auto four = hn::BitCast(halves, most);
    const std::uint64_t low = hn::GetLane(four);
    const std::uint64_t found = low != 0 ? low : hn::ExtractLane(four, 1);
    return static_cast<LabelCell>(found >> (std::countr_zero(found | 1ull << 63) & 0x30));
  }

  static HWY_INLINE void without(const Cells* open, LabelCell proposed, Cells* rest) {
    const auto gone = hn::Set(kCells, proposed);
    for (std::size_t i = 0; i < 5; ++i) {
      rest[i] = hn::IfThenZeroElse(hn::Eq(open[i], gone), open[i]);
    }
  }

  static HWY_INLINE int votes_for(LabelCell proposed, const Cells* open, const Cells* votes) {
    const auto wanted = hn::Set(kCells, proposed);
    auto total = hn::Zero(kCells);
    for (std::size_t i = 0; i < 5; ++i) {
      total = hn::Add(total, hn::IfThenElseZero(hn::Eq(open[i], wanted), votes[i]));
    }
    // Five votes of at most 12 fit in the lower byte of a lane.
    const auto sums = hn::SumsOf8(hn::BitCast(kBytes, total));
    return static_cast<int>(hn::GetLane(sums) + hn::ExtractLane(sums, 1));
  }

  const LabelNeighborhood& offsets_;
  std::uint32_t parent_;
  std::size_t digit_ = 0;
  const LabelCell* cell_ = nullptr;
  std::uint64_t rows_[4][4];  ///< as NearCodes has found them, with the children's labels
  NearCodes near_;
  Neighbors neighbors_;
  Cells cells_[5];  ///< eight rows around, the own row, the cells far along y and z
};

#endif

#include "octavo/codec/label/label_walk-inl.h"

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo {

HWY_EXPORT(decode_labels);
HWY_EXPORT(encode_labels);
HWY_EXPORT(observe_labels);

namespace {

/// Those for the best of `targets`; the portable ones for none.
LabelWalkFunctions functions_of(std::int64_t targets) {
  if (targets == 0) return portable_label_walk_functions();
  const SimdTargetsInUse in_use(targets);
  return {HWY_DYNAMIC_DISPATCH(decode_labels), HWY_DYNAMIC_DISPATCH(encode_labels),
          HWY_DYNAMIC_DISPATCH(observe_labels)};
}

}  // namespace

const LabelWalkFunctions& label_walk_functions() {
  static const LabelWalkFunctions functions = functions_of(chosen_simd_targets());
  return functions;
}

std::optional<LabelWalkFunctions> label_walk_functions_of(std::string_view level) {
  if (level == "scalar") return portable_label_walk_functions();
  const std::int64_t targets = simd_targets_of(level);
  if (targets == 0) return std::nullopt;
  return functions_of(targets);
}

}  // namespace octavo
#endif
