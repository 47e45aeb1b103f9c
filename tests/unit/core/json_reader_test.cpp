#include "octavo/core/json_reader.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/json_members.h"

namespace octavo {
namespace {

/// Every token to the end.
std::vector<JsonToken> tokens_of(std::string_view text) {
  JsonReader in(text);
  std::vector<JsonToken> tokens;
  do tokens.push_back(in.next());
  while (tokens.back() != JsonToken::end);
  return tokens;
}

ErrorKind failure_of(std::string_view text) {
  try {
    tokens_of(text);
  } catch (const Error& error) {
    EXPECT_TRUE(error.offset().has_value()) << text;
    EXPECT_LE(*error.offset(), text.size()) << text;
    return error.kind();
  }
  ADD_FAILURE() << "taken: " << text.substr(0, 80);
  return ErrorKind::internal;
}

std::string string_of(std::string_view json) {
  JsonReader in(json);
  EXPECT_EQ(in.next(), JsonToken::string);
  return in.string();
}

std::string nested(std::size_t depth) {
  return std::string(depth, '[') + std::string(depth, ']');
}

constexpr std::string_view kText =
    R"( {"a" : [1, -2.5, "x\n\u00b5\ud83d\ude00", true, null], "b":{}, "":[] , "c" : 0e+1 } )";

TEST(JsonReader, HandsOutEveryTokenInOrder) {
  using enum JsonToken;
  const std::vector<JsonToken> expected = {
      begin_object, name, begin_list, integer, number, string, boolean, null, end_list,
      name, begin_object, end_object, name, begin_list, end_list, name, number, end_object, end};
  EXPECT_EQ(tokens_of(kText), expected);
}

TEST(JsonReader, RejectsEveryTruncation) {
  const std::string_view whole = kText.substr(0, kText.size() - 1);  // up to the last bracket
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_EQ(failure_of(whole.substr(0, size)), ErrorKind::corrupt) << size;
  }
}

TEST(JsonReader, RejectsWhatIsNoJson) {
  for (const char* text :
       {"", " ", "{", "}", "[1,]", "[,1]", "[1 2]", "{1:2}", R"({"a"})", R"({"a":})", R"({"a":1,})",
        R"({"a" 1})", R"({,"a":1})", "[1}", R"({"a":1])", "01", "-", "+1", "1.", ".5", "1e", "1e+",
        "0x1", "nul", "True", "truefalse", "1 2", "{}{}", "'a'", "\"a", "\"\\", "\"\\x\"",
        "\"\\u12\"", "\"\\u12g4\"", "\"\\u-123\"", "\"\\ud800\"", "\"\\ud800\\u0041\"",
        "\"\\udc00\"", "\"\\ud800x\"", "\"a\nb\"", "\"\x01\"", "\"\x80\"", "\"\xc3\"",
        "\"\xc0\xaf\"", "\"\xed\xa0\x80\"", "\"\xf4\x90\x80\x80\"", "\xef\xbb\xbf{}", "NaN"}) {
    EXPECT_EQ(failure_of(text), ErrorKind::corrupt) << text;
  }
}

TEST(JsonReader, DecodesStrings) {
  EXPECT_EQ(string_of(R"("\"\\\/\b\f\n\r\t")"), "\"\\/\b\f\n\r\t");
  EXPECT_EQ(string_of(R"("\u0041\u00b5\u20ac\ud83d\ude00\uD83D\uDE00")"),
            "A\u00b5\u20ac\U0001F600\U0001F600");
  EXPECT_EQ(string_of("\"\u00b5\U0001F600\x7f\""), "\u00b5\U0001F600\x7f");
  EXPECT_EQ(string_of(R"("a\u0000b")"), std::string("a\0b", 3));
}

TEST(JsonReader, TellsWhichNumbersFit) {
  const auto integer = [](std::string_view text) {
    JsonReader in(text);
    in.next();
    return in.integer();
  };
  const auto number = [](std::string_view text) {
    JsonReader in(text);
    in.next();
    return in.number();
  };
  EXPECT_EQ(integer("-9223372036854775808"), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(integer("9223372036854775807"), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(integer("9223372036854775808"), std::nullopt);
  EXPECT_EQ(integer("1.0"), std::nullopt);
  EXPECT_EQ(number("7"), 7);
  EXPECT_EQ(number("-1.25e2"), -125);
  EXPECT_EQ(number("1e400"), std::nullopt);
  EXPECT_EQ(number(std::string(5000, '9')), std::nullopt);
  EXPECT_EQ(number("\"7\""), std::nullopt);
}

TEST(JsonReader, StopsAtItsLimits) {
  const auto depth = static_cast<std::size_t>(kMaxJsonDepth);
  EXPECT_EQ(tokens_of(nested(depth)).size(), 2 * depth + 1);
  EXPECT_EQ(failure_of(nested(depth + 1)), ErrorKind::limit_exceeded);
  EXPECT_EQ(failure_of(std::string(100000, '[')), ErrorKind::limit_exceeded);
  EXPECT_EQ(failure_of(nested(100000)), ErrorKind::limit_exceeded);

  std::string list = "[0";
  for (std::size_t i = 2; i < kMaxJsonValues; ++i) list += ",0";
  EXPECT_EQ(tokens_of(list + "]").size(), kMaxJsonValues + 2);
  EXPECT_EQ(failure_of(list + ",0]"), ErrorKind::limit_exceeded);

  const std::string longest(kMaxJsonStringBytes, 'a');
  EXPECT_EQ(string_of("\"" + longest + "\""), longest);
  EXPECT_EQ(failure_of("\"a" + longest + "\""), ErrorKind::limit_exceeded);
  EXPECT_EQ(failure_of("{\"a" + longest + "\":1}"), ErrorKind::limit_exceeded);
}

TEST(JsonReader, SkipsWholeValues) {
  const std::string_view text = R"({"a": {"b":[1,{"]":"}"}]} , "c" :[ ], "d":-1})";
  const JsonObject members = json_members(text);
  ASSERT_EQ(members.members().size(), 3U);
  EXPECT_EQ(members.json_of("a"), R"({"b":[1,{"]":"}"}]})");
  EXPECT_EQ(members.json_of("c"), "[ ]");
  EXPECT_EQ(members.json_of("d"), "-1");
  EXPECT_EQ(members.json_of("e"), "");
  EXPECT_THROW(json_members("[1]"), Error);
  EXPECT_THROW(json_members("{} x"), Error);
}

