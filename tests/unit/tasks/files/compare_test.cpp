#include "octavo/tasks/files/compare.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class Compare : public testing::ScanFiles {};

TEST_F(Compare, AScanEqualsTheFileBuiltFromIt) {
  geometry_.origin_mm = {0, 0, 0};
  const CompareResult result = compare_volumes(
      {write_grey("scan.8vo"), write_raw("scan.raw", voxels_), 0, false, scan_}, context_);
  EXPECT_TRUE(result.comparison.is_equal());
  EXPECT_EQ(result.comparison.voxels, kScanSize.voxel_count());
}

TEST_F(Compare, CountsWhatLiesFurtherApartThanAllowed) {
  const std::string a = write_grey("a.8vo");
  voxels_[1234] = static_cast<std::int16_t>(voxels_[1234] + 5);
  const std::string b = write_grey("b.8vo");
  const Comparison strict = compare_volumes({.a = a, .b = b, .max_error = 4}, context_).comparison;
  EXPECT_EQ(strict.different, 1);
  EXPECT_EQ(strict.max_difference, 5);
  EXPECT_EQ(strict.first, (Index3{1234 % 40, 1234 / 40, 0}));
  EXPECT_TRUE(compare_volumes({.a = a, .b = b, .max_error = 5}, context_).comparison.is_equal());
}

TEST_F(Compare, AToleranceForgivesTheFloatOfASlope) {
  const double slope = 0.1f;
  const std::string a = write_grey("a.8vo", {slope, 1});
  voxels_[1234] = static_cast<std::int16_t>(voxels_[1234] + 5);
  const std::string b = write_grey("b.8vo", {slope, 1});
  const Comparison found = compare_volumes({.a = a, .b = b, .max_error = 0.5}, context_).comparison;
  EXPECT_TRUE(found.is_equal());
  EXPECT_EQ(found.max_difference, 5);
  EXPECT_DOUBLE_EQ(found.max_real_difference, 5 * slope);
  EXPECT_FALSE(
      compare_volumes({.a = a, .b = b, .max_error = 0.49999}, context_).comparison.is_equal());
}

TEST_F(Compare, ReadsNoVoxelWhereFilesStateTheSameDigestUnlessAsked) {
  const std::string a = write_grey("a.8vo");
  const std::string b = write_grey("b.8vo");
  damage(b, brick_offset(b) + 3, 0x41);
  const Comparison stated = compare_volumes({.a = a, .b = b}, context_).comparison;
  EXPECT_TRUE(stated.is_by_digest);
  EXPECT_TRUE(stated.is_equal());
  EXPECT_EQ(stated.voxels, kScanSize.voxel_count());
  EXPECT_EQ(failure_of([&] { compare_volumes({.a = a, .b = b, .voxels = true}, context_); }).kind,
            ErrorKind::corrupt);
  const Comparison read = compare_volumes({.a = a, .b = a, .voxels = true}, context_).comparison;
  EXPECT_FALSE(read.is_by_digest);
  EXPECT_TRUE(read.is_equal());
}

TEST_F(Compare, DigestsTellNothingOfOtherVoxelsOrAnotherRescale) {
  const std::string a = write_grey("a.8vo");
  const Comparison scaled =
      compare_volumes({.a = a, .b = write_grey("s.8vo", {2, 1})}, context_).comparison;
  EXPECT_FALSE(scaled.is_by_digest);
  EXPECT_GT(scaled.different, 0);
  ++voxels_[77];
  const Comparison other = compare_volumes({.a = a, .b = write_grey("b.8vo")}, context_).comparison;
  EXPECT_FALSE(other.is_by_digest);
  EXPECT_EQ(other.different, 1);
}

TEST_F(Compare, OptionsOfScansAreRejectedWhereNeitherIsOne) {
  const std::string a = write_grey("a.8vo");
  const CompareOptions options = {a, a, 0, false, scan_};
  EXPECT_EQ(failure_of([&] { compare_volumes(options, context_); }).field, "scan.raw");
}

TEST_F(Compare, LabelsAreCountedInEachAndInBoth) {
  testing::DenseLabels first({20, 20, 20});
  first.fill({{2, 2, 2}, {6, 6, 6}}, 3);
  testing::DenseLabels second({20, 20, 20});
  second.fill({{2, 2, 4}, {6, 6, 8}}, 3);
  const std::string a = write("a.8vo", first);
  const std::string b = write("b.8vo", second);
  const CompareLabelsResult result = compare_labels({a, b}, context_);
  EXPECT_FALSE(result.is_equal);
  ASSERT_EQ(result.agreements.size(), 1u);
  EXPECT_EQ(result.agreements[0], (LabelAgreement{3, 64, 64, 32}));
  EXPECT_TRUE(compare_labels({a, a}, context_).is_equal);
  EXPECT_EQ(failure_of([&] { compare_labels({a, write_grey("g.8vo")}, context_); }).field,
            "compare.labels");
}

TEST_F(Compare, EitherNamesItsLabels) {
  testing::DenseLabels labels({8, 8, 8});
  labels.fill({{2, 2, 2}, {6, 6, 6}}, 3);
  const CompareLabelsResult result = compare_labels(
      {write_named("a.8vo", labels, {{3, "lung"}}), write_named("b.8vo", labels, {{3, "Lunge"}})},
      context_);
  EXPECT_TRUE(result.is_equal);
  EXPECT_EQ(result.names_a.name_of(3), "lung");
  EXPECT_EQ(result.names_b.name_of(3), "Lunge");
}

}  // namespace
}  // namespace octavo
