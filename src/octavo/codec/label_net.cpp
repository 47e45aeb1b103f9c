#include "octavo/codec/label_net.h"

#include <algorithm>

namespace octavo {

namespace {

/// 65536 / (1 + exp(-x)) for x = -11, -10.5, ... 11.
constexpr std::array<std::int32_t, 45> kLogistic = {
    1,     2,     3,     5,     8,     13,    22,    36,    60,    98,    162,   267,
    439,   720,   1179,  1921,  3108,  4971,  7812,  11955, 17625, 24743, 32768, 40793,
    47911, 53581, 57724, 60565, 62428, 63615, 64357, 64816, 65097, 65269, 65374, 65438,
    65476, 65500, 65514, 65523, 65528, 65531, 65533, 65534, 65535};

/// Half a unit of logit.
constexpr int kStep = 128;

constexpr std::array<std::uint16_t, 2 * kLogitLimit + 1> interpolated() {
  std::array<std::uint16_t, 2 * kLogitLimit + 1> table{};
  for (int logit = -kLogitLimit; logit <= kLogitLimit; ++logit) {
    const int above = logit + kLogitLimit;
    const auto i = static_cast<std::size_t>(std::min(above / kStep, 43));
    const int part = above - static_cast<int>(i) * kStep;
    const std::int32_t value = kLogistic[i] + (kLogistic[i + 1] - kLogistic[i]) * part / kStep;
    table[static_cast<std::size_t>(above)] =
        static_cast<std::uint16_t>(std::clamp(value, 16, 65520));
  }
  return table;
}

}  // namespace

LabelNet::LabelNet(const LabelWeights& weights) {
  const std::int8_t* from = weights.data();
  const auto take = [&](Row& row) {
    for (std::int16_t& entry : row) entry = *from++;
  };
  for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
    for (std::size_t state = 2; state < 8; ++state) take(neighbor_[8 * i + state]);
  }
  for (Row& row : category_) take(row);
  take(out_);
}

namespace detail {
constexpr std::array<std::uint16_t, 2 * kLogitLimit + 1> kProbability = interpolated();
}

}  // namespace octavo