TEST(NormalJson, HasOneFormForEveryValue) {
  const auto written = [](std::string_view text) {
    return normal_json(text, MemberOrder::as_written);
  };
  EXPECT_EQ(written("{ \"b\" : [ 1.50 , -0, 1e-04,18446744073709551615 ,1e2, {} ] , \"a\":null }"),
            R"({"b":[1.5,0,0.0001,18446744073709551615,100.0,{}],"a":null})");
  EXPECT_EQ(written("36893488147419103232"), "3.6893488147419103e+19");
  EXPECT_EQ(written(R"(["\u00b5\/\u0041\u0001\u001f\t\u007f"])"),
            "[\"\u00b5/A\\u0001\\u001f\\t\x7f\"]");
  EXPECT_EQ(written(R"({"a":1,"b":2,"\u0061":3})"), R"({"a":3,"b":2})");
  EXPECT_EQ(normal_json(R"({"b":{"d":1,"c":2},"a":[{"f":1,"e":2}],"B":0,"b":{"z":1,"y":2}})",
                        MemberOrder::by_name),
            R"({"B":0,"a":[{"e":2,"f":1}],"b":{"y":2,"z":1}})");
}

TEST(JsonText, ReplacesWhatIsNoUtf8) {
  EXPECT_EQ(json_string("a\xff"
                        "b\xe2\x82"
                        "c\xc3"),
            "\"a\ufffd"
            "b\ufffd"
            "c\ufffd\"");
  EXPECT_EQ(json_string("\xed\xa0\x80"), "\"\ufffd\ufffd\ufffd\"");
}

TEST(JsonText, CutsStringsThatNoReaderTakes) {
  const std::string longer = std::string(kMaxJsonStringBytes - 1, 'a') + "\u00b5";
  const std::string json = json_string(longer);
  EXPECT_EQ(string_of(json), std::string(kMaxJsonStringBytes - 1, 'a'));
}

TEST(JsonObject, KeepsTheOrderInWhichItWasFilled) {
  JsonObject object;
  object.set("z", 1).set("a", 2.0).set("m", "x").set("z", std::vector<bool>{true, false});
  object.set("p", std::array<double, 2>{0.5, -1}).set("o", JsonObject().set("q", false));
  EXPECT_EQ(object.text(), R"({"z":[true,false],"a":2.0,"m":"x","p":[0.5,-1.0],"o":{"q":false}})");
  object.erase("a");
  object.sort_by_name();
  EXPECT_EQ(object.text(), R"({"m":"x","o":{"q":false},"p":[0.5,-1.0],"z":[true,false]})");
  EXPECT_EQ(JsonObject().text(), "{}");
  EXPECT_EQ(JsonObject().set("a", std::vector<int>{}).text(), R"({"a":[]})");
}

}  // namespace
}  // namespace octavo
