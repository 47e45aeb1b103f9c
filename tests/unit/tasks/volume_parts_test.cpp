#include "octavo/tasks/volume_parts.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class VolumeParts : public testing::ScanFiles {};

TEST_F(VolumeParts, SidesLeftOutAreThoseOfTheVolume) {
  AskedBox asked;
  asked.lo[0] = 3;
  asked.hi[2] = 7;
  EXPECT_EQ(box_within(asked, {10, 11, 12}), (Box{{3, 0, 0}, {10, 11, 7}}));
}

TEST_F(VolumeParts, BoxesThatAreEmptyOrReachOutsideAreRejected) {
  for (const auto& [lo, hi] : {std::pair{5, 5}, {6, 5}, {-1, 5}, {3, 11}}) {
    AskedBox asked;
    asked.lo[1] = lo;
    asked.hi[1] = hi;
    EXPECT_EQ(failure_of([&, a = asked] { box_within(a, {10, 10, 10}); }).kind,
              ErrorKind::invalid_argument)
        << lo << ":" << hi;
  }
}

TEST_F(VolumeParts, ABoxInMmHoldsTheVoxelsCenteredInIt) {
  const Geometry geometry{{-10, 20, 5}, {0.5, 0.5, 2}};
  EXPECT_EQ(box_within_mm({{-9.5, 20, 5.1}, {-8.6, 20.4, 100}}, geometry, {10, 10, 10}),
            (Box{{1, 0, 1}, {3, 1, 10}}));
  EXPECT_EQ(failure_of([&] { box_within_mm({{0, 0, 0}, {1, 1, 1}}, geometry, {10, 10, 10}); }).kind,
            ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo
