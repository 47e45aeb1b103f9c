#include "octavo/tasks/measure.h"

#include <algorithm>
#include <map>
#include <random>

#include "octavo/tasks/files/part_result.h"
#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseLabels;
using testing::for_each_voxel;

/// Every number, those of grey voxels as well.
void expect_same(const RegionMeasure& a, const RegionMeasure& b) {
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.voxel_count, b.voxel_count);
  EXPECT_EQ(a.surface_voxel_count, b.surface_voxel_count);
  EXPECT_EQ(a.box, b.box);
  EXPECT_EQ(a.centroid, b.centroid);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.grey->mean, b.grey->mean);
  EXPECT_EQ(a.grey->deviation, b.grey->deviation);
  EXPECT_EQ(a.grey->minimum, b.grey->minimum);
  EXPECT_EQ(a.grey->maximum, b.grey->maximum);
  EXPECT_EQ(a.grey->sum, b.grey->sum);
  EXPECT_EQ(a.grey->percentiles, b.grey->percentiles);
}

constexpr Size3 kMeasureSize = {66, 24, 18};

class Measure : public testing::TaskFiles {
 protected:
  void SetUp() override {
    labels_.fill({{2, 3, 1}, {40, 20, 9}}, 3);
    labels_.fill({{30, 5, 4}, {66, 12, 18}}, 7);
    options_.labels = write("labels.8vo", labels_);
  }

