// The label walk for every instruction set that Highway knows, chosen at run time.

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "octavo/codec/label_portable.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/codec/label_walk_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

using portable::Around;

#else

namespace hn = hwy::HWY_NAMESPACE;

/// Where the codes of a child's neighbors lie, and their votes, for children at the lower and at the
/// upper place along x.
///
///     lane           0    1    2    3        rows around, of an octant whose first child is at x = 0
///     x             -1    0    1    2
///     own row, low  -1   -2    1    2        the child's own lane holds the far cell that its row
///     own row, up   -1    0    3    2        of four leaves out
struct Layout {
  alignas(16) std::uint8_t rows[16];    ///< bytes of four rows as neighbors 0 .. 11
  alignas(16) std::uint8_t along[16];   ///< bytes of the own row as neighbors 12 .. 15
  alignas(16) std::uint8_t across[16];  ///< bytes of those far along y and z as neighbors 28 .. 31
  alignas(16) LabelCell votes[5][8];    ///< of exactly known cells; 0 in lanes without a neighbor
};

constexpr Layout layout(bool is_upper) {
  Layout result{};
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
    const auto vote = static_cast<LabelCell>(label_vote(i, kUniform));
    const std::size_t k = i & 15;
    if (k < 12) result.votes[i / 16 * 2 + k / 6][result.rows[k] % 8 / 2 + 4 * (k / 3 & 1)] = vote;
    else result.votes[4][i < 16 ? result.along[k] / 2 : result.across[k] / 2] = vote;
  }
  return result;
}

constexpr Layout kLayouts[2] = {layout(false), layout(true)};

/// What is known around a child.
///
/// The rows of four cells through an octant are kept beside the grid: loading them back from there
/// so soon after the narrow stores of single cells would stall.
class Around {
 public:
  HWY_INLINE Around(const LabelCell* first, std::ptrdiff_t row_stride,
                    std::ptrdiff_t plane_stride) {
    for (std::size_t z = 0; z < 4; ++z) {
      for (std::size_t y = 0; y < 4; ++y) {
        const LabelCell* row = first + (static_cast<std::ptrdiff_t>(y) - 1) * row_stride +
                               (static_cast<std::ptrdiff_t>(z) - 1) * plane_stride;
        // The cell before the first belongs to the octant visited just now.
        std::uint64_t four;
        std::memcpy(&four, row, sizeof four);
        rows_[z][y] = four << 16 | row[-1];
      }
    }
  }

  HWY_INLINE void see(const LabelCell* cell, const LabelNeighborhood& offsets, std::size_t digit) {
    const auto& at = offsets[digit];
    const std::size_t x = digit >> 1 & 1;
    const std::size_t y = 1 + (digit & 1);
    const std::size_t z = 1 + (digit >> 2 & 1);
    // Towards the siblings and away from them, as rows.
    const std::size_t y_in = 3 - y, z_in = 3 - z;
    const std::size_t y_out = y == 1 ? 0 : 3, z_out = z == 1 ? 0 : 3;
    layout_ = &kLayouts[x];
    cells_[0] = two_rows(rows_[z_in][y_in], rows_[z_in][y]);
    cells_[1] = two_rows(rows_[z_in][y_out], rows_[z][y_in]);
    cells_[2] = two_rows(rows_[z][y_out], rows_[z_out][y_in]);
    cells_[3] = two_rows(rows_[z_out][y], rows_[z_out][y_out]);
    const std::uint64_t across = std::uint64_t{cell[at[28]]} | std::uint64_t{cell[at[29]]} << 16 |
                                 std::uint64_t{cell[at[30]]} << 32 |
                                 std::uint64_t{cell[at[31]]} << 48;
    const LabelCell left_out = x == 0 ? cell[-2] : cell[2];
    cells_[4] = two_rows(with(rows_[z][y], x, left_out), across);
  }

  /// The child of `digit` got its label.
  HWY_INLINE void settle(std::size_t digit, LabelCell cell) {
    std::uint64_t& row = rows_[1 + (digit >> 2 & 1)][1 + (digit & 1)];
    row = with(row, digit >> 1 & 1, cell);
  }

