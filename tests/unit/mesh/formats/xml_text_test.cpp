#include "octavo/mesh/formats/xml_text.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(XmlText, EscapesWhatXmlAsksFor) {
  EXPECT_EQ(xml_text("a<b>&\"c\" \xc3\xa4"), "a&lt;b&gt;&amp;&quot;c&quot; \xc3\xa4");
  EXPECT_EQ(xml_text("two\nlines\t"), "two lines ");
}

TEST(XmlText, ReplacesWhatIsNoCharacter) {
  const std::string replacement = "\xef\xbf\xbd";
  EXPECT_EQ(xml_text("a\xffz"), "a" + replacement + "z");
  EXPECT_EQ(xml_text(std::string_view("\x01\0", 2)), replacement + replacement);
  EXPECT_EQ(xml_text("\xef\xbf\xbf"), replacement);
}

}  // namespace
}  // namespace octavo
