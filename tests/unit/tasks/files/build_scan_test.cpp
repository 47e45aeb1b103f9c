#include "octavo/tasks/files/build_scan.h"

#include <fstream>

#include "support/scan_files.h"

namespace octavo {
namespace {

class BuildScan : public testing::ScanFiles {
 protected:
  void SetUp() override {
    options_.inputs = {write_raw("scan.raw", voxels_)};
    options_.output.path = folder_.file("out.8vo");
    options_.scan = scan_;
  }

  Failure failure() {
    return failure_of([&] { build_scan(options_, context_); });
  }

  static LabelNames names_in(const std::string& path) {
    return testing::open_file(path)->description().metadata.facts().labels;
  }

  std::string write_text(const std::string& name, const std::string& text) {
    std::ofstream(folder_.file(name)) << text;
    return folder_.file(name);
  }

  BuildScanOptions options_;
};

TEST_F(BuildScan, KeepsEveryVoxel) {
  const BuiltVolume built = build_scan(options_, context_);
  EXPECT_EQ(built.kind, VolumeKind::grey);
  EXPECT_EQ(built.build.raw_bytes, voxels_.size() * 2);
  EXPECT_GT(built.compression_ratio(), 1);
  const testing::DenseLabels read_back = read(options_.output.path);
  EXPECT_TRUE(std::equal(voxels_.begin(), voxels_.end(), read_back.voxels.begin()));
  EXPECT_TRUE(notes_.empty());
}

TEST_F(BuildScan, NeverReplacesAFileThatAHeaderNames) {
  const std::string voxels = write_raw("voxels.8vo", voxels_);
  const Size3& size = scan_.source.raw->size;
  options_.inputs = {write_text(
      "scan.mhd", "ObjectType = Image\nNDims = 3\nDimSize = " + std::to_string(size.x) + " " +
                      std::to_string(size.y) + " " + std::to_string(size.z) +
                      "\nElementSpacing = 1 1 1\nElementType = MET_SHORT\n"
                      "ElementByteOrderMSB = False\nElementDataFile = voxels.8vo\n")};
  options_.scan = {};
  options_.output = {voxels, true};
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument);
  EXPECT_EQ(testing::bytes_of_file(voxels).size(), 2 * voxels_.size());
  options_.output.path = folder_.file("out.8vo");
  EXPECT_EQ(build_scan(options_, context_).build.raw_bytes, voxels_.size() * 2);
}

TEST_F(BuildScan, ANameOfLabelsIsNotedWithItsField) {
  std::vector<std::int16_t> labels(voxels_.size(), 3);
  options_.inputs = {write_raw("brain_mask.raw", labels)};
  EXPECT_EQ(build_scan(options_, context_).kind, VolumeKind::labels);
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_EQ(notes_[0].second, "kind");
}

TEST_F(BuildScan, FloatsThatCoarseLevelsDoNotHoldAreAWarning) {
  std::vector<float> floats(voxels_.begin(), voxels_.end());
  for (std::size_t i = 0; i < floats.size(); ++i) floats[i] += static_cast<float>(i % 97) / 89;
  for (std::size_t i = 0; i < 30; ++i) floats[i * 501] = 1e20f;
  options_.inputs = {write_raw("scan.raw", floats)};
  options_.scan.source.raw->type = VoxelType::float32;
  const BuiltVolume built = build_scan(options_, context_);
  EXPECT_EQ(built.build.clipped.count, 30);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("30 voxels lie beyond what coarse levels hold, the farthest at 1e"),
            std::string::npos)
      << warnings_[0];

  context_.is_strict = true;
  options_.output.path = folder_.file("strict.8vo");
  EXPECT_EQ(failure_of([&] { build_scan(options_, context_); }).field, "is_strict");
  EXPECT_FALSE(local_storage().exists(options_.output.path));
}

TEST_F(BuildScan, TwoValuesAreNotedAsAMaskMayBe) {
  std::vector<std::int16_t> mask(voxels_.size());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = i % 7 == 3 ? 255 : 0;
  options_.inputs = {write_raw("root.raw", mask)};
  EXPECT_EQ(build_scan(options_, context_).kind, VolumeKind::grey);
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_NE(notes_[0].first.find("two values only, 0 and 255"), std::string::npos);
  EXPECT_EQ(notes_[0].second, "two_values");
}

TEST_F(BuildScan, OneOrThreeValuesAreNoMask) {
  for (const std::int16_t last : {std::int16_t{0}, std::int16_t{9}}) {
    std::vector<std::int16_t> values(voxels_.size());
    if (last != 0) values[5] = 255;
    values.back() = last;
    options_.inputs = {write_raw("values.raw", values)};
    options_.output.overwrite = true;
    build_scan(options_, context_);
    EXPECT_TRUE(notes_.empty()) << last;
  }
}

