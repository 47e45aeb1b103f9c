// Pairs at the edge of an object: one sample is the smallest value of the brick, the other is not.
//
// Where most of a scan is one background value, masked or segmented, such pairs are frequent, and
// no prediction predicts their details: all that is unknown is which of the two samples lies in the
// background, and whether their sum is odd. These pairs are told apart by adaptive bits ahead of a
// split and left out of its residuals. Lossless models only.
#pragma once

#include <array>
#include <cstdint>

#include "octavo/codec/entropy/binary_coder.h"
#include "octavo/codec/grey/grey_stage.h"

namespace octavo::grey {

/// What is learned of a brick's edges on the way through it, level by level.
struct EdgeModels {
  /// By the means beside the pair that are background, along the axis (0..2) and across (0..4), and
  /// by the edges among the pairs to the left, above and behind (0..3).
  std::array<std::array<std::array<AdaptiveBit, 4>, 5>, 3> is_edge;
  /// By where the background goes on: along the axis, and in the neighboring edges.
  std::array<std::array<AdaptiveBit, 3>, 3> is_first;
};

/// Notes the edges of a split in work.edges and their details in work.edge_details, from the true
/// details in work.residuals. Returns how many there are.
template <class Sample>
std::int64_t mark_edges(const Stage& stage, Workspace<Sample>& work);

/// Codes the edges that were marked.
template <class Sample>
void put_edges(const Stage& stage, Workspace<Sample>& work, BinaryEncoder& coder,
               EdgeModels& models);

/// Marks the edges of a split as they come off `coder`. Returns how many there are.
template <class Sample>
std::int64_t take_edges(const Stage& stage, Workspace<Sample>& work, BinaryDecoder& coder,
                        EdgeModels& models);

}  // namespace octavo::grey
