#include "octavo/builder/metadata_member.h"

#include <gtest/gtest.h>

#include <array>

namespace octavo {
namespace {

TEST(MetadataMember, StandsBehindAllOthersAndOnce) {
  // Before, after "x" became 1.
  const std::array<std::array<const char*, 2>, 14> rows = {{
      {R"({})", R"({"x":1})"},
      {R"({"a":2})", R"({"a":2,"x":1})"},
      {R"({"x":2})", R"({"x":1})"},
      {R"({"x":2,"a":3})", R"({"a":3,"x":1})"},
      {R"({"a":3,"x":{"x":[1,2,"}"]}})", R"({"a":3,"x":1})"},
      {R"({"a":3,"x":[4,5],"b":6,"x":7})", R"({"a":3,"b":6,"x":1})"},
      {R"({"a":{"x":2},"b":"x","c":["x"]})", R"({"a":{"x":2},"b":"x","c":["x"],"x":1})"},
      {R"({"a":"\"x\":,{","x":"\\"})", R"({"a":"\"x\":,{","x":1})"},
      {R"({"a":"\"x\":2,\"x"})", R"({"a":"\"x\":2,\"x","x":1})"},
      {R"({"a":[1.50,-2,[true,null,{}]],"x":[{"x":1}],"b":{"c":[]}})",
       R"({"a":[1.50,-2,[true,null,{}]],"b":{"c":[]},"x":1})"},
      {"{ \"a\" : 18446744073709551615,\t\"b\":1e-9 }",
       R"({"a":18446744073709551615,"b":1e-9,"x":1})"},
      {R"({"\u00b5\n":"\u0001\""})", "{\"\xc2\xb5\\n\":\"\\u0001\\\"\",\"x\":1}"},
      {"[1]", "[1]"},
      {"no object", "no object"},
  }};
  for (const auto& [before, after] : rows) EXPECT_EQ(with_member(before, "x", "1"), after);
}

}  // namespace
}  // namespace octavo