  /// Grey voxels of 12 bits; a real value is slope * voxel + 5.
  std::string write_grey(double slope) {
    testing::Volume volume;
    volume.description.size = kMeasureSize;
    volume.description.type = VoxelType::int16;
    volume.description.geometry = geometry_;
    volume.description.rescale = {slope, 5};
    volume.description.metadata = Metadata::read(R"({"unit":"HU"})");
    std::mt19937 random(13);
    grey_.clear();
    for (std::int64_t i = 0; i < kMeasureSize.voxel_count(); ++i) {
      grey_.push_back(static_cast<std::int16_t>(random() % 4000));
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(grey_.data());
    volume.voxels.assign(bytes, bytes + grey_.size() * sizeof grey_[0]);
    const std::string path = folder_.file(slope > 0 ? "rising.8vo" : "falling.8vo");
    testing::build_volume(volume, path, 1);
    return path;
  }

  DenseLabels labels_{kMeasureSize};
  std::vector<std::int16_t> grey_;
  MeasureOptions options_;
};

TEST_F(Measure, NamesAreThoseOfTheLabels) {
  options_.labels = write_named("named.8vo", labels_, {{3, "lung"}, {8, "heart"}});
  const MeasureResult result = measure(options_, context_);
  EXPECT_EQ(result.regions.size(), 2u);
  EXPECT_EQ(result.names.name_of(3), "lung");
  EXPECT_EQ(result.names.name_of(7), "");
}

TEST_F(Measure, RegionsAreThoseOfTheVoxels) {
  struct Sums {
    std::uint64_t voxels = 0;
    std::uint64_t surface = 0;
    Box box;
    Point3 sum{};
  };
  std::map<std::int64_t, Sums> expected;
  for_each_voxel(kMeasureSize, [&](const Index3& p) {
    const std::int32_t label = labels_.at(p);
    if (label == 0) return;
    Sums& sums = expected[label];
    ++sums.voxels;
    sums.box = united(sums.box, {p, {p.x + 1, p.y + 1, p.z + 1}});
    for (std::size_t a = 0; a < 3; ++a) sums.sum[a] += static_cast<double>(p[static_cast<int>(a)]);
    const auto steps = testing::neighbor_steps(6);
    sums.surface += std::any_of(steps.begin(), steps.end(), [&](const Index3& step) {
      const Index3 q = testing::moved(p, step);
      return !box_of(kMeasureSize).contains(q) || labels_.at(q) != label;
    });
  });
  const MeasureResult result = measure(options_, context_);
  ASSERT_EQ(result.regions.size(), expected.size());
  for (const MeasuredRegion& one : result.regions) {
    const Sums& sums = expected.at(one.region.label);
    const auto voxels = static_cast<double>(sums.voxels);
    EXPECT_EQ(one.region.voxel_count, sums.voxels);
    EXPECT_EQ(one.region.surface_voxel_count, sums.surface);
    EXPECT_EQ(one.region.box, sums.box);
    EXPECT_FALSE(one.region.grey.has_value());
    EXPECT_DOUBLE_EQ(one.in_mm.value().mm3, 0.5 * voxels);
    const Point3 center =
        geometry_.to_world({sums.sum[0] / voxels, sums.sum[1] / voxels, sums.sum[2] / voxels});
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(one.in_mm->centroid[a], center[a], 1e-9);
    EXPECT_FALSE(one.in_mm->integrated.has_value());
  }
}

TEST_F(Measure, GreyValuesAreRealOnesOnARisingAndOnAFallingScale) {
  for (const double slope : {0.5, -2.0}) {
    options_.grey = write_grey(slope);
    options_.percentiles = {90, 10, 50, 10};
    const MeasureResult result = measure(options_, context_);
    EXPECT_EQ(result.unit, "HU");
    EXPECT_EQ(result.percentiles, (std::vector<double>{10, 50, 90}));
    for (const MeasuredRegion& one : result.regions) {
      std::vector<double> values;
      for (std::size_t i = 0; i < grey_.size(); ++i) {
        if (labels_.voxels[i] == one.region.label) values.push_back(slope * grey_[i] + 5);
      }
      std::sort(values.begin(), values.end());
      double sum = 0;
      for (const double value : values) sum += value;
      const GreyStatistics& grey = one.region.grey.value();
      const auto count = static_cast<double>(values.size());
      EXPECT_NEAR(grey.mean, sum / count, 1e-6);
      EXPECT_EQ(grey.minimum, values.front());
      EXPECT_EQ(grey.maximum, values.back());
      EXPECT_NEAR(one.in_mm->integrated.value(), 0.5 * sum, 1e-3);
      ASSERT_EQ(grey.percentiles.size(), 3u);
      for (std::size_t i = 0; i < 3; ++i) {
        // Whichever way a rank is rounded, the value is one of the two beside it.
        const double rank = result.percentiles[i] / 100 * count;
        const auto at = static_cast<std::size_t>(rank);
        EXPECT_GE(grey.percentiles[i], values[at - 1]);
        EXPECT_LE(grey.percentiles[i], values[std::min(at + 1, values.size() - 1)]);
      }
    }
  }
}

TEST_F(Measure, ALabelThatIsAskedForIsMeasuredAsAmongAll) {
  options_.labels = write_named("named.8vo", labels_, {{3, "lung"}, {7, "heart"}, {9, "spleen"}});
  options_.grey = write_grey(0.5);
  const MeasureResult all = measure(options_, context_);
  ASSERT_EQ(all.regions.size(), 2u);
  const auto expect_row = [&](const AskedLabels& asked, std::size_t row) {
    options_.asked = asked;
    const MeasureResult one = measure(options_, context_);
    ASSERT_EQ(one.regions.size(), 1u);
    expect_same(one.regions[0].region, all.regions[row].region);
  };
  expect_row({{3}, {}}, 0);
  expect_row({{}, {"heart"}}, 1);
  EXPECT_TRUE(warnings_.empty());
  expect_row({{3, 3, -5}, {"lung", "spleen"}}, 0);
  ASSERT_EQ(warnings_.size(), 2u);
  EXPECT_NE(warnings_[0].find("no voxel has label -5"), std::string::npos);
  EXPECT_NE(warnings_[1].find("no voxel has label 9 (spleen)"), std::string::npos);
  options_.asked = {{0}, {}};
  EXPECT_EQ(failure_of([&] { measure(options_, context_); }).field, "labels.numbers");
  options_.asked = {{}, {"Lung"}};
  EXPECT_EQ(failure_of([&] { measure(options_, context_); }).field, "labels.names");
}

TEST_F(Measure, NothingIsInMmWhereTheSpacingIsNotKnown) {
  options_.labels = write("unknown.8vo", labels_, false);
  for (const MeasuredRegion& one : measure(options_, context_).regions) {
    EXPECT_FALSE(one.in_mm.has_value());
  }
  EXPECT_EQ(warnings_.size(), 1u);
}

TEST_F(Measure, FilesOfTheWrongKindAreRejected) {
  const std::string grey = write_grey(1);
  options_.grey = options_.labels;
  EXPECT_EQ(failure_of([&] { measure(options_, context_); }).field, "grey.kind");
  options_ = {grey, {}, {}};
  EXPECT_EQ(failure_of([&] { measure(options_, context_); }).field, "labels.kind");
  options_ = {grey, grey, {}};
  EXPECT_EQ(failure_of([&] { measure(options_, context_); }).field, "labels.kind");
  options_ = {write("again.8vo", labels_), grey, {101}};
  EXPECT_EQ(failure_of([&] { measure(options_, context_); }).kind, ErrorKind::invalid_argument);
  geometry_.origin_mm[2] += 1;
  options_ = {write("moved.8vo", labels_), grey, {50}};
  EXPECT_EQ(failure_of([&] { measure(options_, context_); }).field, "grid");
}

TEST_F(Measure, FilesInEachOthersPlaceAreNamed) {
  const std::string labels = options_.labels;
  options_ = {write_grey(1), labels, {}};
  const Failure failure = failure_of([&] { measure(options_, context_); });
  EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
  EXPECT_NE(failure.detail.find(labels + " holds labels: they stand in each other's place"),
            std::string::npos)
      << failure.detail;
}

/// Files of parts in any order; a slope that falls, so that percentiles count from the top.
TEST_F(Measure, PartsJoinToEveryDigit) {
  options_.grey = write_grey(-0.5);
  const auto found_by = [&](std::int64_t count, const MeasureOptions& options) {
    std::vector<std::string> paths;
    for (std::int64_t number = count; number-- > 0;) {
      paths.push_back(folder_.file("sums-" + std::to_string(number)));
      measure_volume_part({options, {number, count}, {paths.back(), true}}, context_);
    }
    return paths;
  };
  const MeasureResult whole = measure(options_, context_);
  ASSERT_EQ(whole.regions.size(), 2u);
  for (const std::int64_t count : {1, 2, 5}) {
    const MeasureResult joined = join_measured({options_, found_by(count, options_)}, context_);
    EXPECT_EQ(joined.percentiles, whole.percentiles);
    EXPECT_EQ(joined.unit, whole.unit);
    ASSERT_EQ(joined.regions.size(), whole.regions.size());
    for (std::size_t i = 0; i < whole.regions.size(); ++i) {
      expect_same(joined.regions[i].region, whole.regions[i].region);
    }
  }

  // Of other questions, or not all of one
  const std::vector<std::string> found = found_by(2, options_);
  MeasureOptions other = options_;
  other.percentiles = {50};
  for (const JoinMeasuredOptions& join :
       {JoinMeasuredOptions{other, found}, JoinMeasuredOptions{options_, {found[0]}},
        JoinMeasuredOptions{options_, {found[0], found[1], found[1]}}}) {
    EXPECT_EQ(failure_of([&] { join_measured(join, context_); }).kind,
              ErrorKind::invalid_argument);
  }

  // Of sums that are none
  FoundPart part = read_part_result(found[1], "measure", context_);
  part.lines.at(1).set("counts", std::vector<std::int64_t>{});
  write_part_result({found[1], true}, "measure", part.part, part.lines);
  try {
    join_measured({options_, found}, context_);
    ADD_FAILURE() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
    EXPECT_EQ(error.path(), found[1]) << error.what();
  }
}

}  // namespace
}  // namespace octavo
