#include "octavo/tasks/components.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseLabels;
using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kComponentsSize = {68, 30, 27};

class ComponentsTask : public testing::TaskFiles {
 protected:
  void SetUp() override {
    std::mt19937 random(11);
    mask_ = DenseMask{kComponentsSize, std::vector<std::uint8_t>(
                                 static_cast<std::size_t>(kComponentsSize.voxel_count()))};
    for (std::uint8_t& voxel : mask_.voxels) voxel = random() % 8 == 0 ? 1 : 0;
    options_.input = write("mask.8vo", mask_);
  }

  /// Voxels of the components, the largest first.
  std::vector<std::uint64_t> expected_counts(int connectivity) const {
    const DenseLabels parts = testing::flooded(mask_, connectivity);
    std::map<std::int32_t, std::uint64_t> counts;
    for (std::size_t i = 0; i < parts.voxels.size(); ++i) {
      if (mask_.voxels[i] != 0) ++counts[parts.voxels[i]];
    }
    std::vector<std::uint64_t> sorted;
    for (const auto& [part, count] : counts) sorted.push_back(count);
    std::sort(sorted.rbegin(), sorted.rend());
    return sorted;
  }

  DenseMask mask_;
  ComponentsOptions options_;
};

TEST_F(ComponentsTask, RowsAreThePartsThatAFloodFinds) {
  for (const int connectivity : {6, 18, 26}) {
    options_.connectivity = static_cast<Connectivity>(connectivity);
    const ComponentsResult result = components(options_, context_);
    std::vector<std::uint64_t> counts;
    for (const ComponentRow& row : result.rows) {
      counts.push_back(row.voxels);
      EXPECT_EQ(row.label, static_cast<std::int64_t>(counts.size()));
      EXPECT_DOUBLE_EQ(row.mm3.value(), 0.5 * static_cast<double>(row.voxels));
    }
    EXPECT_EQ(counts, expected_counts(connectivity));
    EXPECT_EQ(result.found, counts.size());
    EXPECT_EQ(result.kept, counts.size());
  }
}

TEST_F(ComponentsTask, TheLabelMapHoldsWhatTheRowsSay) {
  options_.connectivity = Connectivity::edges;
  options_.output = {folder_.file("labels.8vo")};
  options_.keep_largest = 20;
  const ComponentsResult result = components(options_, context_);
  ASSERT_EQ(result.rows.size(), 20u);
  EXPECT_GT(result.found, 20u);

  const DenseLabels labels = read(options_.output->path);
  std::vector<Box> boxes(21);
  std::vector<Point3> sums(21, Point3{});
  std::vector<std::uint64_t> counts(21);
  for_each_voxel(kComponentsSize, [&](const Index3& p) {
    const auto label = static_cast<std::size_t>(labels.at(p));
    ASSERT_LE(label, 20u);
    boxes[label] = united(boxes[label], {p, {p.x + 1, p.y + 1, p.z + 1}});
    ++counts[label];
    for (int axis = 0; axis < 3; ++axis) {
      sums[label][static_cast<std::size_t>(axis)] += static_cast<double>(p[axis]);
    }
  });
  for (const ComponentRow& row : result.rows) {
    const auto label = static_cast<std::size_t>(row.label);
    EXPECT_EQ(counts[label], row.voxels);
    EXPECT_EQ(boxes[label], row.box);
    const Point3 center = geometry_.to_world(row.centroid);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(row.centroid[a], sums[label][a] / static_cast<double>(row.voxels), 1e-9);
      EXPECT_DOUBLE_EQ(row.centroid_mm.value()[a], center[a]);
    }
  }
}

TEST_F(ComponentsTask, SmallOnesAreNotKept) {
  const std::vector<std::uint64_t> counts = expected_counts(6);
  options_.min_mm3 = 1.5;  // three voxels
  const ComponentsResult result = components(options_, context_);
  EXPECT_EQ(result.kept, static_cast<std::size_t>(std::count_if(
                             counts.begin(), counts.end(), [](auto n) { return n >= 3; })));
  EXPECT_EQ(result.found, counts.size());
}

TEST_F(ComponentsTask, ASizeOfWholeVoxelsIsKeptWhateverTheSpacingIsRoundedTo) {
  DenseMask mask{{9, 4, 3}, std::vector<std::uint8_t>(108)};
  for (const std::size_t voxel : {std::size_t{0}, std::size_t{2}, std::size_t{3}}) {
    mask.voxels[voxel] = 1;
  }
  const double almost_one = 1 - 1e-16;
  int files = 0;
  for (const auto& [spacing, of_one] :
       {std::pair(static_cast<double>(0.7F), 0.343), std::pair(static_cast<double>(0.1F), 0.001),
        std::pair(almost_one, 1.0), std::pair(std::sqrt(3.0) * std::sqrt(1 / 3.0), 1.0)}) {
    geometry_.spacing_mm = {spacing, spacing, spacing};
    options_.input = write("rounded" + std::to_string(++files) + ".8vo", mask);
    options_.min_mm3 = of_one;
    EXPECT_EQ(components(options_, context_).kept, 2U) << spacing;
    options_.min_mm3 = 2 * of_one;
    EXPECT_EQ(components(options_, context_).kept, 1U) << spacing;
    options_.min_mm3 = 2.001 * of_one;
    EXPECT_EQ(components(options_, context_).kept, 0U) << spacing;
  }
}

TEST_F(ComponentsTask, RowsAreAsManyAsAskedForAndCountAgainstTheLimit) {
  options_.max_rows = 5;
  EXPECT_EQ(components(options_, context_).rows.size(), 5u);
  context_.max_memory_bytes = std::uint64_t{64} << 20;
  EXPECT_EQ(components(options_, context_).rows.size(), 5u);
  options_.bytes_per_row = std::uint64_t{16} << 20;
  EXPECT_EQ(failure_of([&] { components(options_, context_); }).kind, ErrorKind::limit_exceeded);
}

TEST_F(ComponentsTask, NothingIsInMmWhereTheSpacingIsNotKnown) {
  options_.input = write("unknown.8vo", mask_, false);
  const ComponentsResult result = components(options_, context_);
  EXPECT_FALSE(result.rows.front().mm3.has_value());
  EXPECT_FALSE(result.rows.front().centroid_mm.has_value());
  options_.min_mm3 = 1;
  EXPECT_EQ(failure_of([&] { components(options_, context_); }).field, "input.spacing_mm");
}

}  // namespace
}  // namespace octavo