TEST_F(BuildScan, AnAskedKindIsTakenWithoutANote) {
  options_.kind = VolumeKind::labels;
  EXPECT_EQ(build_scan(options_, context_).kind, VolumeKind::labels);
  EXPECT_TRUE(notes_.empty());
}

TEST_F(BuildScan, NamesOfLabelsStandInTheFile) {
  options_.kind = VolumeKind::labels;
  options_.label_names = write_text("names.txt", "1 bone 255 0 0\n2 air 0 0 9\n");
  const BuiltVolume built = build_scan(options_, context_);
  const LabelNames names = names_in(options_.output.path);
  EXPECT_EQ(names.name_of(1), "bone");
  EXPECT_EQ(names.color_of(2, {}), (LabelColor{0, 0, 9}));
  EXPECT_EQ(built.volume.metadata.facts().labels, names);
}

TEST_F(BuildScan, ACopyKeepsNamesTakesOthersAndDropsThemWithTheLabels) {
  options_.kind = VolumeKind::labels;
  options_.label_names = write_text("names.txt", "1 bone\n2 air\n");
  build_scan(options_, context_);
  const auto names_of_copy = [&](VolumeKind kind, const std::string& names) {
    BuildScanOptions copy;
    copy.inputs = {options_.output.path};
    copy.output = {folder_.file("copy.8vo"), true};
    copy.kind = kind;
    copy.label_names = names;
    build_scan(copy, context_);
    return names_in(copy.output.path);
  };
  EXPECT_EQ(names_of_copy(VolumeKind::labels, "").name_of(2), "air");
  const LabelNames others =
      names_of_copy(VolumeKind::labels, write_text("others.txt", "1 skull\n"));
  EXPECT_EQ(others.name_of(1), "skull");
  EXPECT_EQ(others.size(), 1u);
  EXPECT_TRUE(names_of_copy(VolumeKind::grey, "").is_empty());
}

TEST_F(BuildScan, GreyValuesHaveNoNames) {
  options_.label_names = write_text("names.txt", "1 bone\n");
  const Failure failed = failure();
  EXPECT_EQ(failed.kind, ErrorKind::invalid_argument);
  EXPECT_EQ(failed.field, "label_names");
  EXPECT_FALSE(std::filesystem::exists(options_.output.path));
}

TEST_F(BuildScan, ABadListOfNamesIsRejectedBeforeTheScanIsRead) {
  options_.inputs = {folder_.file("nowhere.nii")};
  options_.label_names = write_text("names.txt", "1\n");
  EXPECT_EQ(failure().kind, ErrorKind::source_rejected);
}

TEST_F(BuildScan, AMaxErrorHoldsInRealUnits) {
  options_.max_error = 2;
  EXPECT_EQ(build_scan(options_, context_).max_error_real(), 2);
  const testing::DenseLabels read_back = read(options_.output.path);
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    ASSERT_LE(std::abs(read_back.voxels[i] - voxels_[i]), 2) << i;
  }
}

TEST_F(BuildScan, PlanesInBetweenMakeCubes) {
  options_.between = PlaneInterpolation::linear;
  const BuiltVolume built = build_scan(options_, context_);
  EXPECT_EQ(built.volume.size.z, (kScanSize.z - 1) * 4 + 1);
  EXPECT_EQ(built.volume.geometry.spacing_mm[2], 0.5);
}

TEST_F(BuildScan, CubicPlanesAreNotForLabels) {
  options_.kind = VolumeKind::labels;
  options_.between = PlaneInterpolation::cubic;
  EXPECT_EQ(failure().field, "between");
}

TEST_F(BuildScan, AnExistingFileIsReplacedOnlyWhenAsked) {
  build_scan(options_, context_);
  EXPECT_EQ(failure().field, "output.overwrite");
  options_.output.overwrite = true;
  EXPECT_NO_THROW(build_scan(options_, context_));
}

TEST_F(BuildScan, TheSourceIsNeverTheOutput) {
  options_.inputs = {write_raw("scan.8vo.raw", voxels_)};
  options_.output = {options_.inputs[0], true};
  EXPECT_EQ(failure().field, "output.format");
  std::filesystem::create_hard_link(options_.inputs[0], folder_.file("same.8vo"));
  options_.output.path = folder_.file("same.8vo");
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument);
}

TEST_F(BuildScan, AWarningIsAnErrorWhereTasksAreStrict) {
  options_.scan.source.spacing_mm.reset();
  context_.is_strict = true;
  EXPECT_EQ(failure().field, "is_strict");
  context_.is_strict = false;
  build_scan(options_, context_);
  EXPECT_EQ(warnings_.size(), 1u);
}

}  // namespace
}  // namespace octavo
