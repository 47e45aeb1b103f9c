#include "octavo/io/images/tiff_block.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <string>

namespace octavo::testing {
namespace {

TEST(TiffBlock, WarningsOfLostValuesAreDamage) {
  const auto told = [](int compression, const std::string& warnings) {
    return told_damage(static_cast<std::uint16_t>(compression), warnings);
  };
  const std::string discarding = "Discarding 127 bytes to avoid buffer overrun";
  const std::string lack = "Terminating PackBitsDecode due to lack of data.";
  EXPECT_EQ(told(COMPRESSION_PACKBITS, discarding + "\n"), discarding);
  EXPECT_EQ(told(COMPRESSION_PACKBITS, "something else\n" + lack + "\n"), lack);
  EXPECT_EQ(told(COMPRESSION_PACKBITS, "something else\n"), "");
  EXPECT_EQ(told(COMPRESSION_PACKBITS, ""), "");
  const std::string lost = "Corrupt JPEG data: premature end of data segment";
  EXPECT_EQ(told(COMPRESSION_JPEG, "Corrupt JPEG data: 2 extraneous bytes before marker 0xd9\n" +
                                       lost + "\n"),
            lost);
  EXPECT_EQ(told(COMPRESSION_JPEG, "Premature end of JPEG file\n"), "");
  EXPECT_EQ(told(COMPRESSION_LZW, discarding + "\n" + lost + "\n"), "");
}

}  // namespace
}  // namespace octavo::testing
