#include "octavo/tasks/surface.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <vector>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

constexpr Size3 kSurfaceSize = {40, 30, 20};

/// Two bodies of 1000 HU in air: one of 8^3 voxels, one of 4^3.
class Surface : public ::testing::Test {
 protected:
  void SetUp() override {
    scan_ = built("scan.8vo", VolumeKind::grey);
    labels_ = built("labels.8vo", VolumeKind::labels);
    options_.input = scan_;
    options_.isovalue = 500;
    options_.output.path = folder_.file("m.stl");
    context_.on_warning = [this](const Warning& warning) { warnings_.push_back(warning.text); };
  }

  std::string built(const std::string& name, VolumeKind kind) const {
    testing::Volume volume;
    volume.description.kind = kind;
    volume.description.size = kSurfaceSize;
    volume.description.type = VoxelType::int16;
    volume.description.geometry.spacing_mm = {0.5, 0.5, 1};
    if (kind == VolumeKind::grey) volume.description.rescale = {2, -1000};
    volume.description.metadata = Metadata::read(
        kind == VolumeKind::grey ? R"({"spacing_known":true,"unit":"HU"})"
                                 : R"({"spacing_known":true})");
    std::vector<std::int16_t> voxels(static_cast<std::size_t>(kSurfaceSize.voxel_count()));
    const std::int16_t in_large = kind == VolumeKind::grey ? 1000 : 2;
    const std::int16_t in_small = kind == VolumeKind::grey ? 1000 : 7;
    for (std::int64_t z = 0; z < kSurfaceSize.z; ++z) {
      for (std::int64_t y = 0; y < kSurfaceSize.y; ++y) {
        for (std::int64_t x = 0; x < kSurfaceSize.x; ++x) {
          const auto in = [&](std::int64_t from, std::int64_t end) {
            return x >= from && x < end && y >= from && y < end && z >= from && z < end;
          };
          const std::int16_t value =
              in(2, 10) ? in_large : in(13, 17) ? in_small : std::int16_t{0};
          voxels[static_cast<std::size_t>((z * kSurfaceSize.y + y) * kSurfaceSize.x + x)] = value;
        }
      }
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
    volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(std::int16_t));
    testing::build_volume(volume, folder_.file(name), 1);
    return folder_.file(name);
  }

