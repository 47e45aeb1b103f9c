// The pairs of a row that may be edges (edge_pairs.h), and what their contexts know: templates of
// the passes over edges, built on the kernels of grey_portable.h.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "octavo/codec/encoders.h"
#include "octavo/codec/grey/grey_portable.h"

namespace octavo::grey {

/// Closer to the background, means leave few details: those are as well coded as residuals.
inline constexpr int kMinEdgeMean = 2;

/// The pairs of a row that may be edges.
struct CandidateRow {
  RowMask pairs = 0;
  RowMask is_mirrored = 0;  ///< their contexts are those of pairs seen from the other side
  RowMask may_be_even = 0;  ///< the other sample may be `2 mean - rounding - background`
  RowMask may_be_odd = 0;   ///< it may be one more
  /// Of each pair of the row; a vector more.
  alignas(64) std::uint16_t contexts[kBrickSide + 16];
};

/// What contexts know of all pairs of a row: numbers of two bits are two masks.
struct EdgeMasks {
  RowMask any;               ///< there is background or an edge
  RowMask along1, along2;    ///< how many of the two means along the axis are background
  RowMask across1, across2;  ///< of the four across it, 3 at most
  RowMask is_mirrored;
  RowMask side1, side2;      ///< 0, 1, 2: how the edges before lean, seen from the first side
};

/// Weights of what is known in a context:
/// 2 (((along * 4 + across) * 5 + ratio) * 3 + side) + (axis == 0), where ratio tells how many of
/// kEdgeRatios, in sixteenths, a mean reaches of the larger one beside it.
inline constexpr int kSideWeight = 2;
inline constexpr int kRatioWeight = 3 * kSideWeight;
inline constexpr int kAcrossWeight = 5 * kRatioWeight;
inline constexpr int kAlongWeight = 4 * kAcrossWeight;
inline constexpr int kEdgeRatios[] = {4, 7, 9, 13};

/// The means of a row that are background.
template <class Sample>
RowMask background_of(const Sample* means, std::int64_t count, Sample lowest) {
  // Of 32 at a time, margins and what is behind them included: compilers make vectors of that.
  constexpr std::int64_t kTogether = 32;
  static_assert(kBrickSide % kTogether == 0);
  std::uint8_t flags[kBrickSide];
  for (std::int64_t first = 0; first < count; first += kTogether) {
    for (std::int64_t x = first; x < first + kTogether; ++x) flags[x] = means[x] == lowest ? 1 : 0;
  }
  RowMask mask = 0;
  for (std::int64_t x = 0; x < count; x += 8) mask |= mask_of_bytes(flags + x) << x;
  return mask & first_pairs(count);
}

/// Where the means of a split are background.
template <class Sample, class Kernel>
class Background {
 public:
  Background(const Stage& stage, const SampleGrid<Sample>& means, PairMasks& masks)
      : masks_(masks), size_(means.size()) {
    for (std::int64_t z = 0; z < size_.z; ++z) {
      for (std::int64_t y = 0; y < size_.y; ++y) {
        masks_.row(y, z) =
            Kernel::background(means.row(y, z), size_.x, static_cast<Sample>(stage.min));
      }
    }
  }

  RowMask of(std::int64_t y, std::int64_t z) const { return masks_.row(y, z); }
  /// That of the means before and after along each axis; beyond the last one it is the last again.
  using Beside = std::array<std::array<RowMask, 2>, 3>;
  Beside beside(std::int64_t y, std::int64_t z) const {
    const RowMask own = of(y, z);
    return {{{own << 1 | (own & 1), own >> 1 | (own & RowMask{1} << (size_.x - 1))},
             {y > 0 ? of(y - 1, z) : own, y + 1 < size_.y ? of(y + 1, z) : own},
             {z > 0 ? of(y, z - 1) : own, z + 1 < size_.z ? of(y, z + 1) : own}}};
  }

