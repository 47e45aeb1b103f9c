#include "octavo/tasks/surfaces/part_names.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace octavo {
namespace {

using Names = std::vector<std::string>;

TEST(PartNames, AreThoseOfTheLabels) {
  LabelNames names;
  names.set(1, {"Liver", {}});
  names.set(2, {"Leber, rechts", {}});
  names.set(3, {"\xc3\xa9paule", {}});
  EXPECT_EQ(part_names({1, 2, 3, 4, -5}, names),
            (Names{"Liver", "Leber__rechts", "\xc3\xa9paule", "label_4", "label_-5"}));
}

TEST(PartNames, StayInTheirFolderAndInSight) {
  LabelNames names;
  names.set(1, {"../../etc/passwd", {}});
  names.set(2, {"..", {}});
  names.set(3, {"-rf", {}});
  names.set(4, {"a\nb\\c:d\xff", {}});
  names.set(5, {"///", {}});
  names.set(6, {std::string(500, 'x'), {}});
  const Names found = part_names({1, 2, 3, 4, 5, 6}, names);
  EXPECT_EQ(found[0], "_._.._etc_passwd");
  EXPECT_EQ(found[1], "label_2");
  EXPECT_EQ(found[2], "_rf");
  EXPECT_EQ(found[3], "a_b_c_d\xef\xbf\xbd");
  EXPECT_EQ(found[4], "label_5");
  EXPECT_EQ(found[5].size(), 200u);
}

TEST(PartNames, AreFilesOnWindowsToo) {
  LabelNames names;
  names.set(1, {"CON", {}});
  names.set(2, {"aux.left", {}});
  names.set(3, {"Com7", {}});
  names.set(4, {"Liver...", {}});
  names.set(5, {"console", {}});
  names.set(6, {"com10", {}});
  EXPECT_EQ(part_names({1, 2, 3, 4, 5, 6}, names),
            (Names{"_CON", "_aux.left", "_Com7", "Liver.._", "console", "com10"}));
}

TEST(PartNames, AreAllDifferentInEitherCase) {
  LabelNames names;
  names.set(1, {"rib", {}});
  names.set(2, {"RIB", {}});
  names.set(3, {"rib_1", {}});
  names.set(4, {"label_5", {}});
  Names found = part_names({1, 2, 3, 4, 5}, names);
  EXPECT_EQ(found[1], "RIB_2");
  for (std::string& name : found) {
    std::transform(name.begin(), name.end(), name.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  }
  std::sort(found.begin(), found.end());
  EXPECT_EQ(std::unique(found.begin(), found.end()), found.end());
}

}  // namespace
}  // namespace octavo
