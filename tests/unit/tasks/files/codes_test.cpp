#include "octavo/tasks/files/codes.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class Codes : public testing::ScanFiles {
 protected:
  /// Two cubes of label 3 and a voxel of label 9.
  void SetUp() override {
    testing::DenseLabels labels({16, 16, 16});
    labels.fill({{0, 0, 0}, {4, 4, 4}}, 3);
    labels.fill({{8, 8, 8}, {16, 16, 16}}, 3);
    labels.at({5, 0, 0}) = 9;
    labels_ = write("labels.8vo", labels);
  }

  std::string labels_;
};

TEST_F(Codes, LabelsBecomeTheirLargestCubes) {
  const CodesResult result = codes({.input = labels_}, context_);
  EXPECT_EQ(result.octree.root_level, 4);
  EXPECT_EQ(leaf_count(result.octree), 3);
  const auto counts = leaves_by_label(result.octree);
  EXPECT_EQ(counts.at(3), (std::vector<std::int64_t>{0, 0, 1, 1, 0}));
  EXPECT_EQ(voxels_under(counts.at(3)), 64u + 512u);
  EXPECT_EQ(voxels_under(counts.at(9)), 1u);
}

TEST_F(Codes, OnlyTheLabelsThatAreAskedFor) {
  EXPECT_EQ(leaf_volume(codes({.input = labels_, .labels = {{9}}}, context_).octree), 1u);
  EXPECT_EQ(failure_of([&] { codes({.input = labels_, .labels = {{0}}}, context_); }).kind,
            ErrorKind::invalid_argument);
}

TEST_F(Codes, LabelsAreAskedForByTheirNamesAsWell) {
  testing::DenseLabels labels({16, 16, 16});
  labels.fill({{0, 0, 0}, {4, 4, 4}}, 3);
  labels.fill({{8, 8, 8}, {12, 12, 12}}, 5);
  labels.at({5, 0, 0}) = 9;
  const std::string path = write_named("named.8vo", labels, {{3, "lung"}, {5, "lung"}, {9, "7"}});
  const CodesResult lungs = codes({.input = path, .labels = {{}, {"lung"}}}, context_);
  EXPECT_EQ(leaf_volume(lungs.octree), 128u);
  EXPECT_EQ(lungs.volume.metadata.facts().labels.name_of(3), "lung");
  EXPECT_EQ(leaf_volume(codes({.input = path, .labels = {{3}, {"7"}}}, context_).octree),
            65u);
  EXPECT_EQ(failure_of([&] { codes({.input = path, .labels = {{}, {"Lung"}}}, context_); }).field,
            "labels.names");
}

TEST_F(Codes, AMaskOfARangeHasNoNames) {
  testing::DenseLabels labels({16, 16, 16});
  labels.fill({{0, 0, 0}, {4, 4, 4}}, 3);
  const std::string path = write_named("named.8vo", labels, {{1, "heart"}, {3, "lung"}});
  const CodesResult mask = codes({.input = path, .range = AskedRange{3, 3}}, context_);
  EXPECT_EQ(leaf_volume(mask.octree), 64u);
  EXPECT_TRUE(mask.volume.metadata.facts().labels.is_empty());
}

TEST_F(Codes, ARangeMakesAMaskOfGreyValues) {
  CodesOptions options{.input = write_grey("grey.8vo")};
  EXPECT_EQ(failure_of([&] { codes(options, context_); }).field, "codes.range");
  options.range = AskedRange{0, 20};
  const auto inside = std::count_if(voxels_.begin(), voxels_.end(),
                                    [](std::int16_t v) { return v >= 0 && v <= 20; });
  EXPECT_EQ(leaf_volume(codes(options, context_).octree), static_cast<std::uint64_t>(inside));
}

TEST_F(Codes, TheNeighborsOfACube) {
  CodesOptions options{.input = labels_, .neighbors_of = "0000"};
  const CodesResult result = codes(options, context_);
  ASSERT_TRUE(result.surroundings);
  EXPECT_EQ(result.surroundings->cube.level, 0);
  EXPECT_EQ(result.surroundings->filling.kind, NeighborKind::leaf);
  EXPECT_EQ(result.surroundings->filling.leaf.cube.level, 2);
  EXPECT_EQ(code_text(result.surroundings->filling.leaf.cube, 4, CodeNotation::hierarchical), "00");
  options.neighbors_of = "00";
  EXPECT_EQ(failure_of([&] { codes(options, context_); }).kind, ErrorKind::invalid_argument);
}

TEST_F(Codes, WhatTheCallerTakesCountsAgainstTheLimit) {
  context_.max_memory_bytes = 1 << 20;
  CodesOptions options{.input = labels_};
  EXPECT_NO_THROW(codes(options, context_));
  options.bytes_per_leaf = 1 << 20;
  EXPECT_EQ(failure_of([&] { codes(options, context_); }).kind, ErrorKind::limit_exceeded);
}

}  // namespace
}  // namespace octavo
