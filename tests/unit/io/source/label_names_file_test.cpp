#include "octavo/io/source/label_names_file.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// The names in a file of this text.
LabelNames names_in(const std::string& text) {
  const TempFolder folder;
  write_file(folder.file("names.txt"), text);
  return read_label_names(folder.file("names.txt"));
}

LabelNames names_of(const std::vector<std::pair<std::int64_t, LabelName>>& entries) {
  LabelNames names;
  for (const auto& [label, entry] : entries) names.set(label, entry);
  return names;
}

LabelName named(const std::string& name, std::optional<LabelColor> color = {}) {
  return {name, color};
}

void expect_line_rejected(const std::string& text, const std::string& words) {
  const Error error = error_of([&] { names_in(text); });
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << text;
  EXPECT_TRUE(contains(error, "names.txt: " + words)) << text << ": " << error.what();
}

TEST(LabelNamesFile, EveryLayoutGivesItsNamesAndColors) {
  const LabelColor kOrange = {255, 128, 0};
  struct Row {
    const char* text;
    LabelName first;
  };
  for (const Row& row : {
           Row{"7 Left_Lung\n8 Heart\n", named("Left_Lung")},
           Row{"7\tLeft Lung\n8\tHeart\n", named("Left Lung")},
           Row{"7 Left_Lung 2001\n8 Heart 2002\n", named("Left_Lung")},
           Row{"7 Left Lung 2001\n8 Heart 2002\n", named("Left Lung")},
           Row{"7 Left_Lung 255 128 0\n8 Heart 1 2 3\n", named("Left_Lung", kOrange)},
           Row{"7 Left Lung 255 128 0\n8 Heart 1 2 3\n", named("Left Lung", kOrange)},
           Row{"7 Left_Lung 255 128 0 0\n8 Heart 1 2 3 255\n", named("Left_Lung", kOrange)},
           Row{"7 \"Left Lung\" 255 128 0 0\n8 Heart 1 2 3 0.5\n", named("Left Lung", kOrange)},
           Row{"Left_Lung 7\nHeart 8\n", named("Left_Lung")},
           Row{"Left Lung 7 255 128 0\nHeart 8 1 2 3\n", named("Left Lung", kOrange)},
           Row{"Left_Lung 7 255 128 0 255\nHeart 8 1 2 3 0\n", named("Left_Lung", kOrange)},
           Row{"7 255 128 0 1 1 1 \"Left Lung\"\n8 1 2 3 0.25 0 1 \"Heart\"\n",
               named("Left Lung", kOrange)},
           Row{"7 255 128 0 1 1 1 Left Lung\n8 1 2 3 1 1 1 Heart\n", named("Left Lung", kOrange)},
           Row{"Left Lung\n7 255 128 0 255\nHeart\n8 1 2 3 0\n", named("Left Lung", kOrange)},
           Row{"<LabelTable><Label Key=\"7\" Red=\"1\" Green=\"0.502\" Blue=\"0\" Alpha=\"1\">"
               "Left Lung</Label>\n<Label Key='8' Red='0.004' Green='0.008' Blue='0.012'>\n"
               "<![CDATA[Heart]]></Label></LabelTable>",
               named("Left Lung", kOrange)},
       }) {
    const LabelName second = named("Heart", row.first.color ? std::optional(LabelColor{1, 2, 3})
                                                            : std::nullopt);
    EXPECT_EQ(names_in(row.text), names_of({{7, row.first}, {8, second}})) << row.text;
  }
}

TEST(LabelNamesFile, LinesEndAsOnAnySystemAndCommentsAreLeftOut) {
  const LabelNames names = names_of({{1, named("a")}, {2, named("b")}});
  for (const char* text :
       {"1 a\n2 b", "1 a\r\n2 b\r\n", "1 a\r2 b\r", "# 3 c\n\n 1  a \n\t\n  # x\n2\tb\n",
        "\xef\xbb\xbf"
        "1 a\n2 b\n",
        "1 a\n1 a\n2 b\n"}) {
    EXPECT_EQ(names_in(text), names) << text;
  }
}

TEST(LabelNamesFile, TextIsUtf8OrElseLatin1) {
  EXPECT_EQ(names_in("1 Sylvius-\xc3\xa9\n").name_of(1), "Sylvius-\xc3\xa9");
  EXPECT_EQ(names_in("1 Sylvius-\xe9\n").name_of(1), "Sylvius-\xc3\xa9");
}

