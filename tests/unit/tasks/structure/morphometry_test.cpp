#include "octavo/tasks/structure/morphometry.h"

#include <cmath>
#include <filesystem>

#include "octavo/tasks/structure/morphometry_rows.h"
#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kPlateSize = {40, 40, 30};

class MorphometryTask : public testing::TaskFiles {
 protected:
  void SetUp() override {
    geometry_.spacing_mm = {0.5, 0.5, 0.5};
    options_.input = write("plate.8vo", solid([](const Index3& p) {
      return p.z >= 10 && p.z < 18;
    }));
  }

  template <class Inside>
  static DenseMask solid(Inside inside) {
    DenseMask mask{kPlateSize, std::vector<std::uint8_t>(40 * 40 * 30)};
    for_each_voxel(kPlateSize, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
    return mask;
  }

  MorphometryOptions options_;
};

TEST_F(MorphometryTask, MeasuresAPlate) {
  options_.thickness_map = {folder_.file("th.8vo"), false};
  const MorphometryResult result = morphometry(options_, context_);
  EXPECT_EQ(result.voxels, 40u * 40 * 8);
  EXPECT_DOUBLE_EQ(result.bone_mm3, 20 * 20 * 4);
  EXPECT_DOUBLE_EQ(result.total_mm3, 20 * 20 * 15);
  EXPECT_NEAR(result.surface.area_mm2, 2 * 400, 1e-6);
  EXPECT_NEAR(result.smi.value(), 0, 1e-6);
  EXPECT_NEAR(result.thickness->mean_mm, 4, 1e-6);
  EXPECT_EQ(result.euler.corners, 1);
  EXPECT_NEAR(result.anisotropy->degree, 1, 0.02);
  EXPECT_EQ(result.touches, (std::array<bool, 6>{true, true, true, true, false, false}));
  EXPECT_EQ(result.slices[12].voxels, 1600u);
  EXPECT_EQ(result.slices[9].voxels, 0u);
  EXPECT_NEAR(result.slices[12].mean_thickness_mm, 4, 1e-6);
  const testing::DenseLabels map = read(options_.thickness_map.path);
  EXPECT_EQ(map.at({5, 5, 12}), 4);
  EXPECT_EQ(map.at({5, 5, 2}), 0);
}

TEST_F(MorphometryTask, MeasuresWithinARegion) {
  options_.region = write("region.8vo", solid([](const Index3& p) {
    return p.x >= 10 && p.x < 30 && p.y >= 10 && p.y < 30 && p.z >= 5 && p.z < 25;
  }));
  const MorphometryResult result = morphometry(options_, context_);
  EXPECT_DOUBLE_EQ(result.share(), 8.0 / 20);
  EXPECT_NEAR(result.surface.area_mm2, 2 * 100, 1e-6);
  EXPECT_NEAR(result.surface.cut_mm2, 4 * 10 * 4, 1e-6);
  EXPECT_NEAR(result.thickness->mean_mm, 4, 1e-6);
  EXPECT_EQ(result.thickness->voxels, 20u * 20 * 8);
}

TEST_F(MorphometryTask, CalibratesTheScanBeneath) {
  testing::DenseLabels grey(kPlateSize);
  for_each_voxel(kPlateSize, [&](const Index3& p) {
    grey.at(p) = p.z >= 10 && p.z < 18 ? (p.x % 2 == 0 ? 100 : 102) : 10;
  });
  testing::Volume volume = testing::volume_of(grey, 2);
  volume.description.kind = VolumeKind::grey;
  volume.description.geometry = geometry_;
  testing::build_volume(volume, folder_.file("grey.8vo"), 1);
  options_.grey = folder_.file("grey.8vo");
  options_.calibration = {2, 5};
  const MorphometryResult result = morphometry(options_, context_);
  EXPECT_NEAR(result.tissue->mean, 2 * 101 + 5, 1e-9);
  EXPECT_NEAR(result.tissue->deviation, 2, 1e-6);
  EXPECT_NEAR(result.total->mean, (207 * 8 + 25 * 22) / 30.0, 1e-9);
  options_.grey = options_.input;
  EXPECT_EQ(failure_of([&] { morphometry(options_, context_); }).field, "grey.kind");
}

TEST_F(MorphometryTask, KeepsTheDeviationOfLargeDensities) {
  testing::DenseLabels grey(kPlateSize);
  for_each_voxel(kPlateSize, [&](const Index3& p) { grey.at(p) = p.x % 2 == 0 ? 100 : 102; });
  testing::Volume volume = testing::volume_of(grey, 2);
  volume.description.kind = VolumeKind::grey;
  volume.description.geometry = geometry_;
  testing::build_volume(volume, folder_.file("grey.8vo"), 1);
  options_.grey = folder_.file("grey.8vo");
  options_.has_thickness = false;
  options_.calibration = {1, 1e9};
  const MorphometryResult result = morphometry(options_, context_);
  EXPECT_NEAR(result.tissue->deviation, 1, 1e-6);
  EXPECT_NEAR(result.total->deviation, 1, 1e-6);
}

TEST_F(MorphometryTask, MeasuresPoresFromEndToEndOfARegion) {
  // Straight pores of half of the area along x; plates block those along y.
  options_.input = write("plates.8vo", solid([](const Index3& p) { return p.y % 4 < 2; }));
  options_.region = write("box.8vo", solid([](const Index3& p) {
    return p.x >= 10 && p.x < 30 && p.y >= 8 && p.y < 28 && p.z >= 5 && p.z < 25;
  }));
  options_.has_thickness = false;
  options_.has_tortuosity = true;
  options_.has_diffusion = true;
  const MorphometryResult within = morphometry(options_, context_);
  for (const std::size_t axis : {std::size_t{0}, std::size_t{2}}) {
    ASSERT_TRUE(within.paths[axis]);
    EXPECT_NEAR(within.paths[axis]->tortuosity, 1, 1e-6);
    ASSERT_TRUE(within.diffusions[axis]);
    EXPECT_NEAR(within.diffusions[axis]->effective, 0.5, 1e-6);
  }
  EXPECT_FALSE(within.paths[1]);
  EXPECT_TRUE(within.has_ends[1]);
  EXPECT_TRUE(warnings_.empty());
  // Nothing spreads along y.
  for (const MorphometryRow& row : morphometry_rows(within, true)) {
    if (row.key == "effective_diffusivity_y") {
      EXPECT_EQ(row.value, 0.0);
    }
    if (row.key == "diffusive_tortuosity_y") {
      EXPECT_FALSE(row.value);
    }
  }
}

TEST_F(MorphometryTask, MeasuresNoPoresAlongWhichARegionTapers) {
  options_.region = write("cylinder.8vo", solid([](const Index3& p) {
    const double x = static_cast<double>(p.x) - 19.5;
    const double y = static_cast<double>(p.y) - 19.5;
    return x * x + y * y < 15 * 15 && p.z < 10;
  }));
  options_.input = write("bar.8vo", solid([](const Index3& p) { return p.x == 20 && p.y == 20; }));
  options_.has_thickness = false;
  options_.has_tortuosity = true;
  options_.has_diffusion = true;
  const MorphometryResult result = morphometry(options_, context_);
  EXPECT_EQ(result.has_ends, (std::array<bool, 3>{false, false, true}));
  EXPECT_FALSE(result.paths[0]);
  ASSERT_TRUE(result.paths[2]);
  EXPECT_NEAR(result.paths[2]->tortuosity, 1, 1e-6);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("along x, y"), std::string::npos);
  for (const MorphometryRow& row : morphometry_rows(result, true)) {
    if (row.key == "effective_diffusivity_x") {
      EXPECT_FALSE(row.value);
    }
  }
}

