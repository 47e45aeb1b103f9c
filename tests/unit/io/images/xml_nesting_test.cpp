#include "octavo/io/images/xml_nesting.h"

#include <gtest/gtest.h>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

const std::string kOme =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?><!-- by > hand --><OME xmlns=\"http://x/OME\">"
    "<Image ID=\"Image:0\" Name=\"a > b\"><Description>1 &lt; 2 <![CDATA[</Image>]]></Description>"
    "<Pixels DimensionOrder=\"XYCZT\" SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\" SizeX=\"4\" SizeY='3'>"
    "<TiffData IFD=\"0\" PlaneCount=\"2\"/></Pixels></Image></OME>";

TEST(XmlNesting, OfAWholeElementIsSound) {
  EXPECT_EQ(nesting_damage(kOme), "");
  EXPECT_EQ(nesting_damage(kOme + "\n<!-- what follows"), "");
  EXPECT_EQ(nesting_damage("<OME/>"), "");
  EXPECT_EQ(nesting_damage("<OME:OME a='1'></OME:OME >"), "");
  EXPECT_EQ(nesting_damage("<OME><Image Name=\"5\" disk\"/></OME>"), "");
}

TEST(XmlNesting, OfEachStartOfATextIsDamaged) {
  const std::size_t end = kOme.size();
  for (std::size_t bytes = 0; bytes < end; ++bytes) {
    EXPECT_NE(nesting_damage(kOme.substr(0, bytes)), "") << bytes;
  }
}

TEST(XmlNesting, NamesTheElementThatIsNotClosed) {
  EXPECT_TRUE(contains(nesting_damage("<OME><Image><Pixels a='1'>"), "Pixels is not closed"));
  EXPECT_TRUE(contains(nesting_damage("<OME><Image><Pixels></Image></OME>"),
                       "Pixels is closed by </Image>"));
  EXPECT_TRUE(contains(nesting_damage("<OME><Image Name=\"a"), "tag without an end"));
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "<a>";
  EXPECT_TRUE(contains(nesting_damage(deep), "too deep"));
}

TEST(XmlNesting, OfAnOmeDescriptionThatIsCutRejectsTheFile) {
  const TempFolder folder;
  TiffSample sample;
  sample.pages = {counted(12, 0), counted(12, 1)};
  sample.description = kOme;
  write_tiff(folder.file("a.ome.tif"), sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.ome.tif")}, {})),
            sample.pages[0] + sample.pages[1]);
  for (const std::string part : {"<Image", "<Pixels", "SizeC", "<TiffData", "</Pixels", "</OME"}) {
    sample.description = kOme.substr(0, kOme.rfind(part) + 1);
    write_tiff(folder.file("a.ome.tif"), sample);
    expect_rejected(folder.file("a.ome.tif"), {"its OME description is damaged"});
  }
}

}  // namespace
}  // namespace octavo::testing
