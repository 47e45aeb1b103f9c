#include "octavo/tasks/files/verify_volume.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class VerifyVolume : public testing::ScanFiles {
 protected:
  void SetUp() override {
    geometry_.origin_mm = {0, 0, 0};
    options_.input = write_grey("scan.8vo");
  }

  VerifyVolumeOptions options_;
};

TEST_F(VerifyVolume, ASoundFileAgainstItsSource) {
  EXPECT_FALSE(verify_volume(options_, context_).against);
  options_.against = {write_raw("scan.raw", voxels_)};
  options_.scan = scan_;
  const VerifyVolumeResult result = verify_volume(options_, context_);
  EXPECT_TRUE(result.report.is_sound());
  EXPECT_EQ(result.volume.size, kScanSize);
  ASSERT_TRUE(result.against);
  EXPECT_TRUE(result.against->is_faithful());
  EXPECT_FALSE(result.against->has_planes_between);
}

TEST_F(VerifyVolume, AnotherSourceIsADifference) {
  voxels_[77] = static_cast<std::int16_t>(voxels_[77] + 1);
  options_.against = {write_raw("scan.raw", voxels_)};
  options_.scan = scan_;
  const SourceCheck check = verify_volume(options_, context_).against.value();
  EXPECT_FALSE(check.is_faithful());
  EXPECT_EQ(check.comparison.different, 1);
}

TEST_F(VerifyVolume, AMaxErrorPromisesNoSignOfZero) {
  // Whole numbers: the largest error that is found is 0.
  std::vector<float> floats(voxels_.begin(), voxels_.end());
  for (float& voxel : floats) voxel = voxel == 0 ? -0.0f : voxel;
  testing::Volume volume;
  volume.description.size = kScanSize;
  volume.description.type = VoxelType::float32;
  volume.description.geometry = geometry_;
  volume.description.metadata = Metadata::read(R"({"spacing_known":true})");
  const auto bytes = std::as_bytes(std::span(floats));
  volume.voxels.assign(bytes.begin(), bytes.end());
  const auto source = make_memory_source(volume.description, volume.voxels);
  NoProgress progress;
  const std::string bounded = folder_.file("bounded.8vo");
  build_file(*source, local_storage(), bounded, {.max_error = 0.5}, progress);
  ASSERT_GT(testing::open_file(bounded)->max_error(), 0);

  options_ = {bounded, {write_raw("floats.raw", floats)}, scan_};
  options_.scan.source.raw = RawLayout{kScanSize, VoxelType::float32};
  EXPECT_TRUE(verify_volume(options_, context_).against->is_faithful());

  // Bit by bit it counts.
  options_.input = folder_.file("exact.8vo");
  testing::build_volume(volume, options_.input, 1);
  EXPECT_TRUE(verify_volume(options_, context_).against->is_faithful());
  for (float& voxel : floats) voxel = voxel == 0 ? 0.0f : voxel;
  options_.against = {write_raw("zeros.raw", floats)};
  EXPECT_FALSE(verify_volume(options_, context_).against->is_faithful());
}

TEST_F(VerifyVolume, DamageIsAResult) {
  damage(options_.input, brick_offset(options_.input), 0x55);
  options_.against = {folder_.file("not opened")};
  const VerifyVolumeResult result = verify_volume(options_, context_);
  EXPECT_EQ(result.report.damaged_brick_count, 1);
  EXPECT_FALSE(result.against);
}

TEST_F(VerifyVolume, ADamagedHeaderNamesRepair) {
  damage(options_.input, 50, 1);
  EXPECT_EQ(failure_of([&] { verify_volume(options_, context_); }).field, "input.repair");
}

TEST_F(VerifyVolume, AScanInThePlaceOfTheFileIsNamed) {
  const std::string file = options_.input;
  options_.input = write_raw("scan.raw", voxels_);
  EXPECT_EQ(failure_of([&] { verify_volume(options_, context_); }).kind, ErrorKind::not_octavo);
  options_.against = {file};
  const Failure failure = failure_of([&] { verify_volume(options_, context_); });
  EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
  EXPECT_NE(failure.detail.find(file + " is one by its name"), std::string::npos) << failure.detail;
}

}  // namespace
}  // namespace octavo
