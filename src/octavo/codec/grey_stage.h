// One split of the grey codec: from the means along an axis to the samples, pair by pair.
//
// The fine grid starts as the means repeated along the axis and is overwritten in place, row by
// row, so that a fixed window reads "fine where decoded, mean elsewhere". Per row: features and
// contexts of all pairs from the means and from residuals of earlier rows; then all residuals of
// the row; then prediction and reconstruction pair by pair.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "octavo/codec/grey_model.h"
#include "octavo/codec/residual_coder.h"
#include "octavo/codec/sample_grid.h"

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
  std::int64_t min = 0;       ///< value range of the brick, in samples
  std::int64_t max = 0;
  int shift = 0;              ///< magnitudes are measured in units of 2^shift
  const UniformCells* cells = nullptr;  ///< nullptr: every pair is coded
  int cell_shift[3] = {0, 0, 0};        ///< pair coordinate >> shift = cell coordinate

  std::int64_t detail_count() const;    ///< coded details, those of uniform cells left out
};

/// Integers wide enough for sums and differences of samples.
template <class Sample>
using Wide = std::conditional_t<sizeof(Sample) == 2, std::int32_t, std::int64_t>;

/// Buffers of one row; index 0 is the first pair.
template <class Sample>
struct RowBuffers {
  static constexpr int kLength = static_cast<int>(kBrickSide) + 16;
  alignas(64) std::int32_t gradient_along[kLength];   ///< e0: both steps along the axis
  alignas(64) std::int32_t curvature_along[kLength];  ///< e1: their difference
  alignas(64) std::int32_t gradient_across[kLength];  ///< e2: the steps along the other two axes
  alignas(64) std::int32_t limit[kLength];  ///< |detail| cannot exceed it, in units of 2^shift
  alignas(64) Wide<Sample> exact_limit[kLength];   ///< the same in samples
  alignas(64) std::uint8_t activity[kLength];
  alignas(64) std::uint8_t context[kLength];
  alignas(64) std::uint8_t order[kLength];            ///< coded pairs
  alignas(64) Wide<Sample> residual[kLength];
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
  RowBuffers<Sample> row{};
};

/// True samples of a split, dense [z][y][x].
template <class Sample>
struct Truth {
  const Sample* samples = nullptr;
  Size3 size;
};

/// The splits for samples of 16 bits (Int = int32_t, wrapping) and 32 bits (Int = int64_t).
struct StageFunctions {
  void (*decode16)(const Parameters&, const Stage&, Workspace<std::int16_t>&, SymbolReader&);
  void (*encode16)(const Parameters&, const Stage&, Workspace<std::int16_t>&,
                   const Truth<std::int16_t>&, std::vector<Symbol>&);
  void (*decode32)(const Parameters&, const Stage&, Workspace<std::int32_t>&, SymbolReader&);
  void (*encode32)(const Parameters&, const Stage&, Workspace<std::int32_t>&,
                   const Truth<std::int32_t>&, std::vector<Symbol>&);
};

/// The fastest functions this machine has; OCTAVO_SIMD=scalar in the environment asks for the
/// portable ones. All give the same results.
const StageFunctions& stage_functions();
const StageFunctions& portable_stage_functions();

}  // namespace octavo::grey
