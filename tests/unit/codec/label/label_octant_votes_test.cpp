#include "octavo/codec/label/label_octant_votes.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(LabelOctant, OfTwoLabelsOneRuleDecidesWhatTheGeneralOnesDo) {
  for (const std::vector<std::int64_t>& labels : {std::vector<std::int64_t>{3, 8}, {8, 3}}) {
    for (int count = 1; count <= 8; ++count) {
      for (std::uint32_t slots = 0; slots < 1u << count; ++slots) {
        LabelOctant octant(1, count, labels);
        for (int child = 0; child < count; ++child) {
          octant.enter();
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
