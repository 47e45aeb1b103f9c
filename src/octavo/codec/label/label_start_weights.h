// The weights every label model starts from; a model stores its differences to them.
//
// label_start_weights.inc holds them as plain numbers, separated by commas, in the order in which
// LabelWeights and LabelWeightSet have them; other readers of the format may parse it.
#pragma once

#include <array>

#include "octavo/codec/label/label_net.h"

namespace octavo {

inline constexpr std::size_t kLabelNets = 3;
using LabelWeightSet = std::array<LabelWeights, kLabelNets>;

/// Part of the format: trained by tools/label_weights on brain atlases, a thresholded CT head and
/// made-up rock, cells, organs and vessels.
const LabelWeightSet& label_start_weights();

}  // namespace octavo