  /// The error of the task, after which nothing may stand at the name of the output.
  std::string rejected(const char* field) {
    try {
      surface(options_, context_);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
      EXPECT_EQ(error.field(), field);
      EXPECT_FALSE(std::filesystem::exists(options_.output.path));
      return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
  }

  testing::ScratchFolder folder_;
  std::string scan_;
  std::string labels_;
  std::vector<std::string> warnings_;
  SurfaceOptions options_;
  TaskContext context_;
};

TEST_F(Surface, OfGreyValuesIsClosedAndWritten) {
  const SurfaceResult result = surface(options_, context_);
  EXPECT_TRUE(result.is_written);
  EXPECT_TRUE(result.check.is_closed());
  EXPECT_TRUE(result.check.is_manifold());
  EXPECT_EQ(result.check.components, 2u);
  EXPECT_EQ(result.check.euler_number, 4);
  EXPECT_EQ(result.file_bytes, 84 + 50 * result.triangle_count);
  EXPECT_EQ(std::filesystem::file_size(options_.output.path), result.file_bytes);
  // 749.5 of 0 .. 1000 lies a quarter of a step outside the last voxels: 7.5^3 and 3.5^3 voxels,
  // without edges and corners.
  EXPECT_NEAR(result.measures.volume_mm3, 0.25 * (7.5 * 7.5 * 7.5 + 3.5 * 3.5 * 3.5), 2);
}

TEST_F(Surface, AtASeedIsOnePiece) {
  options_.seed = Point3{13, 15, 15};
  const SurfaceResult result = surface(options_, context_);
  EXPECT_EQ(result.check.components, 1u);
  EXPECT_LT(result.measures.volume_mm3, 16);
  options_.output.overwrite = true;
  options_.seed = Point3{30, 25, 15};
  options_.output.path = folder_.file("n.stl");
  EXPECT_NE(rejected("seed").find("no surface passes within a voxel"), std::string::npos);
  options_.seed = Point3{13, 15, 20};
  EXPECT_NE(rejected("seed").find("outside"), std::string::npos);
}

TEST_F(Surface, OfLabelsTakesThoseAskedFor) {
  options_.input = labels_;
  options_.isovalue.reset();
  options_.output.path = folder_.file("all.ply");
  EXPECT_EQ(surface(options_, context_).check.components, 2u);
  options_.labels = {{7}, {}};
  options_.output.path = folder_.file("one.obj");
  const SurfaceResult one = surface(options_, context_);
  EXPECT_EQ(one.check.components, 1u);
  EXPECT_NEAR(one.measures.volume_mm3, 0.25 * 64, 3);
}

TEST_F(Surface, OfACoarserLevelHasFewerTriangles) {
  const SurfaceResult fine = surface(options_, context_);
  options_.output.path = folder_.file("coarse.stl");
  options_.level = 1;
  const SurfaceResult coarse = surface(options_, context_);
  EXPECT_TRUE(coarse.check.is_closed());
  EXPECT_LT(2 * coarse.triangle_count, fine.triangle_count);
}

TEST_F(Surface, WithADeviationHasFewerTrianglesOfTheSameShape) {
  const SurfaceResult full = surface(options_, context_);
  EXPECT_EQ(full.full_triangle_count, full.triangle_count);
  EXPECT_EQ(full.crossing_triangles, std::nullopt);
  options_.output.overwrite = true;
  options_.max_deviation = {0.5, true};
  const SurfaceResult light = surface(options_, context_);
  EXPECT_TRUE(light.is_written);
  EXPECT_EQ(light.crossing_triangles, 0u);
  EXPECT_DOUBLE_EQ(light.max_deviation_mm, 0.25);
  EXPECT_EQ(light.full_triangle_count, full.triangle_count);
  EXPECT_LT(4 * light.triangle_count, full.triangle_count);
  EXPECT_EQ(light.check.components, 2u);
  EXPECT_NEAR(light.measures.volume_mm3, full.measures.volume_mm3,
              0.05 * full.measures.volume_mm3);
  options_.max_deviation = {-1, false};
  EXPECT_THROW(surface(options_, context_), Error);
}

TEST_F(Surface, OfAVolumeThatIsAllInsideIsAClosedBox) {
  const Size3& size = kSurfaceSize;
  const double whole = 0.25 * static_cast<double>(size.voxel_count());
  const double middles =
      0.25 * static_cast<double>((size.x - 1) * (size.y - 1) * (size.z - 1));
  options_.isovalue = -1000;
  const SurfaceResult grey = surface(options_, context_);
  testing::Volume full;
  full.description.kind = VolumeKind::labels;
  full.description.size = size;
  full.description.type = VoxelType::uint8;
  full.description.geometry.spacing_mm = {0.5, 0.5, 1};
  full.description.metadata = Metadata::read(R"({"spacing_known":true})");
  full.voxels.assign(static_cast<std::size_t>(size.voxel_count()), std::byte{3});
  testing::build_volume(full, folder_.file("full.8vo"), 1);
  options_.input = folder_.file("full.8vo");
  options_.isovalue.reset();
  options_.output.path = folder_.file("labels.stl");
  const SurfaceResult labels = surface(options_, context_);
  for (const SurfaceResult* box : {&grey, &labels}) {
    EXPECT_TRUE(box->is_written);
    EXPECT_TRUE(box->check.is_closed());
    EXPECT_EQ(box->check.components, 1u);
    EXPECT_EQ(box->check.euler_number, 2);
    EXPECT_GE(box->measures.volume_mm3, 0.98 * middles);
    EXPECT_LE(box->measures.volume_mm3, whole);
  }
}

TEST_F(Surface, WithoutInsideIsRejectedWithTheRange) {
  options_.isovalue = 1001;
  EXPECT_NE(rejected("isovalue.range").find("no voxel has 1001 HU or more; its values run from "
                                            "-1000 HU to 1000 HU"),
            std::string::npos);
  options_.isovalue = 1000.0001;
  EXPECT_NE(rejected("isovalue.range").find("no voxel has 1000.0001 HU or more; its values run "
                                            "from -1000 HU to 1000 HU"),
            std::string::npos);
  // Means of a coarse level may stay below what single voxels reach.
  options_.isovalue = 999;
  options_.level = 4;
  EXPECT_NE(rejected("").find("no voxel of level 4"), std::string::npos);
}

TEST_F(Surface, RejectsAReportThatIsTheSurfaceUnderAnotherName) {
  options_.report_path = options_.output.path;
  options_.output.path = std::filesystem::relative(options_.report_path).string();
  EXPECT_NE(rejected("").find("is the surface itself"), std::string::npos);
}

TEST_F(Surface, RejectsOptionsThatDoNotGoTogether) {
  options_.isovalue.reset();
  rejected("isovalue.missing");
  options_.labels = {{7}, {}};
  rejected("labels.kind");
  options_.input = labels_;
  options_.isovalue = 3;
  rejected("isovalue");
  options_.isovalue.reset();
  options_.labels = {{9}, {}};
  rejected("");
  options_.labels = {};
  options_.output.path = folder_.file("m.off");
  rejected("surface.output");
}

TEST_F(Surface, AnExistingFileIsReplacedOnlyWhenAsked) {
  surface(options_, context_);
  EXPECT_THROW(surface(options_, context_), Error);
  options_.output.overwrite = true;
  EXPECT_NO_THROW(surface(options_, context_));
}

// More triangles than are in memory at a time: they are fewer already when all are extracted.
TEST_F(Surface, OfManyTrianglesIsReducedWhileItIsExtracted) {
  testing::Volume volume;
  const Size3 size = {66, 66, 80};
  volume.description.kind = VolumeKind::labels;
  volume.description.size = size;
  volume.description.type = VoxelType::uint8;
  volume.description.metadata = Metadata::read(R"({"spacing_known":true})");
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        volume.voxels.push_back(std::byte{(x + z / 70) % 2 == 1 && y % 2 == 1});
      }
    }
  }
  testing::build_volume(volume, folder_.file("columns.8vo"), 1);
  options_.input = folder_.file("columns.8vo");
  options_.isovalue.reset();
  options_.output.path = folder_.file("m.glb");
  options_.max_deviation = {0.7, true};
  const SurfaceResult near = surface(options_, context_);
  EXPECT_TRUE(near.is_written);
  EXPECT_GT(near.full_triangle_count, 600'000u);
  EXPECT_LT(near.triangle_count, near.full_triangle_count / 5);
  EXPECT_DOUBLE_EQ(near.max_deviation_mm, 0.7);
}

TEST_F(Surface, IsTheSameForAnyNumberOfThreads) {
  context_.threads = 1;
  surface(options_, context_);
  const std::string bytes = testing::bytes_of_file(options_.output.path);
  options_.output.overwrite = true;
  context_.threads = 5;
  surface(options_, context_);
  EXPECT_EQ(testing::bytes_of_file(options_.output.path), bytes);
}

}  // namespace
}  // namespace octavo
