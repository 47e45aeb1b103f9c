#include "octavo/codec/label/label_octant_votes.h"

#include <gtest/gtest.h>

#include "octavo/codec/label/label_octant.h"

namespace octavo {
namespace {

TEST(LabelOctant, OfTwoLabelsOneRuleDecidesWhatTheGeneralOnesDo) {
  for (const std::vector<std::int64_t>& labels : {std::vector<std::int64_t>{3, 8}, {8, 3}}) {
    for (int count = 1; count <= 8; ++count) {
      for (std::uint32_t slots = 0; slots < 1u << count; ++slots) {
        const ChildWeights weights = {5, 3, 10, 6, 15, 9, 30, 18};
        std::int64_t all = 0;
        for (int child = 0; child < count; ++child) all += weights[static_cast<std::size_t>(child)];
        LabelOctant octant(1, count, all, labels);
        for (int child = 0; child < count; ++child) {
          octant.enter(weights[static_cast<std::size_t>(child)]);
          EXPECT_EQ(octant.is_pair_decided(), octant.must_be_same() || octant.is_excluded(0))
              << "child " << child << " of " << count << ", slots " << slots;
          octant.leave(slots >> child & 1, true);
        }
      }
    }
  }
}

}  // namespace
}  // namespace octavo
