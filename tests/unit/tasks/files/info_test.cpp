#include "octavo/tasks/files/info.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class Info : public testing::ScanFiles {};

TEST_F(Info, SaysWhatTheFileHolds) {
  const std::string path = write_grey("scan.8vo");
  const InfoResult result = info({path}, context_);
  EXPECT_EQ(result.volume.size, kScanSize);
  EXPECT_EQ(result.raw_bytes, voxels_.size() * 2);
  EXPECT_EQ(result.file_bytes, std::filesystem::file_size(path));
  const auto [low, high] = std::minmax_element(voxels_.begin(), voxels_.end());
  EXPECT_EQ(result.range.min, *low);
  EXPECT_EQ(result.range.max, *high);
  EXPECT_EQ(result.max_error, 0);
  EXPECT_TRUE(result.is_range_exact());
  ASSERT_GT(result.levels.size(), 1u);
  EXPECT_EQ(result.levels[0].size, kScanSize);
  EXPECT_EQ(result.levels[0].spacing_mm, geometry_.spacing_mm);
  EXPECT_DOUBLE_EQ(result.bits_per_voxel() * result.compression_ratio(), 16);
}

TEST_F(Info, AFolderIsNoFile) {
  EXPECT_EQ(failure_of([&] { info({folder_.file("")}, context_); }).field, "input.format");
}

}  // namespace
}  // namespace octavo
