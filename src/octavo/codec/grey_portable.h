// The splits of the grey codec in plain C++: the reference for every instruction set, and what
// training runs on.
#pragma once

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "octavo/codec/grey_stage.h"
#include "octavo/codec/octant_transform.h"

namespace octavo::grey {

/// Offsets of the rows of 8 taps around a sample, in samples, by split axis.
template <class Sample>
struct TapRows {
  static constexpr std::int64_t R = SampleGrid<Sample>::kRow;
  static constexpr std::int64_t P = SampleGrid<Sample>::kPlane;
  static constexpr int kCount[3] = {10, 12, 12};
  static constexpr std::int64_t kOffsets[3][12] = {
      {-8, 0, -R - 3, R - 3, -P - 3, P - 3, -P - R - 3, -P + R - 3, P - R - 3, P + R - 3, 0, 0},
      {-2 * R - 3, -R - 3, -3, R - 3, 2 * R - 3, -P - R - 3, -P - 3, -P + R - 3, -P + 2 * R - 3,
       P - R - 3, P - 3, P + 2 * R - 3},
      {-2 * P - 3, -P - R - 3, -P - 3, -P + R - 3, -R - 3, -3, R - 3, P - R - 3, P - 3,
       2 * P - R - 3, 2 * P - 3, 2 * P + R - 3}};
};

namespace portable {

/// The weighted sum of the taps around a sample; 16-bit samples sum modulo 2^32.
template <int kAxis, class Sample>
class Dot {
 public:
  explicit Dot(const Sample*) {}
  Wide<Sample> operator()(const Sample* at, const std::int16_t* weights) const {
    using Sum = std::make_unsigned_t<Wide<Sample>>;
    Sum sum = 0;
    for (int r = 0; r < TapRows<Sample>::kCount[kAxis]; ++r) {
      const Sample* taps = at + TapRows<Sample>::kOffsets[kAxis][r];
      for (int i = 0; i < 8; ++i) {
        sum += static_cast<Sum>(Wide<Sample>{taps[i]} * weights[8 * r + i]);
      }
    }
    return static_cast<Wide<Sample>>(sum);
  }
  void advance(Sample, Sample) {}
};

#include "octavo/codec/grey_stage-inl.h"

}  // namespace portable
}  // namespace octavo::grey
