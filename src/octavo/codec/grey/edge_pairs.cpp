#include "octavo/codec/grey/edge_pairs.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "octavo/codec/grey/grey_portable.h"

namespace octavo::grey {

namespace {

/// Means closer to the background leave few details: those are as well coded as residuals.
constexpr int kMinEdgeMean = 2;

/// A pair that may be an edge.
struct Candidate {
  std::uint16_t context;
  std::uint8_t x;
  bool is_mirrored;  ///< its context is that of the pair seen from the other side
  bool may_be_even;  ///< its other sample may be `2 mean - rounding - background`
  bool may_be_odd;   ///< it may be one more
};

struct CandidateRow {
  std::array<Candidate, kBrickSide + 1> candidates;  ///< and room for one that is none
  int count = 0;
};

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
  for (std::int64_t x = 0; x < count; x += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, flags + x, 8);
    if constexpr (std::endian::native == std::endian::big) eight = __builtin_bswap64(eight);
    // The lowest bit of each byte to the highest byte, in their order
    mask |= (eight * 0x0102040810204080u >> 56) << x;
  }
  return mask & first_pairs(count);
}

/// Where the means of a split are background.
template <class Sample>
class Background {
 public:
  Background(const Stage& stage, const SampleGrid<Sample>& means, PairMasks& masks)
      : masks_(masks), size_(means.size()) {
    for (std::int64_t z = 0; z < size_.z; ++z) {
      for (std::int64_t y = 0; y < size_.y; ++y) {
        masks_.row(y, z) = background_of(means.row(y, z), size_.x, static_cast<Sample>(stage.min));
      }
    }
  }

  RowMask of(std::int64_t y, std::int64_t z) const { return masks_.row(y, z); }
  /// That of the means before and after along an axis; beyond the last one it is the last again.
  RowMask before(int axis, std::int64_t y, std::int64_t z) const {
    if (axis == 0) return of(y, z) << 1 | (of(y, z) & 1);
    return axis == 1 ? of(std::max<std::int64_t>(y - 1, 0), z)
                     : of(y, std::max<std::int64_t>(z - 1, 0));
  }
  RowMask after(int axis, std::int64_t y, std::int64_t z) const {
    if (axis == 0) return of(y, z) >> 1 | (of(y, z) & RowMask{1} << (size_.x - 1));
    return axis == 1 ? of(std::min(y + 1, size_.y - 1), z) : of(y, std::min(z + 1, size_.z - 1));
  }

 private:
  PairMasks& masks_;
  Size3 size_;
};

/// Lists the pairs of a split that may be edges, row by row.
template <class Sample>
class Candidates {
 public:
  Candidates(const Stage& stage, Workspace<Sample>& work)
      : stage_(stage), work_(work), background_(stage, work.means, work.background) {}

  void list(std::int64_t y, std::int64_t z, CandidateRow& row) {
    row.count = 0;
    const RowMask open = open_pairs(stage_, work_, y, z) & ~background_.of(y, z) &
                         first_pairs(stage_.first_weighted(y, z));
    if (open == 0) return;
    const int axis = stage_.axis;
    const int across1 = axis == 0 ? 1 : 0;
    const int across2 = axis == 2 ? 1 : 2;
    const RowMask across[] = {background_.before(across1, y, z), background_.after(across1, y, z),
                              background_.before(across2, y, z), background_.after(across2, y, z)};
    const RowMask before = background_.before(axis, y, z);
    const RowMask after = background_.after(axis, y, z);
    const Beside beside = beside_of(before, after, across, EdgesBefore(work_.edges, y, z));
    const Sample* const means = work_.means.row(y, z);
    for_each_pair(open & beside.any, [&](int x) { add(means + x, x, beside, row); });
  }

 private:
  using Int = Wide<Sample>;

  /// Edges of the rows above and behind.
  struct EdgesBefore {
    RowMask firsts_up, firsts_back, seconds_up, seconds_back;

    EdgesBefore(EdgePairs<Sample>& edges, std::int64_t y, std::int64_t z)
        : firsts_up(y > 0 ? edges.firsts.row(y - 1, z) : 0),
          firsts_back(z > 0 ? edges.firsts.row(y, z - 1) : 0),
          seconds_up(y > 0 ? edges.seconds.row(y - 1, z) : 0),
          seconds_back(z > 0 ? edges.seconds.row(y, z - 1) : 0) {}
  };