  HWY_INLINE void aim(std::uint32_t slot) {
    const auto own = hn::Set(kCells, static_cast<LabelCell>(slot));
    const auto others = hn::BitCast(kBytes, codes(cells_[4], own));
    place(0, hn::Or(shuffled(joined(codes(cells_[0], own), codes(cells_[1], own)), layout_->rows),
                    shuffled(others, layout_->along)));
    place(1, hn::Or(shuffled(joined(codes(cells_[2], own), codes(cells_[3], own)), layout_->rows),
                    shuffled(others, layout_->across)));
  }

  HWY_INLINE int logit(const LabelNet& net, std::size_t first, std::size_t second) const {
    const hn::CappedTag<std::int16_t, kLabelHidden> lanes;
    const hn::Repartition<std::int32_t, decltype(lanes)> sums;
    auto total = hn::Zero(sums);
    auto unused = hn::Zero(sums);
    for (std::size_t j = 0; j < kLabelHidden; j += hn::Lanes(lanes)) {
      auto even = hn::Load(lanes, net.first(first) + j);
      auto odd = hn::Load(lanes, net.second(second) + j);
      const std::int16_t* rows = net.pairs() + j;
      for (std::size_t k = 0; k < kLabelPairs; k += 2) {
        even = hn::Add(even, hn::Load(lanes, rows + pair_[k]));
        odd = hn::Add(odd, hn::Load(lanes, rows + pair_[k + 1]));
      }
      const auto sum = hn::Max(hn::Add(even, odd), hn::Zero(lanes));
      total = hn::ReorderWidenMulAccumulate(sums, sum, hn::Load(lanes, net.out() + j), total,
                                            unused);
    }
    return hn::GetLane(hn::SumOfLanes(sums, hn::Add(total, unused)));
  }

  /// The labels that neighbors propose, `slot` left out.
  HWY_INLINE void propose(std::uint32_t slot, LabelCandidates& candidates) const {
    const auto own = hn::Set(kCells, static_cast<LabelCell>(slot));
    const auto one = hn::Set(kCells, 1);
    const auto zero = hn::Zero(kCells);
    Cells votes[5];
    // Cells that propose something else, 0 in all other lanes.
    alignas(16) LabelCell open[40];
    for (std::size_t i = 0; i < 5; ++i) {
      const auto state = hn::And(cells_[i], hn::Set(kCells, 3));
      const auto exact = hn::Load(kCells, layout_->votes[i]);
      const auto halved = hn::ShiftRight<1>(hn::Add(exact, one));
      const auto is_own = hn::Eq(hn::ShiftRight<2>(cells_[i]), own);
      const auto is_closed = hn::Or(hn::Eq(exact, zero), hn::Or(hn::Eq(state, zero), is_own));
      votes[i] = hn::IfThenElse(hn::Eq(state, one), halved, exact);
      hn::Store(hn::IfThenZeroElse(is_closed, cells_[i]), kCells, open + 8 * i);
    }
    for (std::size_t i = 0; i < 40; i += 4) {
      std::uint64_t four;
      while (std::memcpy(&four, open + i, sizeof four), four != 0) {
        std::size_t first = i;
        while (open[first] == 0) ++first;
        const std::uint32_t found = slot_of(open[first]);
        candidates.append(found, taken(found, votes, open));
      }
    }
  }

  void tell(LabelQuestion& question) const {
    for (std::size_t k = 0; k < kLabelPairs; ++k) {
      const std::size_t code = pair_[k] / kLabelHidden;
      question.neighbor[2 * k] = static_cast<std::uint8_t>(code >> 3 & 7);
      question.neighbor[2 * k + 1] = static_cast<std::uint8_t>(code & 7);
    }
  }

 private:
  static constexpr hn::FixedTag<LabelCell, 8> kCells{};
  static constexpr hn::FixedTag<std::uint8_t, 16> kBytes{};
  using Cells = hn::Vec<hn::FixedTag<LabelCell, 8>>;
  using CodeBytes = hn::Vec<hn::FixedTag<std::uint8_t, 16>>;

  static HWY_INLINE Cells two_rows(std::uint64_t low, std::uint64_t high) {
    alignas(16) const std::uint64_t both[2] = {low, high};
    return hn::BitCast(kCells, hn::Load(hn::FixedTag<std::uint64_t, 2>(), both));
  }

  /// A row with the cell of the child at x (0 or 1) replaced.
  static HWY_INLINE std::uint64_t with(std::uint64_t row, std::size_t x, LabelCell cell) {
    const std::size_t shift = 16 * (x + 1);
    return (row & ~(std::uint64_t{0xffff} << shift)) | std::uint64_t{cell} << shift;
  }

