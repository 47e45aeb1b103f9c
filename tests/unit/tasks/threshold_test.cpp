#include "octavo/tasks/threshold.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

constexpr Size3 kThresholdSize = {70, 65, 40};

class Threshold : public ::testing::Test {
 protected:
  void SetUp() override {
    testing::Volume volume;
    volume.description.size = kThresholdSize;
    volume.description.type = VoxelType::int16;
    volume.description.rescale = {2, -1000};
    volume.description.metadata = Metadata::read(R"({"spacing_known":true,"unit":"HU"})");
    std::mt19937 random(7);
    for (std::int64_t i = 0; i < kThresholdSize.voxel_count(); ++i) {
      voxels_.push_back(static_cast<std::int16_t>(random() % 1000));
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels_.data());
    volume.voxels.assign(bytes, bytes + voxels_.size() * sizeof(std::int16_t));
    testing::build_volume(volume, scan_, 1);
    options_.input = scan_;
    options_.output.path = mask_;
    context_.on_warning = [this](const Warning& warning) { warnings_.push_back(warning.text); };
  }

  /// Voxels of the result that are not what `label_of` makes of their real value.
  template <class F>
  std::size_t wrong_voxels(F&& label_of) const {
    const auto reader = testing::open_file(mask_);
    const std::vector<std::byte> labels = testing::read_box(*reader, box_of(kThresholdSize), 0);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (static_cast<int>(labels[i]) != label_of(2.0 * voxels_[i] - 1000)) ++wrong;
    }
    return wrong;
  }

  testing::ScratchFolder folder_;
  std::string scan_ = folder_.file("scan.8vo");
  std::string mask_ = folder_.file("mask.8vo");
  std::vector<std::int16_t> voxels_;
  std::vector<Warning> warnings_;
  ThresholdOptions options_;
  TaskContext context_;
};

TEST_F(Threshold, RangesAndTissuesOfOneMaskAddUp) {
  options_.ranges = {{-100, 0}, {500, 600}};
  options_.tissues = {"lung"};
  const ThresholdResult result = threshold(options_, context_);
  const auto expected = [](double hu) {
    return (hu >= -100 && hu <= 0) || (hu >= 500 && hu <= 600) || (hu >= -900 && hu <= -500);
  };
  EXPECT_EQ(wrong_voxels(expected), 0u);
  ASSERT_EQ(result.objects.size(), 1u);
  std::uint64_t count = 0;
  for (const std::int16_t voxel : voxels_) count += expected(2.0 * voxel - 1000) ? 1u : 0u;
  EXPECT_EQ(result.objects.front().voxels, count);
}

TEST_F(Threshold, TheClassNamedFirstCounts) {
  options_.classes = {{3, {0, 400}}, {1, {300, 800}}};
  const ThresholdResult result = threshold(options_, context_);
  const auto expected = [](double hu) {
    return hu >= 0 && hu <= 400 ? 3 : hu >= 300 && hu <= 800 ? 1 : 0;
  };
  EXPECT_EQ(wrong_voxels(expected), 0u);
  ASSERT_EQ(result.objects.size(), 2u);
  EXPECT_EQ(result.objects[0].label, 1);
  EXPECT_EQ(result.objects[1].label, 3);
}

TEST_F(Threshold, LabelsAddUpWithRangesOfALabelMap) {
  options_.classes = {{3, {0, 100}}, {5, {101, 200}}, {6, {201, 300}}};
  threshold(options_, context_);
  ThresholdOptions again;
  again.input = mask_;
  again.output = {folder_.file("again.8vo"), false};
  again.labels = {{3}, {}};
  again.ranges = {{6, 9}};
  mask_ = again.output.path;
  threshold(again, context_);
  EXPECT_EQ(wrong_voxels([](double hu) {
              return (hu >= 0 && hu <= 100) || (hu >= 201 && hu <= 300);
            }),
            0u);
}

TEST_F(Threshold, AnEmptyMaskIsWrittenWithAWarning) {
  options_.ranges = {{5000, 6000}};
  EXPECT_EQ(threshold(options_, context_).objects.front().voxels, 0u);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_EQ(wrong_voxels([](double) { return 0; }), 0u);
}

TEST_F(Threshold, ALabelThatNoVoxelHasIsNamedAsOne) {
  options_.classes = {{3, {0, 100}}};
  threshold(options_, context_);
  ThresholdOptions again;
  again.input = mask_;
  again.output = {folder_.file("again.8vo"), false};
  again.labels = {{77}, {}};
  EXPECT_EQ(threshold(again, context_).objects.front().voxels, 0u);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].text.find("no voxel has such a label"), std::string::npos);
}

TEST_F(Threshold, AnExistingFileIsReplacedOnlyWhenAsked) {
  options_.ranges = {{0, 100}};
  threshold(options_, context_);
  EXPECT_THROW(threshold(options_, context_), Error);
  options_.output.overwrite = true;
  EXPECT_NO_THROW(threshold(options_, context_));
}

TEST_F(Threshold, BadOptionsAreInvalidArguments) {
  const auto kind_of = [&] {
    try {
      threshold(options_, context_);
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::internal;
  };
  EXPECT_EQ(kind_of(), ErrorKind::invalid_argument) << "no range";
  options_.classes = {{256, {0, 1}}};
  EXPECT_EQ(kind_of(), ErrorKind::invalid_argument) << "label";
  options_.classes.clear();
  options_.labels = {{3}, {}};
  EXPECT_EQ(kind_of(), ErrorKind::invalid_argument) << "labels of grey values";
  options_.labels = {};
  options_.tissues = {"wood"};
  EXPECT_EQ(kind_of(), ErrorKind::invalid_argument) << "tissue";
  options_.tissues = {"bone"};
  options_.output.path = folder_.file("mask.nii");
  EXPECT_EQ(kind_of(), ErrorKind::invalid_argument) << "name";
}

}  // namespace
}  // namespace octavo
