// What a brick of labels needs besides its segments: the palette and the weights of three networks.
//
// Serialized: one stream of the binary coder. Numbers are Exp-Golomb codes with adaptive bits: the
// palette as a count and rising differences; then, network by network, each weight's difference to
// its start weight in steps of kLabelWeightStep, most of them 0. The stream ends as finish_short
// ends it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/codec/label/label_net.h"
#include "octavo/codec/label/label_start_weights.h"
#include "octavo/core/bytes.h"
#include "octavo/core/voxel_type.h"

namespace octavo {

/// Longer palettes are not kept: their labels are then coded as numbers within the brick's range.
inline constexpr std::size_t kMaxPalette = 4096;
inline constexpr int kLabelWeightStep = 2;

struct LabelModel {
  LabelModel(std::vector<std::int64_t> labels, const LabelWeightSet& set);

  std::vector<std::int64_t> palette;  ///< rising, without repeats
  LabelWeightSet weights;
  /// "Has it its parent's label?", "is it uniform?", "has it this candidate's label?".
  std::array<LabelNet, kLabelNets> nets;
};

/// Requires every weight to be a whole number of steps from its start weight.
Bytes serialize(const LabelModel& model, VoxelType type);

/// Throws Error{corrupt} when the bytes are not those of a model for labels of `type`.
LabelModel parse_label_weights(VoxelType type, ByteSpan bytes);

/// The part of a palette that lies in the value range of a brick.
struct LabelPaletteRange {
  LabelPaletteRange(const std::vector<std::int64_t>& palette, const ValueRange& range);

  /// The place of `label` in this part, -1 when it is not there.
  std::int64_t rank_of(std::int64_t label) const;

  const std::int64_t* first = nullptr;
  std::uint64_t count = 0;
};

}  // namespace octavo