TEST_F(MorphometryTask, SaysWhereThereIsNothingToMeasure) {
  options_.input = write("empty.8vo", solid([](const Index3&) { return false; }));
  EXPECT_EQ(failure_of([&] { morphometry(options_, context_); }).kind,
            ErrorKind::invalid_argument);
  options_.input = write("full.8vo", solid([](const Index3&) { return true; }));
  const MorphometryResult full = morphometry(options_, context_);
  EXPECT_EQ(full.share(), 1);
  EXPECT_EQ(full.surface.area_mm2, 0);
  EXPECT_FALSE(full.smi);
  EXPECT_FALSE(full.thickness);
  EXPECT_EQ(warnings_.size(), 1u);
  ASSERT_EQ(full.slices.size(), 30u);
  EXPECT_EQ(full.slices[7].voxels, 40u * 40);
  options_.spacing_map.path = folder_.file("spacing.8vo");
  EXPECT_EQ(failure_of([&] { morphometry(options_, context_); }).kind,
            ErrorKind::invalid_argument);
  options_.spacing_map.path.clear();
  options_.input = write("plain.8vo", solid([](const Index3&) { return true; }), false);
  EXPECT_EQ(failure_of([&] { morphometry(options_, context_); }).kind,
            ErrorKind::invalid_argument);
}

TEST_F(MorphometryTask, RejectsTwoResultsForOneFileBeforeAnyWork) {
  options_.thickness_map.path = folder_.file("map.8vo");
  options_.spacing_map.path = folder_.file("./map.8vo");
  EXPECT_EQ(failure_of([&] { morphometry(options_, context_); }).kind,
            ErrorKind::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(options_.thickness_map.path));
}

}  // namespace
}  // namespace octavo
