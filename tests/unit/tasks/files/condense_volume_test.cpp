#include "octavo/tasks/files/condense_volume.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class CondenseVolume : public testing::ScanFiles {
 protected:
  void SetUp() override {
    options_.input = write_grey("scan.8vo");
    options_.output.path = folder_.file("cubes.8vo");
  }

  Failure failure() {
    return failure_of([&] { condense_volume(options_, context_); });
  }

  CondenseVolumeOptions options_;
};

TEST_F(CondenseVolume, NoVoxelMovesFurtherThanAllowed) {
  options_.flat = 8;
  condense_volume(options_, context_);
  const testing::DenseLabels read_back = read(options_.output.path);
  std::size_t changed = 0;
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    ASSERT_LE(std::abs(read_back.voxels[i] - voxels_[i]), 8) << i;
    changed += read_back.voxels[i] != voxels_[i] ? 1u : 0u;
  }
  EXPECT_GT(changed, 0u);
}

TEST_F(CondenseVolume, TheMetadataSayHowItWasMade) {
  options_.flat = 8;
  condense_volume(options_, context_);
  const std::string metadata =
      testing::open_file(options_.output.path)->description().metadata.text();
  EXPECT_NE(metadata.find(R"("made_by":{"operation":"condense","flat":8.0})"), std::string::npos)
      << metadata;
}

TEST_F(CondenseVolume, BadOptionsAreRejected) {
  options_.flat = -1;
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument);
  options_.flat = 1;
  options_.output = {options_.input, true};
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument) << "the input itself";
  options_.output.path = folder_.file("cubes.nii");
  EXPECT_EQ(failure().field, "output.format");
  options_.output.path = folder_.file("cubes.8vo");
  options_.input = write("labels.8vo", testing::DenseLabels({8, 8, 8}, 1));
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument) << "labels";
}

}  // namespace
}  // namespace octavo
