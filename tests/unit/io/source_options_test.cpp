#include "octavo/io/source_options.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(SourceOptions, RawLayoutsThatMakeNoSenseAreRejected) {
  for (const char* text :
       {"", "1,2,3", "1,2,3,4,5", "0,2,3,uint8", "-1,2,3,uint8", "2,2,2,float16", "2,2,2097153,u8",
        "2,2,x,u8", "2,2,2,u8:xx", "99999999999999999999,1,1,u8"}) {
    EXPECT_EQ(error_of([&] { parse_raw_layout(text); }).kind(), ErrorKind::invalid_argument)
        << text;
  }
}

TEST(SourceOptions, TheFirstOptionOfDicomIsNamedByItsField) {
  EXPECT_EQ(SourceOptions{}.dicom_option(), "");
  SourceOptions options;
  options.untilt = true;
  EXPECT_EQ(options.dicom_option(), "untilt");
  options.on_gap = GapPolicy::ignore;
  EXPECT_EQ(options.dicom_option(), "untilt");
  options.on_gap = GapPolicy::fill;
  EXPECT_EQ(options.dicom_option(), "on_gap");
  options.drop_duplicates = true;
  EXPECT_EQ(options.dicom_option(), "on_gap");
}

}  // namespace
}  // namespace octavo::testing