 private:
  PairMasks& masks_;
  Size3 size_;
};

/// Contexts of the pairs of `row`, less those that cannot be edges.
template <class Sample>
void describe_candidates(const Stage& stage, const Sample* means, const EdgeMasks& beside,
                         CandidateRow& row) {
  using Int = Wide<Sample>;
  const auto lowest = static_cast<Int>(stage.min);
  const std::int64_t step = pair_step<Sample>(stage.axis);
  const auto may_be = [&](Int sample) {
    return sample <= stage.max && (stage.gaps == nullptr || stage.gaps->occurs(sample));
  };
  for_each_pair(row.pairs, [&](int x) {
    const Sample* const mean = means + x;
    const RowMask bit = RowMask{1} << x;
    // What its other sample would be
    const Int other = 2 * Int{*mean} - stage.rounding - lowest;
    if (may_be(other)) row.may_be_even |= bit;
    if (may_be(other + 1)) row.may_be_odd |= bit;
    if (*mean < lowest + kMinEdgeMean) row.pairs &= ~bit;
    const Int beyond = std::max(Int{mean[-step]}, Int{mean[step]}) - lowest;
    int context = stage.axis == 0 ? 1 : 0;
    for (const int ratio : kEdgeRatios) {
      context += 16 * (*mean - lowest) >= ratio * beyond ? kRatioWeight : 0;
    }
    const auto number = [x](RowMask low, RowMask high) {
      return static_cast<int>((low >> x & 1) + 2 * (high >> x & 1));
    };
    context += kAlongWeight * number(beside.along1, beside.along2) +
               kAcrossWeight * number(beside.across1, beside.across2) +
               kSideWeight * number(beside.side1, beside.side2);
    row.contexts[x] = static_cast<std::uint16_t>(context);
  });
  row.pairs &= row.may_be_even | row.may_be_odd;
}

/// Plain loops.
template <class Sample>
struct PortableEdges {
  static RowMask background(const Sample* means, std::int64_t count, Sample lowest) {
    return background_of(means, count, lowest);
  }
  static void describe(const Stage& stage, const Sample* means, const EdgeMasks& beside,
                       CandidateRow& row) {
    describe_candidates(stage, means, beside, row);
  }
};

/// The passes over the edges of a split, built on a Kernel with the functions of PortableEdges.
template <class Sample, class Kernel>
class EdgePasses {
 public:
  /// mark_edges
  static void mark(const Stage& stage, Workspace<Sample>& work) {
    require_encoders();
    const auto lowest = static_cast<Int>(stage.min);
    work.edge_symbols.clear();
    EdgePasses(stage, work).for_each_row([&](CandidateRow& row, std::int64_t y, std::int64_t z) {
      const Sample* const means = work.means.row(y, z);
      const Int* const details = work.residuals.row(y, z);
      Found found;
      int place = 0;
      for_each_pair(row.pairs, [&](int x) {
        const RowMask bit = RowMask{1} << x;
        const Pair<Int> pair = pair_of<Int>(means[x], details[x], stage.rounding);
        const unsigned context = kContexts + row.contexts[x];
        const int at = place++;
        if (pair.a != lowest && pair.b != lowest) {
          work.edge_symbols.emplace_back(0u, context, 0u, at);
          return;
        }
        const bool is_mirrored = (row.is_mirrored & bit) != 0;
        const bool is_first = (pair.a == lowest) != is_mirrored;
        const unsigned odd = static_cast<unsigned>(details[x] + stage.rounding) & 1;
        (is_first ? found.firsts : found.seconds) |= bit;
        found.odd |= odd != 0 ? bit : 0;
        const auto kind = static_cast<unsigned>(is_first ? EdgeKind::first : EdgeKind::second);
        const bool is_asked = (row.may_be_even & row.may_be_odd & bit) != 0;
        if (is_asked) work.edge_symbols.emplace_back(kind << 1 | odd, context, 1u, at);
        else work.edge_symbols.emplace_back(kind, context, 0u, at);
      });
      note(stage, work, row, found, y, z);
    });
  }

  /// take_edges
  static void take(const Stage& stage, Workspace<Sample>& work, SymbolReader& symbols) {
    EdgePasses(stage, work).for_each_row([&](CandidateRow& row, std::int64_t y, std::int64_t z) {
      Found found;
      int place = 0;
      // Whether the next one is an edge is anyone's guess: no branch
      for_each_pair(row.pairs, [&](int x) {
        const EdgeKind kind = symbols.take_edge(place++, row.contexts[x]);
        found.firsts |= RowMask{kind == EdgeKind::first} << x;
        found.seconds |= RowMask{kind == EdgeKind::second} << x;
      });
      const RowMask edges = found.firsts | found.seconds;
      const RowMask asked = edges & row.may_be_even & row.may_be_odd;
      found.odd = (edges & row.may_be_odd & ~asked) | take_bits(symbols, asked);
      note(stage, work, row, found, y, z);
      symbols.expect_inside();
    });
  }

 private:
  using Int = Wide<Sample>;

  /// Edges among the pairs of a row.
  struct Found {
    RowMask firsts = 0;   ///< by kind, as contexts see them
    RowMask seconds = 0;
    RowMask odd = 0;      ///< the other sample is one more than an even sum makes it
  };

  EdgePasses(const Stage& stage, Workspace<Sample>& work)
      : stage_(stage), work_(work), background_(stage, work.means, work.background) {}

  /// Calls f(row, y, z) for the rows of a split that have candidates.
  template <class F>
  void for_each_row(F&& f) {
    if (stage_.cells != nullptr) find_open_pairs(stage_, work_.open);
    work_.edges.details.set_size(stage_.pairs);
    CandidateRow row;
    for (std::int64_t z = 0; z < stage_.pairs.z; ++z) {
      for (std::int64_t y = 0; y < stage_.pairs.y; ++y) {
        work_.edges.firsts.row(y, z) = work_.edges.seconds.row(y, z) = 0;
        list(y, z, row);
        if (row.pairs != 0) f(row, y, z);
      }
    }
  }

