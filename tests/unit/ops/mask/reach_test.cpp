// How far a voxel reaches, at spacings that are not what they mean.
#include "octavo/ops/mask/reach.h"

#include <gtest/gtest.h>

#include <cmath>

namespace octavo {
namespace {

TEST(Reach, TakesAStepOfItsLengthWhateverTheSpacingIsRoundedTo) {
  const Size3 size = {9, 9, 9};
  for (const double meant : {0.1, 0.3, 0.7, 1.3}) {
    const auto stored = static_cast<double>(static_cast<float>(meant));
    const Reach one = Reach::within_mm(meant, {stored, stored, stored}, size);
    EXPECT_EQ(one.longest(), (Index3{1, 1, 1})) << meant;
    EXPECT_FALSE(one.contains({1, 1, 0})) << meant;
    const Reach diagonal = Reach::within_mm(meant * std::sqrt(3.0), {stored, stored, stored}, size);
    EXPECT_TRUE(diagonal.contains({1, 1, 1})) << meant;
    EXPECT_FALSE(diagonal.contains({2, 0, 0})) << meant;
  }
}

TEST(Reach, TakesNoStepThatIsLonger) {
  const Reach reach = Reach::within_mm(0.9999, {1, 1, 1}, {9, 9, 9});
  EXPECT_EQ(reach.longest(), (Index3{0, 0, 0}));
}

}  // namespace
}  // namespace octavo
