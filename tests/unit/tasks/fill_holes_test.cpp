#include "octavo/tasks/fill_holes.h"

#include <map>
#include <random>

#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseLabels;
using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kFillHolesSize = {66, 21, 19};

class FillHoles : public testing::TaskFiles {
 protected:
  void SetUp() override {
    std::mt19937 random(5);
    mask_ = DenseMask{kFillHolesSize, std::vector<std::uint8_t>(
                                 static_cast<std::size_t>(kFillHolesSize.voxel_count()))};
    for (std::uint8_t& voxel : mask_.voxels) voxel = random() % 10 < 7 ? 1 : 0;
    options_.input = write("mask.8vo", mask_);
    options_.output = {folder_.file("filled.8vo"), true};
  }

  /// Parts of the background that do not reach the border, by their number in `parts`.
  std::map<std::int32_t, std::uint64_t> holes_of(const DenseLabels& parts) const {
    std::map<std::int32_t, std::uint64_t> holes;
    for_each_voxel(kFillHolesSize, [&](const Index3& p) {
      if (mask_.at(p) == 0) ++holes[parts.at(p)];
    });
    for_each_voxel(kFillHolesSize, [&](const Index3& p) {
      const bool is_border = p.x == 0 || p.y == 0 || p.z == 0 || p.x == kFillHolesSize.x - 1 ||
                             p.y == kFillHolesSize.y - 1 || p.z == kFillHolesSize.z - 1;
      if (is_border) holes.erase(parts.at(p));
    });
    return holes;
  }

  DenseMask mask_;
  FillHolesOptions options_;
};

TEST_F(FillHoles, BackgroundThatAFloodFromTheBorderDoesNotReachIsFilled) {
  for (const auto& [object, background] : {std::pair{6, 26}, {18, 6}, {26, 6}}) {
    const DenseLabels parts = testing::flooded(mask_, background);
    const auto holes = holes_of(parts);
    ASSERT_FALSE(holes.empty() && background == 6);
    options_.connectivity = static_cast<Connectivity>(object);
    const FillHolesResult result = fill_holes(options_, context_);
    EXPECT_EQ(read(options_.output.path), computed(kFillHolesSize, [&](const Index3& p) {
                return mask_.at(p) != 0 || holes.contains(parts.at(p));
              }));
    EXPECT_EQ(result.hole_count, holes.size());
    EXPECT_EQ(result.larger_hole_count, 0u);
  }
}

TEST_F(FillHoles, LargerHolesAreLeft) {
  const auto holes = holes_of(testing::flooded(mask_, 6));
  options_.max_mm3 = 0.5;  // one voxel
  const FillHolesResult result = fill_holes(options_, context_);
  const auto small = static_cast<std::uint64_t>(
      std::count_if(holes.begin(), holes.end(), [](const auto& hole) { return hole.second == 1; }));
  EXPECT_EQ(result.hole_count, small);
  EXPECT_EQ(result.hole_voxels, small);
  EXPECT_EQ(result.larger_hole_count, holes.size() - small);
}

TEST_F(FillHoles, AVolumeInMm3NeedsASpacing) {
  options_.input = write("unknown.8vo", mask_, false);
  options_.max_mm3 = 1;
  EXPECT_EQ(failure_of([&] { fill_holes(options_, context_); }).field, "input.spacing_mm");
}

}  // namespace
}  // namespace octavo
