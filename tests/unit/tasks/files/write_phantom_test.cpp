#include "octavo/tasks/files/write_phantom.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class WritePhantom : public testing::ScanFiles {
 protected:
  void SetUp() override {
    options_.phantom.size = {24, 20, 16};
    options_.phantom.noise_sigma = 5;
  }

  WritePhantomOptions options_;
};

TEST_F(WritePhantom, TheSameVoxelsAsAFileAndPlain) {
  options_.output.path = folder_.file("phantom.8vo");
  EXPECT_TRUE(
      std::holds_alternative<BuiltVolume>(write_phantom(options_, context_).written));
  const testing::DenseLabels built = read(options_.output.path);
  options_.output.path = folder_.file("phantom.mhd");
  const WritePhantomResult plain = write_phantom(options_, context_);
  const auto& written = std::get<PlaneWriteResult>(plain.written);
  EXPECT_EQ(written.files,
            (std::vector{folder_.file("phantom.mhd"), folder_.file("phantom.raw")}));
  const std::string bytes = testing::bytes_of_file(folder_.file("phantom.raw"));
  ASSERT_EQ(bytes.size(), built.voxels.size() * 2);
  for (std::size_t i = 0; i < built.voxels.size(); ++i) {
    std::int16_t voxel = 0;
    std::memcpy(&voxel, bytes.data() + 2 * i, 2);
    ASSERT_EQ(voxel, built.voxels[i]) << i;
  }
}

TEST_F(WritePhantom, OtherFormatsAreRejected) {
  options_.output.path = folder_.file("phantom.nii");
  EXPECT_EQ(failure_of([&] { write_phantom(options_, context_); }).field, "output.format");
}

}  // namespace
}  // namespace octavo
