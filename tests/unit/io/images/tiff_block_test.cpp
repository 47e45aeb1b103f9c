#include "octavo/io/images/tiff_block.h"

#include <gtest/gtest.h>

#include <string>

namespace octavo::testing {
namespace {

TEST(TiffBlock, WarningsOfLostValuesAreDamage) {
  const std::string lost = "Corrupt JPEG data: premature end of data segment";
  const std::string behind = "Corrupt JPEG data: 2 extraneous bytes before marker 0xd9";
  EXPECT_EQ(told_damage(behind + "\n" + lost + "\n"), lost);
  EXPECT_EQ(told_damage(behind + "\nPremature end of JPEG file\n"), "");
  EXPECT_EQ(told_damage(""), "");
}

}  // namespace
}  // namespace octavo::testing