TEST(LabelNamesFile, ANumberThatTellsNamesApartIsNoCode) {
  EXPECT_EQ(names_in("1 BA 17\n2 BA 18\n"), names_of({{1, named("BA 17")}, {2, named("BA 18")}}));
  EXPECT_EQ(names_in("1 V1 17\n2 V2 18\n3 V5 a\n").name_of(1), "V1 17");
}

TEST(LabelNamesFile, ANameInQuotesMayEndInNumbers) {
  EXPECT_EQ(names_in("1 \"Area 3 1 2\"\n2 b\n").name_of(1), "Area 3 1 2");
  EXPECT_EQ(names_in("1 \"#1, 2\"\n").name_of(1), "#1, 2");
}

TEST(LabelNamesFile, LabelsAreThoseThatVoxelsHold) {
  const LabelNames names = names_in("-2147483648 a\n4294967295 b\n0 c\n");
  EXPECT_EQ(names.size(), 3u);
  EXPECT_EQ(names.name_of(4294967295), "b");
}

TEST(LabelNamesFile, WhatFitsNoLayoutIsRejectedWithItsLine) {
  expect_line_rejected("", "names no label");
  expect_line_rejected("# nothing\n\n", "names no label");
  expect_line_rejected("1 a\n2\n", "line 2: '2' is neither");
  expect_line_rejected("1 a\nb 2\n", "line 2: 'b' is no label");
  expect_line_rejected("a 1\nb\n", "line 2: 'b' is neither");
  expect_line_rejected("<?xml version=\"1.0\"?>\n", "names no label");
  expect_line_rejected("a 1\nb 2.5\n", "line 2: '2.5' is no label");
  expect_line_rejected("1 a\n4294967296 b\n", "line 2: '4294967296' is no label");
  expect_line_rejected("1 a\n-2147483649 b\n", "line 2: '-2147483649' is no label");
  expect_line_rejected("1 a 1 2 256\n", "line 1: '256' is no part of a color");
  expect_line_rejected("1 a -1 2 3\n", "line 1: '-1' is no part of a color");
  expect_line_rejected("1 a 0.5 0.5 1.0 1.0\n", "line 1: '0.5' is no part of a color");
  expect_line_rejected("1 1 2 3 0 0 0 \"a\"\n2 b\n", "line 2: expected INDEX R G B A VIS MSH");
  expect_line_rejected("1 a\n\n2 b 1 2 3\n", "line 3: ends in 3 numbers");
  expect_line_rejected("1 a 1 2 3\n2 b 1 2 3 0\n", "line 2: ends in 4 numbers");
  expect_line_rejected("1 a\r\n2 b\r\n1 c\r\n", "line 3: label 1 has another name in line 1");
  expect_line_rejected("1 a 1 2 3\n1 a 1 2 4\n", "line 2: label 1 has another name in line 1");
  expect_line_rejected("1 \"\"\n", "line 1: the name is empty");
  expect_line_rejected("1 \"a\n", "line 1: a quote is not closed");
}

TEST(LabelNamesFile, SmallNumbersBehindSeveralWordsArePartOfAName) {
  EXPECT_EQ(names_in("1 Left Crus 2\n2 Left Lobe 4\n"),
            names_of({{1, named("Left Crus 2")}, {2, named("Left Lobe 4")}}));
}

TEST(LabelNamesFile, WhatWouldChangeANameUnseenIsRejected) {
  expect_line_rejected("1 A #ff8000\n", "line 1: ends in a color in hexadecimal");
  expect_line_rejected("1 B\n2 \"Right \"\"upper\"\" lobe\"\n", "line 2: behind a closed quote");
  for (const char* const turn : {"\u202a", "\u202e", "\u2066", "\u2069"}) {
    expect_line_rejected("1 " + std::string(turn) + "B\n", "line 1: holds a control character");
  }
  const std::string hebrew = "\u05e8\u05d0\u05e9\u200f";
  EXPECT_EQ(names_in("1 " + hebrew + "\n"), names_of({{1, named(hebrew)}}));
}

TEST(LabelNamesFile, WhatIsNoTextIsRejected) {
  expect_line_rejected("1 a\n2 b\x1b[31m\n", "line 2: holds a control character");
  expect_line_rejected(std::string("1 a\0b\n", 6), "line 1: holds a control character");
  expect_line_rejected("1 a\x7f\n", "line 1: holds a control character");
  expect_line_rejected("\xff\xfe" "1", "is text in UTF-16");
  expect_line_rejected("\xfe\xff" "1", "is text in UTF-16");
}

