// The weights every label model starts from; a model stores its differences to them.
#pragma once

#include <array>

#include "octavo/codec/label_net.h"

namespace octavo {

inline constexpr std::size_t kLabelNets = 3;
using LabelWeightSet = std::array<LabelWeights, kLabelNets>;

/// Part of the format: trained once on boundaries between regions of anatomical label maps and of a
/// segmented rock, and fixed since.
const LabelWeightSet& label_start_weights();

}  // namespace octavo
