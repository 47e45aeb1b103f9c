// One split of the grey codec: from the means along an axis to the samples, pair by pair.
//
// Contexts and tokens need the means and the residuals of earlier rows, never a reconstructed
// sample. So a split is decoded in two passes: all residuals row by row, then all samples. Encoding
// takes the same passes in the other order: predict, then contexts.
//
// The fine grid starts as the means repeated along the axis and is overwritten in place, so that a
// fixed window reads "fine where decoded, mean elsewhere". A pair looks at rows y-1 .. y+1 of pairs
// in the planes z-1 .. z+1 and must find them as if rows were done in the order z, y. Any schedule
// that does row (y + 1, z - 1) before row (y, z) and row (y - 1, z + 1) after it gives the same
// bytes: planes can go side by side, each two rows behind the one before.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "octavo/codec/grey/grey_model.h"
#include "octavo/codec/grey/residual_coder.h"
#include "octavo/codec/grey/sample_grid.h"

namespace octavo::grey {

/// Which samples of a brick need no details because a cell of level-2 footprint holds one value.
/// Indexed by level-2 sample; empty when no cell is flagged.
struct UniformCells {
  Size3 size;
  std::vector<std::uint8_t> flags;
};

struct Stage {
  int axis = 0;
  int group = 0;
  int set = 0;
  int rounding = 0;
  Size3 pairs;  ///< details of this split: pairs along the axis, samples along the others
  PairWeights last_pair;  ///< along the axis; in all other pairs both samples weigh alike
  std::int64_t min = 0;       ///< value range of the brick, in samples
  std::int64_t max = 0;
  int shift = 0;              ///< magnitudes are measured in units of 2^shift
  std::int32_t step = 1;      ///< residuals are multiples of it
  /// A detail is at most twice the room between the mean and the smallest sample, and this more,
  /// and likewise to the largest: one of the two is 1, as the mean was rounded. 0 for quantized
  /// details.
  int odd_low = 0;
  int odd_high = 0;
  int step_bits = 0;          ///< the logarithm of step, rounded down
  const UniformCells* cells = nullptr;  ///< nullptr: every pair is coded
  /// Of the split that makes voxels, where some values do not occur: residuals count details.
  const ValueGaps* gaps = nullptr;
  /// Edges are marked in the work space: they are not coded as residuals.
  bool has_edges = false;
  int cell_shift[3] = {0, 0, 0};        ///< pair coordinate >> shift = cell coordinate
  /// Rows whose samples a decoder is asked for: samples elsewhere may be anything. Contexts need
  /// all residuals, but no sample of the same split.
  std::int64_t first_row = 0;
  std::int64_t last_row = kBrickSide;

  bool is_looked_at(std::int64_t y) const { return y >= first_row && y < last_row; }
  std::int64_t detail_count() const;    ///< coded details, those of uniform cells left out
  /// Where the pairs of two weights begin in a row; pairs.x when it has none.
  std::int64_t first_weighted(std::int64_t y, std::int64_t z) const {
    if (last_pair.are_equal()) return pairs.x;
    if (axis == 0) return pairs.x - 1;
    return (axis == 1 ? y + 1 == pairs.y : z + 1 == pairs.z) ? 0 : pairs.x;
  }
};

/// Some pairs of a row: bit x stands for pair x.
using RowMask = std::uint64_t;
static_assert(kBrickSide <= 64);

constexpr RowMask first_pairs(std::int64_t count) {
  return count == 64 ? ~RowMask{0} : (RowMask{1} << count) - 1;
}

/// Integers wide enough for sums and differences of samples.
template <class Sample>
using Wide = std::conditional_t<sizeof(Sample) == 2, std::int32_t, std::int64_t>;

/// Holds the limit of any detail.
template <class Sample>
using Limit = std::conditional_t<sizeof(Sample) == 2, std::uint16_t, std::int64_t>;

/// A number per pair of a split, dense [z][y][x] with rows padded to a multiple of kPadding.
template <class T, std::int64_t kPadding = 8>
class PairGrid {
 public:
  PairGrid()
      : values_(cleared_room<T>(
            static_cast<std::size_t>(kBrickSide * kBrickSide * kBrickSide / 2 + 64))) {}
  void set_size(const Size3& pairs) {
    row_ = (pairs.x + kPadding - 1) & ~(kPadding - 1);
    plane_ = row_ * pairs.y;
  }
  /// Keeps one plane at a time: every plane stands in the same place.
  void set_plane_size(const Size3& pairs) {
    set_size(pairs);
    plane_ = 0;
  }
  T* row(std::int64_t y, std::int64_t z) {
    return values_.get() + z * plane_ + y * row_;
  }

 private:
  std::int64_t row_ = 0;
  std::int64_t plane_ = 0;
  Room<T> values_;
};

/// Some pairs of every row of a split.
class PairMasks {
 public:
  PairMasks() : rows_(cleared_room<RowMask>(static_cast<std::size_t>(kBrickSide * kBrickSide))) {}
  RowMask& row(std::int64_t y, std::int64_t z) {
    return rows_[static_cast<std::size_t>(z * kBrickSide + y)];
  }

