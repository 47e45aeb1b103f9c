#include "octavo/io/volumes/raw_source.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(RawSource, GivesThePlanesOfOneFileOrMany) {
  const TempFolder folder;
  const std::vector<std::int16_t> values = {1, -2, 300, -32768, 5, 6, 7, 32767};
  SourceOptions options;
  options.raw = parse_raw_layout("2,2,2,int16:be");
  write_file(folder.file("all.raw"), bytes_of(values, true));
  EXPECT_EQ(voxels_of(*open_source({folder.file("all.raw")}, options)), bytes_of(values));
  write_file(folder.file("planes/z10"), bytes_of<std::int16_t>({5, 6, 7, 32767}, true));
  write_file(folder.file("planes/z9"), bytes_of<std::int16_t>({1, -2, 300, -32768}, true));
  EXPECT_EQ(voxels_of(*open_source({folder.file("planes")}, options)), bytes_of(values));
  write_file(folder.file("all.raw"), std::string(15, 'x'));
  const Error error = source_error({folder.file("all.raw")}, options);
  EXPECT_TRUE(contains(error, "16 bytes") && contains(error, "15")) << error.what();
}

}  // namespace
}  // namespace octavo::testing
