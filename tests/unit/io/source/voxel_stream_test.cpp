#include "octavo/io/source/voxel_stream.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(VoxelStream, DamageInAGzipStreamNeverChangesAVoxel) {
  const TempFolder folder;
  const std::string whole = gzip(nifti_header({}) + bytes_of(kStoredValues));
  for (std::size_t at = 10; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    write_file(folder.file("a.nii.gz"), damaged);
    try {
      // Some bits of a stream can change without changing what it inflates to.
      const auto source = open_source({folder.file("a.nii.gz")}, {});
      EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues)) << at;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << at;
    }
  }
}

TEST(VoxelStream, GzipOfSeveralMembersIsOneStream) {
  const TempFolder folder;
  const std::string bytes = nifti_header({}) + bytes_of(kStoredValues);
  write_file(folder.file("a.nii.gz"), gzip(bytes.substr(0, 360)) + gzip(bytes.substr(360)));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.nii.gz")}, {})), bytes_of(kStoredValues));
}

}  // namespace
}  // namespace octavo::testing
