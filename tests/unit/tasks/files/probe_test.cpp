#include "octavo/tasks/files/probe.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class Probe : public testing::ScanFiles {
 protected:
  void SetUp() override { options_.input = write_grey("scan.8vo"); }

  Failure failure() {
    return failure_of([&] { probe(options_, context_); });
  }

  ProbeOptions options_;
};

TEST_F(Probe, ByIndexAndByPlace) {
  options_.indices = {{3, 2, 1}};
  options_.positions_mm = {{-8.6, 21.2, 6.5}};
  const ProbeResult result = probe(options_, context_);
  ASSERT_EQ(result.voxels.size(), 2u);
  for (const ProbedVoxel& voxel : result.voxels) {
    EXPECT_EQ(voxel.index, (Index3{3, 2, 1}));
    EXPECT_EQ(voxel.world_mm, (Point3{-8.5, 21, 7}));
    EXPECT_EQ(voxel.stored, voxels_[(33 + 2) * 40 + 3]);
    EXPECT_EQ(voxel.code, (OCode{0, interleave({3, 2, 1})}));
    EXPECT_EQ(voxel.root_level, 6);
    EXPECT_EQ(voxel.brick.brick, (Index3{0, 0, 0}));
  }
}

TEST_F(Probe, PlacesThatAreNotThereAreRejected) {
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument) << "no place";
  options_.indices = {{40, 0, 0}};
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument) << "outside";
  options_.indices = {{0, 0, 0}};
  options_.level = 40;
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument) << "level";
}

TEST_F(Probe, PlacesInMmNeedAKnownSpacing) {
  options_.input = write("labels.8vo", testing::DenseLabels({8, 8, 8}, 1), false);
  options_.positions_mm = {{1, 1, 1}};
  EXPECT_EQ(failure().field, "input.spacing_mm");
}

}  // namespace
}  // namespace octavo
