#include "octavo/io/source/natural_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace octavo::testing {
namespace {

TEST(NaturalOrder, IsThatOfTheNumbers) {
  std::vector<std::string> names = {"b 10",
                                    "b 9",
                                    "a2",
                                    "a10",
                                    "b 010",
                                    "a",
                                    "b 100000000000000000000001",
                                    "b 100000000000000000000000"};
  std::sort(names.begin(), names.end(), natural_less);
  const std::vector<std::string> expected = {"a",
                                             "a2",
                                             "a10",
                                             "b 9",
                                             "b 010",
                                             "b 10",
                                             "b 100000000000000000000000",
                                             "b 100000000000000000000001"};
  EXPECT_EQ(names, expected);
}

}  // namespace
}  // namespace octavo::testing
