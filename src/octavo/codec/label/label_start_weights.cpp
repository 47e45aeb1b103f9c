#include "octavo/codec/label/label_start_weights.h"

#include <algorithm>

namespace octavo {

namespace {

/// In the order in which LabelWeights and LabelWeightSet have them.
constexpr std::int8_t kWeights[] = {
#include "octavo/codec/label/label_start_weights.inc"
};
static_assert(sizeof kWeights == kLabelNets * kLabelWeights);

}  // namespace

const LabelWeightSet& label_start_weights() {
  static const LabelWeightSet set = [] {
    LabelWeightSet weights{};
    const std::int8_t* from = kWeights;
    for (LabelWeights& net : weights) {
      std::copy_n(from, kLabelWeights, net.begin());
      from += kLabelWeights;
    }
    return weights;
  }();
  return set;
}

}  // namespace octavo
