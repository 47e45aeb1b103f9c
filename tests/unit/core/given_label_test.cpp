#include "octavo/core/given_label.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

#include "octavo/core/label_names.h"

namespace octavo {
namespace {

TEST(GivenLabel, ALabelIsWhatAVoxelHolds) {
  EXPECT_TRUE(is_label(0));
  EXPECT_TRUE(is_label(std::numeric_limits<std::int32_t>::min()));
  EXPECT_TRUE(is_label(std::numeric_limits<std::uint32_t>::max()));
  EXPECT_FALSE(is_label(std::int64_t{std::numeric_limits<std::int32_t>::min()} - 1));
  EXPECT_FALSE(is_label(std::int64_t{std::numeric_limits<std::uint32_t>::max()} + 1));
}

TEST(GivenLabel, ANameThatIsGivenIsALineOfText) {
  for (const std::string name : {"liver", "left lung", "\xc3\xa9paule", "a\tb",
                                 "\xe6\x89\x8b", "\xe2\x80\x9cquoted\xe2\x80\x9d"}) {
    EXPECT_EQ(label_name_fault(name), "") << name;
  }
  EXPECT_EQ(label_name_fault(std::string(LabelNames::kMaxNameBytes, 'x')), "");
  EXPECT_EQ(label_name_fault(std::string(LabelNames::kMaxNameBytes + 1, 'x')),
            "is longer than 512 bytes");
  for (const std::string name : {"", " ", "\t "}) {
    EXPECT_EQ(label_name_fault(name), "is empty");
  }
  for (const std::string name : {"a\nb", "\x1b[31m", "\x7f", "\xc2\x9b""1m", "a\xe2\x80\xae",
                                 "\xe2\x80\xa8", "\xe2\x81\xa6x"}) {
    EXPECT_EQ(label_name_fault(name), "holds a control character") << name;
  }
}

}  // namespace
}  // namespace octavo