TEST(LabelNamesFile, ControlCharactersOfLatin1AreNoText) {
  expect_line_rejected("1 a\n2 b\u0085\n", "line 2: holds a control character");
  expect_line_rejected("1 a\u009b31m\n", "line 1: holds a control character");
  expect_line_rejected("1 a\x9b" "31m\n", "line 1: holds a control character");
  expect_line_rejected("1 a\u2028b\n", "line 1: holds a control character");
  EXPECT_EQ(names_in("1 a\u00a0\u00c2\n").name_of(1), "a\u00a0\u00c2");
}

TEST(LabelNamesFile, ALineThatLacksAColumnIsNoName) {
  expect_line_rejected("1 255 0 0 1 1 \"x\"\n", "line 1: a name in quotes stands beside");
  expect_line_rejected("1 255 0 0 1 1 x\n", "line 1: the name begins with three numbers");
  expect_line_rejected("1 a\n2 B \"q\" x\n", "line 2: a name in quotes stands beside");
  expect_line_rejected("1 255 0 0 1 1 1 \"a\" b\n", "line 1: a name in quotes stands beside");
  expect_line_rejected("1 5\"x\n", "line 1: a quote stands inside a word");
  expect_line_rejected("1 \"  \"\n", "line 1: the name is empty");
  expect_line_rejected("1 255 0 0 1 1 1 \"  \"\n", "line 1: the name is empty");
  EXPECT_EQ(names_in("1 255 0 0 1 1 1 \"\"\n").name_of(1), "");
  EXPECT_EQ(names_in("1 \"1 2 3 x\"\n").name_of(1), "1 2 3 x");
}

TEST(LabelNamesFile, NamesOfGiftiMayHoldQuotes) {
  const std::string color = " Red=\"1\" Green=\"0\" Blue=\"0\">";
  EXPECT_EQ(names_in("<Label Key=\"1\"" + color + "\"Co\" 5\"</Label>").name_of(1),
            "\"Co\" 5\"");
  expect_line_rejected("\n<Label Key=\"1\"" + color + "a&#x9b;b</Label>",
                       "line 2: holds a control character");
  expect_line_rejected("<Label Key=\"1 2\"" + color + "a</Label>", "line 1: ");
}

TEST(LabelNamesFile, LimitsEndEveryFile) {
  expect_line_rejected("1 " + std::string(512, 'a') + "\n2 " + std::string(513, 'a'),
                       "line 2: the name is longer than 512 bytes");
  expect_line_rejected("1 a\n" + std::string(4097, ' ') + "\n", "line 2: is longer than 4096");
  expect_line_rejected(std::string((std::size_t{4} << 20) + 1, '\n'), "is longer than 4 MiB");
  std::string most;
  for (std::size_t i = 0; i < LabelNames::kMaxLabels; ++i) most += std::to_string(i) + " a\n";
  EXPECT_EQ(names_in(most).size(), LabelNames::kMaxLabels);
  const std::string one_more = most + std::to_string(LabelNames::kMaxLabels) + " a\n";
  EXPECT_EQ(error_of([&] { names_in(one_more); }).kind(), ErrorKind::limit_exceeded);
  EXPECT_EQ(error_of([&] { names_in(most + most + "1 a\n"); }).kind(), ErrorKind::limit_exceeded);
}

TEST(LabelNamesFile, AMissingFileIsNamed) {
  const Error error = error_of([] { read_label_names("nowhere/names.txt"); });
  EXPECT_EQ(error.kind(), ErrorKind::io);
  EXPECT_EQ(error.path(), "nowhere/names.txt");
}

TEST(LabelNamesFile, AnyBytesAreNamesOrAnError) {
  const TempFolder folder;
  const std::string path = folder.file("names.txt");
  std::uint32_t state = 1;
  constexpr char kAlphabet[] = "01 29\n\r\t\"#-.ae\xc3\xa9\xff\x01";
  for (int round = 0; round < 2'000; ++round) {
    std::string text;
    for (int i = 0; i < round % 60; ++i) {
      state = state * 1664525 + 1013904223;
      text += kAlphabet[(state >> 16) % (sizeof kAlphabet - 1)];
    }
    try {
      write_file(path, text);
      EXPECT_FALSE(read_label_names(path).is_empty());
    } catch (const Error& error) {
      EXPECT_TRUE(contains(error, "names.txt: "));
    }
  }
}

}  // namespace
}  // namespace octavo::testing
