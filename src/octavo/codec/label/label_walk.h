// The traversal of the octants of a brick's levels that encoder, decoder and training share.
//
// It makes level i from level i+1. Every sample starts as its parent's label; where the parent is
// mixed the octant is visited: for each child, by rising digit, "is it its parent's label?", if not
// which label, and above level 0 "is it uniform?". An encoder answers with the target, a decoder
// reads the answers.
// Neighbors already visited are seen as they are, the others as their parents.
//
// Answers that follow from what a parent is (the most frequent label below; mixed, so not all
// alike) are not asked. They follow from the answers alone, so that both sides agree whatever the
// bytes are.
//
// Nearly all time goes into looking at the 32 neighbors and adding the rows of the networks; the
// traversal is compiled once per instruction set (label_walk_simd.cpp) and once in plain C++
// (label_walk_portable.cpp), with equal results.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "octavo/codec/label/label_contexts.h"
#include "octavo/codec/label/label_grid.h"
#include "octavo/codec/label/label_model.h"
#include "octavo/codec/label/label_pyramid.h"
#include "octavo/octree/o_code.h"

namespace octavo {

/// What a network is asked; the order of the networks in a model.
enum class LabelAsk : std::uint8_t { same, uniform, candidate };

/// Receives the questions that a network is asked, with their answers.
class LabelObserver {
 public:
  virtual ~LabelObserver() = default;
  /// Called for every question; those it wants are observed.
  virtual bool wants_next(LabelAsk kind) = 0;
  virtual void observe(LabelAsk kind, const LabelQuestion& question, bool answer) = 0;
};

/// What a traversal knows of a brick; kept for the next brick so that its memory is reused.
struct LabelWork {
  LabelGrid grid;     ///< the level being made, then its result
  LabelGrid parents;
  MixedRows mixed;          ///< of `grid`
  MixedRows mixed_parents;  ///< of `parents`
  /// `grid` lacks the cells below uniform parents.
  bool is_sparse = false;
  std::vector<std::int64_t> labels;  ///< by slot
  bool is_pair = false;              ///< no labels but range.min and range.max
  AdaptiveBit is_fresh;
  AdaptiveBit in_palette;

  /// Forgets the brick.
  void start();

  /// The neighborhood in `grid`, which has that level.
  const LabelNeighborhood& neighborhood(int level);

  /// A cell of the result, whether `grid` has it or not.
  LabelCell cell(const Index3& at) const {
    if (is_sparse) {
      const LabelCell parent = *parents.at({at.x >> 1, at.y >> 1, at.z >> 1});
      if (state_of(parent) == kUniform) return parent;
    }
    return *grid.at(at);
  }

 private:
  struct Neighborhood {
    std::ptrdiff_t row_stride = 0;
    std::ptrdiff_t plane_stride = 0;
    LabelNeighborhood offsets;
  };
  std::vector<Neighborhood> neighborhoods_;  ///< by level: those of most bricks are the same
};

/// The work space of this thread.
LabelWork& thread_label_work();

struct LabelWalkFunctions {
  /// Levels from the root down to `level`, into the cells and the labels of `work`.
  /// Throws Error{corrupt}.
  void (*decode)(const LabelModel&, const BrickShape&, const ValueRange&,
                 std::span<const ByteSpan> segments, int level, LabelWork& work);
  /// Requires at most kMaxLabelSlots labels.
  void (*encode)(const LabelModel&, const BrickShape&, const LabelPyramid&,
                 std::vector<Bytes>& segments, LabelWork& work);
  void (*observe)(const LabelModel&, const BrickShape&, const LabelPyramid&, LabelObserver&,
                  LabelWork& work);
};

/// The fastest functions this machine has, or those that OCTAVO_SIMD asks for (simd_level.h). All
/// give the same results.
const LabelWalkFunctions& label_walk_functions();

/// The functions of one instruction set, "scalar" for the portable ones (others: simd_level.h);
/// nothing when the machine lacks it.
std::optional<LabelWalkFunctions> label_walk_functions_of(std::string_view level);

const LabelWalkFunctions& portable_label_walk_functions();

}  // namespace octavo