  /// 2 * state + equal of every cell.
  static HWY_INLINE Cells codes(Cells cells, Cells slot) {
    const auto state = hn::And(cells, hn::Set(kCells, 3));
    const auto is_equal = hn::VecFromMask(kCells, hn::Eq(hn::ShiftRight<2>(cells), slot));
    return hn::Sub(hn::Add(state, state), is_equal);
  }

  /// Codes of `low` in the even bytes, of `high` in the odd ones.
  static HWY_INLINE CodeBytes joined(Cells low, Cells high) {
    return hn::BitCast(kBytes, hn::Or(low, hn::ShiftLeft<8>(high)));
  }

  static HWY_INLINE CodeBytes shuffled(CodeBytes bytes, const std::uint8_t* order) {
    return hn::TableLookupBytesOr0(bytes, hn::Load(kBytes, order));
  }

  /// The offsets of 8 pairs of codes in a network's table.
  HWY_INLINE void place(std::size_t half, CodeBytes bytes) {
    alignas(16) static constexpr LabelCell kFirst[16] = {
        0x0000, 0x0400, 0x0800, 0x0c00, 0x1000, 0x1400, 0x1800, 0x1c00,
        0x2000, 0x2400, 0x2800, 0x2c00, 0x3000, 0x3400, 0x3800, 0x3c00};
    const auto pairs = hn::BitCast(kCells, bytes);
    const auto a = hn::And(hn::ShiftLeft<7>(pairs), hn::Set(kCells, 0x380));
    const auto b = hn::And(hn::ShiftRight<4>(pairs), hn::Set(kCells, 0x70));
    hn::Store(hn::Or(hn::Or(a, b), hn::Load(kCells, kFirst + 8 * half)), kCells,
              pair_ + 8 * half);
  }

  /// The votes for `slot`, whose cells are closed.
  static HWY_INLINE int taken(std::uint32_t slot, const Cells* votes, LabelCell* open) {
    const hn::FixedTag<std::int16_t, 8> signed_votes;
    const hn::FixedTag<std::int32_t, 4> sums;
    const auto own = hn::Set(kCells, static_cast<LabelCell>(slot));
    auto total = hn::Zero(kCells);
    for (std::size_t i = 0; i < 5; ++i) {
      const auto cells = hn::Load(kCells, open + 8 * i);
      const auto is_own = hn::And(hn::Eq(hn::ShiftRight<2>(cells), own),
                                  hn::Ne(cells, hn::Zero(kCells)));
      total = hn::Add(total, hn::IfThenElseZero(is_own, votes[i]));
      hn::Store(hn::IfThenZeroElse(is_own, cells), kCells, open + 8 * i);
    }
    auto odd = hn::Zero(sums);
    const auto even = hn::ReorderWidenMulAccumulate(
        sums, hn::BitCast(signed_votes, total), hn::Set(signed_votes, 1), hn::Zero(sums), odd);
    return hn::GetLane(hn::SumOfLanes(sums, hn::Add(even, odd)));
  }

  std::uint64_t rows_[4][4];  ///< [z][y], cells -1 .. 2 along x, from -1 along y and z
  Cells cells_[5];            ///< eight rows around, the own row, the cells far along y and z
  const Layout* layout_;
  alignas(16) LabelCell pair_[kLabelPairs];
};

#endif

#include "octavo/codec/label_walk-inl.h"

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo {

HWY_EXPORT(decode_labels);
HWY_EXPORT(encode_labels);
HWY_EXPORT(observe_labels);

const LabelWalkFunctions& label_walk_functions() {
  static const LabelWalkFunctions functions = [] {
    const char* const asked = std::getenv("OCTAVO_SIMD");
    LabelWalkFunctions chosen = portable_label_walk_functions();
    if (asked != nullptr && std::string_view(asked) == "scalar") return chosen;
    // Without this the table would still hold the function that detects the machine at every call.
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    chosen.decode = HWY_DYNAMIC_DISPATCH(decode_labels);
    chosen.encode = HWY_DYNAMIC_DISPATCH(encode_labels);
    chosen.observe = HWY_DYNAMIC_DISPATCH(observe_labels);
    return chosen;
  }();
  return functions;
}

}  // namespace octavo
#endif
