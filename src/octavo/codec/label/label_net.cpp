#include "octavo/codec/label/label_net.h"

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

consteval std::array<std::uint16_t, 2 * kLogitLimit + 1> interpolated() {
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
  // The weight of a neighbor's code, 0 outside the brick.
  const auto weight = [&](std::size_t neighbor, std::size_t code, std::size_t j) {
    const std::size_t row = kLabelStates * neighbor + code - 2;
    return code < 2 ? 0 : int{weights[kLabelHidden * row + j]};
  };
  for (std::size_t pair = 0; pair < kLabelPairs; ++pair) {
    for (std::size_t a = 0; a < 8; ++a) {
      for (std::size_t b = 0; b < 8; ++b) {
        for (std::size_t j = 0; j < kLabelHidden; ++j) {
          rows_[pair_offset(pair, a, b) + j] = static_cast<std::int16_t>(
              weight(2 * pair, a, j) + weight(2 * pair + 1, b, j));
        }
      }
    }
  }
  const std::int8_t* first = weights.data() + kLabelHidden * kLabelStates * kLabelNeighbors;
  const std::int8_t* second = first + kLabelHidden * kLabelFirstCategories;
  std::int16_t* sum = rows_.data() + kCategoriesAt;
  for (std::size_t a = 0; a < kLabelFirstCategories; ++a) {
    for (std::size_t b = 0; b < kLabelSecondCategories; ++b) {
      for (std::size_t j = 0; j < kLabelHidden; ++j) {
        *sum++ = static_cast<std::int16_t>(first[kLabelHidden * a + j] +
                                           second[kLabelHidden * b + j]);
      }
    }
  }
  std::copy(weights.end() - kLabelHidden, weights.end(), rows_.begin() + kOutAt);
}

int label_logit(const LabelNet& net, const LabelQuestion& question) {
  // First layer: one row for the categories and one per pair of neighbors.
  std::array<int, kLabelHidden> sum{};
  const auto add = [&](const std::int16_t* row) {
    for (std::size_t j = 0; j < kLabelHidden; ++j) sum[j] += row[j];
  };
  add(net.categories(question.first, question.second));
  for (std::size_t k = 0; k < kLabelPairs; ++k) {
    add(net.pairs() +
        LabelNet::pair_offset(k, question.neighbor[2 * k], question.neighbor[2 * k + 1]));
  }

  // Second layer.
  int total = 0;
  for (std::size_t j = 0; j < kLabelHidden; ++j) total += std::max(sum[j], 0) * net.out()[j];
  return total;
}

namespace detail {
constexpr std::array<std::uint16_t, 2 * kLogitLimit + 1> kProbability = interpolated();
}

}  // namespace octavo
