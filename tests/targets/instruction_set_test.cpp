// Without this, a build that fell back to plain C++ would pass all other tests.
#include <gtest/gtest.h>

#include "octavo/codec/grey/grey_stage.h"
#include "octavo/codec/label/label_walk.h"

namespace octavo {
namespace {

TEST(InstructionSet, IsTheOneThatThisBuildIsFor) {
  const auto grey = grey::stage_functions_of(OCTAVO_EXPECTED_LEVEL);
  ASSERT_TRUE(grey);
  EXPECT_EQ(grey->narrow.decode, grey::stage_functions().narrow.decode);
  EXPECT_NE(grey->narrow.decode, grey::portable_stage_functions().narrow.decode);
  const auto labels = label_walk_functions_of(OCTAVO_EXPECTED_LEVEL);
  ASSERT_TRUE(labels);
  EXPECT_EQ(labels->decode, label_walk_functions().decode);
  EXPECT_NE(labels->decode, portable_label_walk_functions().decode);
}

}  // namespace
}  // namespace octavo