 private:
  Room<RowMask> rows_;
};

/// The pairs of a split that lie in no uniform cell.
void find_open_pairs(const Stage& stage, PairMasks& open);

/// Pairs at the edge of the background (edge_pairs.h): of one sample is background, the other not.
template <class Sample>
struct EdgePairs {
  PairMasks firsts;                ///< the first sample is background
  PairMasks seconds;               ///< the second one is
  PairGrid<Wide<Sample>> details;  ///< 0 for other pairs; only of rows that have edges

  RowMask row(std::int64_t y, std::int64_t z) { return firsts.row(y, z) | seconds.row(y, z); }
};

/// Buffers of one row; index 0 is the first pair.
struct RowBuffers {
  static constexpr int kLength = static_cast<int>(kBrickSide) + 32;
  alignas(64) std::uint16_t gradient_along[kLength];   ///< e0: both steps along the axis
  alignas(64) std::uint16_t curvature_along[kLength];  ///< e1: their difference
  alignas(64) std::uint16_t gradient_across[kLength];  ///< e2: the steps along the other two axes
  alignas(64) std::uint16_t limit[kLength];  ///< |detail| cannot exceed it, in units of 2^shift
  alignas(64) std::uint8_t order[kLength];             ///< coded pairs
  alignas(64) std::int16_t zeros[kLength];
};

/// Residual magnitudes of earlier rows around the row being coded.
struct MagnitudeRows {
  const std::int16_t* sibling[2];  ///< same place in the splits done before in this level, or zeros
  const std::int16_t* up;
  const std::int16_t* back;
  const std::int16_t* back_up;
  const std::int16_t* back_down;
};

template <class Sample>
struct Workspace {
  SampleGrid<Sample> means;  ///< input of a split
  SampleGrid<Sample> fine;   ///< output of a split
  SampleGrid<std::int16_t> magnitudes[3];
  PairGrid<Wide<Sample>> residuals;    ///< true details before `predict`, residuals after it
  PairGrid<Limit<Sample>> limits;      ///< no |detail| is larger; 0 in uniform cells, for edges
  PairGrid<std::uint8_t> activities;
  PairGrid<std::int16_t> predictions;  ///< kept by passes that predict a plane at a time
  /// What the details of the plane behind were beyond the predictions from their slopes. Rows are
  /// changed in place, by vectors that reach into the padding.
  PairGrid<Wide<Sample>, 16> excesses;
  PairGrid<std::int16_t, 16> plane_excesses;  ///< the same of those passes
  PairGrid<std::uint16_t> contexts;    ///< context | plain bits << 8
  PairMasks open;                      ///< pairs that lie in no uniform cell
  EdgePairs<Sample> edges;             ///< only of stages that have edges
  std::vector<Symbol> edge_symbols;    ///< of the pairs that may be edges (mark_edges)
  PairMasks background;                ///< where the means are background
  RowBuffers row{};
};

/// A split to decode: what its symbols and means stand for, and where its samples go.
template <class Sample>
struct SplitTask {
  const Stage& stage;
  Workspace<Sample>& work;
  SymbolReader& symbols;
};

/// So many splits are decoded at the same time, at most.
inline constexpr std::size_t kMostTogether = 4;

/// The passes of a split for samples of 16 bits (sums wrap at 32 bits) and of 32 bits (64).
template <class Sample>
struct StagePasses {
  /// Takes the residuals off the symbols and completes the fine grid.
  void (*decode)(const Parameters&, const SplitTask<Sample>&);
  /// The same for up to kMostTogether splits along one axis with work spaces and symbols of their
  /// own; the machine may overlap them.
  void (*decode_together)(const Parameters&, std::span<const SplitTask<Sample>>);
  /// Finds the activities and limits of all pairs.
  void (*measure)(const Parameters&, const Stage&, Workspace<Sample>&);
  /// Turns the details in `residuals` into residuals, brought to multiples of the step, and
  /// completes the fine grid as a decoder will have it.
  void (*predict)(const Parameters&, const Stage&, Workspace<Sample>&);
  /// Appends the residuals of coded pairs with their contexts.
  void (*list_symbols)(const Parameters&, const Stage&, Workspace<Sample>&, std::vector<Symbol>&);
  /// Both at once. The fine grid and the magnitudes are as a decoder will have them.
  void (*encode)(const Parameters&, const Stage&, Workspace<Sample>&, std::vector<Symbol>&);
  /// The same, to a segment.
  void (*write)(const Parameters&, const Stage&, Workspace<Sample>&, SymbolWriter&);
  /// See edge_pairs.h.
  void (*mark_edges)(const Stage&, Workspace<Sample>&);
  void (*take_edges)(const Stage&, Workspace<Sample>&, SymbolReader&);
};

struct StageFunctions {
  StagePasses<std::int16_t> narrow;
  StagePasses<std::int32_t> wide;
  PushTokens push;

  template <class Sample>
  const StagePasses<Sample>& of() const {
    if constexpr (sizeof(Sample) == 2) return narrow;
    else return wide;
  }
};

/// The fastest functions this machine has, or those that OCTAVO_SIMD asks for (simd_level.h). All
/// give the same results.
const StageFunctions& stage_functions();

/// The functions of one instruction set, "scalar" for the portable ones (others: simd_level.h);
/// nothing when the machine lacks it.
std::optional<StageFunctions> stage_functions_of(std::string_view level);

const StageFunctions& portable_stage_functions();

}  // namespace octavo::grey
