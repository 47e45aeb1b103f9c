#include "octavo/io/source/streamed_source.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(StreamedSource, BytesBehindTheVoxelsAreReported) {
  const TempFolder folder;
  const std::string bytes = nifti_header({}) + bytes_of(kStoredValues) + "more";
  for (const std::string& name : {std::string("a.nii"), std::string("a.nii.gz")}) {
    write_file(folder.file(name), name.ends_with("gz") ? gzip(bytes) : bytes);
    const auto source = open_source({folder.file(name)}, {});
    EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues));
    ASSERT_EQ(source->warnings().size(), 1U);
    EXPECT_TRUE(contains(source->warnings()[0], "4 bytes behind"));
  }
}

}  // namespace
}  // namespace octavo::testing
