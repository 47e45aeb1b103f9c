#include "octavo/io/source/label_table_xml.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr const char* kColor = " Red=\"1\" Green=\"0.5\" Blue=\"0\"";

std::string element(const std::string& rest) { return "<Label Key=\"7\"" + (kColor + rest); }

XmlLabel only_label(const std::string& text) {
  const std::vector<XmlLabel> labels = labels_in_xml(text);
  EXPECT_EQ(labels.size(), 1u) << text;
  return labels.empty() ? XmlLabel() : labels.front();
}

void expect_xml_rejected(const std::string& text, const std::string& words) {
  const Error error = error_of([&] { labels_in_xml(text); });
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << text;
  EXPECT_TRUE(contains(error, words)) << text << ": " << error.what();
}

TEST(LabelTableXml, EveryFormOfAnElementIsRead) {
  for (const std::string& text :
       {element(">Lung</Label>"), element(" Alpha = '1' >\n  Lung\n</Label>"),
        element("><![CDATA[Lung]]></Label>"), element(">\n<![CDATA[Lung]]>\n</Label>")}) {
    const XmlLabel label = only_label(text);
    EXPECT_EQ(label.key, "7");
    EXPECT_EQ(label.color, (std::array<std::string, 3>{"255", "128", "0"}));
    EXPECT_EQ(label.name, "Lung") << text;
  }
  EXPECT_EQ(only_label(element("/>")).name, "");
  EXPECT_EQ(only_label("<Label Index='3' Red='0' Green='0' Blue='0'>a</Label>").key, "3");
  EXPECT_EQ(only_label(element(">R&amp;D &lt;x&gt; &quot;&apos;</Label>")).name, "R&D <x> \"'");
}

TEST(LabelTableXml, OtherElementsAreLeftOutAndLinesAreCounted) {
  const std::string text = "<?xml version=\"1.0\"?>\n<GIFTI>\n<LabelTable>\n" +
                           element(">a</Label>") + "\n\n" + element(">b</Label>") +
                           "\n</LabelTable><Labels Key='9'/></GIFTI>";
  const std::vector<XmlLabel> labels = labels_in_xml(text);
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_EQ(labels[0].line, 4u);
  EXPECT_EQ(labels[1].line, 6u);
  EXPECT_EQ(labels[1].name, "b");
  EXPECT_TRUE(labels_in_xml("<atlas><label index=\"1\">a</label></atlas>").empty());
}

TEST(LabelTableXml, CommentsAreLeftOutAndLinesStay) {
  const std::string text = "<LabelTable><!-- " + element(">no</Label>") + "\n <!-- - -->" +
                           element("><!-- x -->Lu<!-- ]]> -->ng</Label>") +
                           "\n<![CDATA[" + element(">no</Label>") + "]]>" +
                           element("><![CDATA[<!-- a -->]]></Label>") + "</LabelTable>";
  const std::vector<XmlLabel> labels = labels_in_xml(text);
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_EQ(labels[0].name, "Lung");
  EXPECT_EQ(labels[0].line, 2u);
  EXPECT_EQ(labels[1].name, "<!-- a -->");
  EXPECT_EQ(labels[1].line, 3u);
  EXPECT_TRUE(labels_in_xml("<!-- " + element(">no</Label>")).empty());
}

TEST(LabelTableXml, ReferencesMayBeNumbers) {
  EXPECT_EQ(only_label(element(">K&#252;che</Label>")).name, "K\u00fcche");
  EXPECT_EQ(only_label(element(">&#x41;&#x1F600;</Label>")).name, "A\U0001f600");
  for (const char* const bad : {"&#0;", "&#xd800;", "&#x110000;", "&#99999999999;", "&#;", "&#x;",
                                "&#41", "&#-1;", "&#1a;"}) {
    expect_xml_rejected(element(std::string(">") + bad + "</Label>"),
                        "&# begins no number of a character");
  }
}

TEST(LabelTableXml, WhatIsNoLabelIsRejectedWithItsLine) {
  expect_xml_rejected("\n" + element(">a"), "line 2: an element is cut off");
  expect_xml_rejected(element(" "), "an element is cut off");
  expect_xml_rejected(element(" Alpha=1>a</Label>"), "an attribute has no quotes");
  expect_xml_rejected(element(" Alpha=\"1>a</Label>"), "an element is cut off");
  expect_xml_rejected("<Label Red='0' Green='0' Blue='0'>a</Label>", "a label lacks its Key");
  expect_xml_rejected("<Label Key='1' Red='0' Green='0'>a</Label>", "a label lacks its Blue");
  expect_xml_rejected("<Label Key='1' Red='1.1' Green='0' Blue='0'>a</Label>",
                      "'1.1' is no part of a color: expected 0 to 1");
  expect_xml_rejected("<Label Key='1' Red='nan' Green='0' Blue='0'>a</Label>",
                      "no part of a color");
  expect_xml_rejected(element(">&uuml;</Label>"), "& begins no reference");
}

TEST(LabelTableXml, EveryTruncationEndsInLabelsOrAnError) {
  const std::string text = element(" Alpha='1'><![CDATA[a]]></Label>");
  for (std::size_t length = 0; length < text.size(); ++length) {
    try {
      EXPECT_TRUE(labels_in_xml(text.substr(0, length)).empty()) << length;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << length;
    }
  }
}

}  // namespace
}  // namespace octavo::testing
