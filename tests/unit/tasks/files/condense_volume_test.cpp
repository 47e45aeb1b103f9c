#include "octavo/tasks/files/condense_volume.h"

#include <cmath>
#include <span>

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

TEST_F(CondenseVolume, FloatsTakeMeansThatTheirFileCanHold) {
  constexpr Size3 kFloats = {40, 33, 21};
  testing::Volume volume;
  volume.description.size = kFloats;
  volume.description.type = VoxelType::float32;
  std::vector<float> voxels;
  for (std::int64_t i = 0; i < kFloats.voxel_count(); ++i) {
    const std::int64_t noise = i * 2654435761 % 7;
    voxels.push_back(static_cast<float>(static_cast<double>(i % 40 / 8 * 20 + noise) * 0.25 - 3));
  }
  const auto bytes = std::as_bytes(std::span(voxels));
  volume.voxels.assign(bytes.begin(), bytes.end());
  options_.input = folder_.file("floats.8vo");
  testing::build_volume(volume, options_.input, 1);
  for (const double flat : {0.0, 0.24, 1.5}) {
    options_.flat = flat;
    options_.output.overwrite = true;
    condense_volume(options_, context_);
    const auto made = testing::open_file(options_.output.path);
    EXPECT_EQ(made->description().type, VoxelType::float32);
    EXPECT_EQ(made->max_error(), 0);
    std::vector<float> condensed(voxels.size());
    made->read(box_of(kFloats), 0, condensed.data());
    std::size_t changed = 0;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      ASSERT_LE(std::abs(condensed[i] - voxels[i]), flat) << i;
      changed += condensed[i] != voxels[i] ? 1u : 0u;
    }
    // Steps are 0.25; columns of 8 lie within 1.5.
    EXPECT_EQ(changed > 0, flat == 1.5);
    if (flat == 1.5) {
      for (std::size_t x = 0; x < 8; ++x) EXPECT_EQ(condensed[x], condensed[0]) << x;
    }
  }
}

TEST_F(CondenseVolume, FloatsWithoutAMeanAreRejectedForWhatTheyAre) {
  testing::Volume volume;
  volume.description.size = {40, 33, 21};
  volume.description.type = VoxelType::float32;
  const auto says = [&](const char* name, float odd, const char* words) {
    std::vector<float> voxels;
    for (std::int64_t i = 0; i < volume.description.size.voxel_count(); ++i) {
      voxels.push_back(static_cast<float>(i % 7) * 0.5f);
    }
    voxels[1000] = odd;
    const auto bytes = std::as_bytes(std::span(voxels));
    volume.voxels.assign(bytes.begin(), bytes.end());
    options_.input = folder_.file(name);
    options_.flat = 1;
    testing::build_volume(volume, options_.input, 1);
    const auto failure = failure_of([&] { condense_volume(options_, context_); });
    EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
    EXPECT_NE(failure.detail.find(words), std::string::npos) << failure.detail;
  };
  says("nan.8vo", std::nanf(""), "NaN or infinite");
  says("infinite.8vo", -INFINITY, "NaN or infinite");
  says("odd.8vo", 0.123f, "no multiples of one number");
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
