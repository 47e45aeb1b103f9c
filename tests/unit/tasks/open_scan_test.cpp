#include "octavo/tasks/open_scan.h"

#include "support/scan_files.h"
#include "support/sought_planes.h"

namespace octavo {
namespace {

class OpenScan : public testing::ScanFiles {};

TEST_F(OpenScan, AScanAndAFileGiveTheSamePlanes) {
  const std::string raw = write_raw("scan.raw", voxels_);
  const std::string file = write_grey("scan.8vo");
  const auto a = open_planes({raw}, scan_, context_);
  const auto b = open_planes({file}, {}, context_);
  std::vector<std::byte> plane_a(static_cast<std::size_t>(plane_bytes(a->description())));
  std::vector<std::byte> plane_b(plane_a.size());
  for (std::int64_t z = 0; z < kScanSize.z; ++z) {
    a->read_plane(plane_a);
    b->read_plane(plane_b);
    ASSERT_EQ(plane_a, plane_b) << z;
  }
}

TEST_F(OpenScan, PlanesAreTheSameFromAnywhere) {
  testing::expect_same_from_anywhere(
      *open_planes({write_raw("scan.raw", voxels_)}, scan_, context_));
  testing::expect_same_from_anywhere(*open_planes({write_grey("scan.8vo")}, {}, context_));
}

TEST_F(OpenScan, FilesArePassedOn) {
  const std::string raw = write_raw("scan.raw", voxels_);
  const std::string file = write_grey("scan.8vo");
  EXPECT_EQ(open_planes({raw}, scan_, context_)->files(), files_of_volume({raw}));
  EXPECT_EQ(open_planes({file}, {}, context_)->files(), files_of_volume({file}));
}

TEST_F(OpenScan, WarningsArePassedOn) {
  scan_.source.spacing_mm.reset();
  open_scan({write_raw("scan.raw", voxels_)}, scan_, context_);
  EXPECT_EQ(warnings_.size(), 1u);
}

TEST_F(OpenScan, OptionsOfScansAreRejectedForFiles) {
  const std::string file = write_grey("scan.8vo");
  const auto field_of = [&](const ScanOptions& options) {
    return failure_of([&] { open_planes({file}, options, context_); }).field;
  };
  ScanOptions options;
  EXPECT_EQ(field_of(options), "nothing failed");
  options.source.keep_identity = true;
  EXPECT_EQ(field_of(options), "nothing failed");
  options.source.untilt = true;
  EXPECT_EQ(field_of(options), "scan.untilt");
  options.source.on_gap = GapPolicy::fill;
  EXPECT_EQ(field_of(options), "scan.on_gap");
  EXPECT_NO_THROW(open_planes({file}, options, context_, OptionsOf::any_source));
}

}  // namespace
}  // namespace octavo