  void list(std::int64_t y, std::int64_t z, CandidateRow& row) {
    row.pairs = open_pairs(stage_, work_, y, z) & ~background_.of(y, z) &
                first_pairs(stage_.first_weighted(y, z));
    if (row.pairs == 0) return;
    const EdgeMasks masks = masks_of(y, z);
    row.pairs &= masks.any;
    if (row.pairs == 0) return;
    row.is_mirrored = masks.is_mirrored;
    row.may_be_even = row.may_be_odd = 0;
    Kernel::describe(stage_, work_.means.row(y, z), masks, row);
  }

  EdgeMasks masks_of(std::int64_t y, std::int64_t z) {
    const auto beside = background_.beside(y, z);
    const auto [before, after] = beside[static_cast<std::size_t>(stage_.axis)];
    const auto across1 = beside[stage_.axis == 0 ? 1 : 0];
    const auto across2 = beside[stage_.axis == 2 ? 1 : 2];
    // Edges of the rows above and behind
    PairMasks& firsts = work_.edges.firsts;
    PairMasks& seconds = work_.edges.seconds;
    const RowMask firsts_up = y > 0 ? firsts.row(y - 1, z) : 0;
    const RowMask firsts_back = z > 0 ? firsts.row(y, z - 1) : 0;
    const RowMask seconds_up = y > 0 ? seconds.row(y - 1, z) : 0;
    const RowMask seconds_back = z > 0 ? seconds.row(y, z - 1) : 0;
    EdgeMasks masks;
    masks.any = before | after | across1[0] | across1[1] | across2[0] | across2[1] | firsts_up |
                firsts_back | seconds_up | seconds_back;
    masks.along1 = before ^ after;
    masks.along2 = before & after;
    // Sums of bits, all pairs at once
    const RowMask one = across1[0] ^ across1[1];
    const RowMask two = across1[0] & across1[1];
    const RowMask other_one = across2[0] ^ across2[1];
    const RowMask other_two = across2[0] & across2[1];
    masks.across1 = (one ^ other_one) | (two & other_two);
    masks.across2 = two | other_two | (one & other_one);
    const RowMask first1 = firsts_up ^ firsts_back;
    const RowMask first2 = firsts_up & firsts_back;
    const RowMask second1 = seconds_up ^ seconds_back;
    const RowMask second2 = seconds_up & seconds_back;
    const RowMask is_alike = ~(first2 ^ second2);
    const RowMask to_first = (first2 & ~second2) | (is_alike & first1 & ~second1);
    const RowMask to_second = (second2 & ~first2) | (is_alike & second1 & ~first1);
    // The side that background lies on, or else that of the edges before, comes first.
    masks.is_mirrored = (masks.along1 & after) | (~masks.along1 & to_second);
    const RowMask ahead = (to_first & ~masks.is_mirrored) | (to_second & masks.is_mirrored);
    const RowMask behind = (to_second & ~masks.is_mirrored) | (to_first & masks.is_mirrored);
    masks.side1 = ~(ahead | behind);
    masks.side2 = ahead;
    return masks;
  }

  /// A plain bit for each of some pairs.
  static RowMask take_bits(SymbolReader& symbols, RowMask pairs) {
    RowMask bits = 0;
    for_each_pair(pairs, [&](int x) { bits |= symbols.take_plain(1) << x; });
    return bits;
  }

  static void note(const Stage& stage, Workspace<Sample>& work, const CandidateRow& row,
                   const Found& found, std::int64_t y, std::int64_t z) {
    const RowMask edges = found.firsts | found.seconds;
    if (edges == 0) return;
    const RowMask firsts = edges & (found.firsts ^ row.is_mirrored);
    work.edges.firsts.row(y, z) = firsts;
    work.edges.seconds.row(y, z) = edges & ~firsts;
    const Sample* const means = work.means.row(y, z);
    Int* const details = work.edges.details.row(y, z);
    std::fill_n(details, stage.pairs.x, Int{0});
    for_each_pair(edges, [&](int x) {
      const Int size = 2 * (Int{means[x]} - static_cast<Int>(stage.min)) - stage.rounding +
                       static_cast<Int>(found.odd >> x & 1);
      details[x] = (firsts >> x & 1) != 0 ? -size : size;
    });
  }

  const Stage& stage_;
  Workspace<Sample>& work_;
  Background<Sample, Kernel> background_;
};

/// All passes built on two kernels.
template <class Sample, class Kernel, class EdgeKernel>
constexpr StagePasses<Sample> passes_of() {
  StagePasses<Sample> passes = Passes<Sample, Kernel>::functions();
  passes.mark_edges = EdgePasses<Sample, EdgeKernel>::mark;
  passes.take_edges = EdgePasses<Sample, EdgeKernel>::take;
  return passes;
}

}  // namespace octavo::grey