  /// What contexts know of all pairs of a row: numbers of two bits are two masks.
  struct Beside {
    RowMask any;            ///< there is background or an edge
    RowMask along1, along2;    ///< how many of the two means along the axis are background
    RowMask across1, across2;  ///< of the four across it, 3 at most
    RowMask is_mirrored;
    RowMask side1, side2;      ///< 0, 1, 2: how the edges before lean, seen from the first side
  };

  static Beside beside_of(RowMask before, RowMask after, const RowMask (&across)[4],
                          const EdgesBefore& edges) {
    Beside beside;
    beside.any = before | after | across[0] | across[1] | across[2] | across[3] |
                 edges.firsts_up | edges.firsts_back | edges.seconds_up | edges.seconds_back;
    beside.along1 = before ^ after;
    beside.along2 = before & after;
    // Sums of bits, all pairs at once
    const RowMask one = across[0] ^ across[1];
    const RowMask two = across[0] & across[1];
    const RowMask other_one = across[2] ^ across[3];
    const RowMask other_two = across[2] & across[3];
    beside.across1 = (one ^ other_one) | (two & other_two);
    beside.across2 = two | other_two | (one & other_one);
    const RowMask first1 = edges.firsts_up ^ edges.firsts_back;
    const RowMask first2 = edges.firsts_up & edges.firsts_back;
    const RowMask second1 = edges.seconds_up ^ edges.seconds_back;
    const RowMask second2 = edges.seconds_up & edges.seconds_back;
    const RowMask is_alike = ~(first2 ^ second2);
    const RowMask to_first = (first2 & ~second2) | (is_alike & first1 & ~second1);
    const RowMask to_second = (second2 & ~first2) | (is_alike & second1 & ~first1);
    // The side that background lies on, or else that of the edges before, comes first.
    beside.is_mirrored = (beside.along1 & after) | (~beside.along1 & to_second);
    const RowMask ahead = (to_first & ~beside.is_mirrored) | (to_second & beside.is_mirrored);
    const RowMask behind = (to_second & ~beside.is_mirrored) | (to_first & beside.is_mirrored);
    beside.side1 = ~(ahead | behind);
    beside.side2 = ahead;
    return beside;
  }

  /// Without a branch on the values: a pair that cannot be an edge is overwritten by the next.
  void add(const Sample* mean, int x, const Beside& beside, CandidateRow& row) const {
    // What its other sample would be
    const Int lowest = static_cast<Int>(stage_.min);
    const Int other = 2 * Int{*mean} - stage_.rounding - lowest;
    const auto may_be = [&](Int sample) {
      return sample <= stage_.max && (stage_.gaps == nullptr || stage_.gaps->occurs(sample));
    };
    const bool may_be_even = may_be(other);
    const bool may_be_odd = may_be(other + 1);
    const auto bit = [x](RowMask mask) { return static_cast<int>(mask >> x & 1); };
    const auto number = [&](RowMask low, RowMask high) { return bit(low) + 2 * bit(high); };
    const std::int64_t step = pair_step<Sample>(stage_.axis);
    const Int beyond = std::max(Int{mean[-step]}, Int{mean[step]}) - lowest;
    const Int sixteenfold = 16 * (*mean - lowest);
    const int ratio = (sixteenfold >= 4 * beyond) + (sixteenfold >= 7 * beyond) +
                      (sixteenfold >= 9 * beyond) + (sixteenfold >= 13 * beyond);
    const int context = 2 * (((number(beside.along1, beside.along2) * 4 +
                               number(beside.across1, beside.across2)) * 5 + ratio) * 3 +
                             number(beside.side1, beside.side2)) +
                        (stage_.axis == 0 ? 1 : 0);
    row.candidates[static_cast<std::size_t>(row.count)] = {
        static_cast<std::uint16_t>(context), static_cast<std::uint8_t>(x),
        bit(beside.is_mirrored) != 0, may_be_even, may_be_odd};
    const bool is_candidate = *mean >= lowest + kMinEdgeMean;
    row.count += static_cast<int>(is_candidate & (may_be_even | may_be_odd));
  }

  const Stage& stage_;
  Workspace<Sample>& work_;
  Background<Sample> background_;
};

/// Notes an edge. is_odd: whether its other sample is one more than an even sum makes it
template <class Sample>
void note_edge(const Stage& stage, Workspace<Sample>& work, const Candidate& pair, EdgeKind kind,
               bool is_odd, std::int64_t y, std::int64_t z) {
  using Int = Wide<Sample>;
  const RowMask bit = RowMask{1} << pair.x;
  Int* const details = work.edges.details.row(y, z);
  if (work.edges.row(y, z) == 0) std::fill_n(details, stage.pairs.x, Int{0});
  const Int size = 2 * (Int{work.means.row(y, z)[pair.x]} - static_cast<Int>(stage.min)) -
                   stage.rounding + (is_odd ? 1 : 0);
  const bool is_first = (kind == EdgeKind::first) != pair.is_mirrored;
  (is_first ? work.edges.firsts : work.edges.seconds).row(y, z) |= bit;
  details[pair.x] = is_first ? -size : size;
}

/// Calls f(row, y, z) for the rows of a split, with their candidates.
template <class Sample, class F>
void for_each_row_of_candidates(const Stage& stage, Workspace<Sample>& work, F&& f) {
  if (stage.cells != nullptr) find_open_pairs(stage, work.open);
  work.edges.details.set_size(stage.pairs);
  Candidates<Sample> candidates(stage, work);
  CandidateRow row;
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
      work.edges.firsts.row(y, z) = work.edges.seconds.row(y, z) = 0;
      candidates.list(y, z, row);
      if (row.count > 0) f(row, y, z);
    }
  }
}

}  // namespace

template <class Sample>
void mark_edges(const Stage& stage, Workspace<Sample>& work) {
  using Int = Wide<Sample>;
  const auto lowest = static_cast<Int>(stage.min);
  work.edge_symbols.clear();
  for_each_row_of_candidates(stage, work, [&](const CandidateRow& row, std::int64_t y,
                                              std::int64_t z) {
    for (int i = 0; i < row.count; ++i) {
      const Candidate& candidate = row.candidates[static_cast<std::size_t>(i)];
      const Int mean = work.means.row(y, z)[candidate.x];
      const Int detail = work.residuals.row(y, z)[candidate.x];
      const Pair<Int> pair = pair_of<Int>(mean, detail, stage.rounding);
      const bool is_edge = pair.a == lowest || pair.b == lowest;
      const unsigned context = kContexts + candidate.context;
      if (!is_edge) {
        work.edge_symbols.emplace_back(0u, context, 0u, i);
        continue;
      }
      const bool is_first = (pair.a == lowest) != candidate.is_mirrored;
      const EdgeKind kind = is_first ? EdgeKind::first : EdgeKind::second;
      const bool is_odd = ((detail + stage.rounding) & 1) != 0;
      note_edge(stage, work, candidate, kind, is_odd, y, z);
      const auto value = static_cast<std::uint64_t>(kind);
      if (candidate.may_be_even && candidate.may_be_odd) {
        work.edge_symbols.emplace_back(value << 1 | (is_odd ? 1 : 0), context, 1u, i);
      } else {
        work.edge_symbols.emplace_back(value, context, 0u, i);
      }
    }
  });
}

template <class Sample>
void take_edges(const Stage& stage, Workspace<Sample>& work, SymbolReader& symbols) {
  for_each_row_of_candidates(stage, work, [&](const CandidateRow& row, std::int64_t y,
                                              std::int64_t z) {
    // Which are edges: whether the next one is, is anyone's guess
    std::array<EdgeKind, kBrickSide + 1> kinds;
    std::array<std::uint8_t, kBrickSide + 1> places;
    std::size_t edge_count = 0;
    for (int i = 0; i < row.count; ++i) {
      const EdgeKind kind =
          symbols.take_edge(i, row.candidates[static_cast<std::size_t>(i)].context);
      kinds[edge_count] = kind;
      places[edge_count] = static_cast<std::uint8_t>(i);
      edge_count += kind != EdgeKind::none ? 1 : 0;
    }
    for (std::size_t k = 0; k < edge_count; ++k) {
      const Candidate& pair = row.candidates[places[k]];
      const auto asked = static_cast<unsigned>(pair.may_be_even & pair.may_be_odd);
      const bool is_odd = (symbols.take_plain(static_cast<int>(asked)) |
                           (static_cast<unsigned>(pair.may_be_odd) ^ asked)) != 0;
      note_edge(stage, work, pair, kinds[k], is_odd, y, z);
    }
    symbols.expect_inside();
  });
}

template void mark_edges(const Stage&, Workspace<std::int16_t>&);
template void mark_edges(const Stage&, Workspace<std::int32_t>&);
template void take_edges(const Stage&, Workspace<std::int16_t>&, SymbolReader&);
template void take_edges(const Stage&, Workspace<std::int32_t>&, SymbolReader&);

}  // namespace octavo::grey
