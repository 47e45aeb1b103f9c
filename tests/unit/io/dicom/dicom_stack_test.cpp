// DICOM series that are no even stack, and what the options make of them.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "octavo/io/source/prefetch_source.h"
#include "support/dicom_elements.h"
#include "support/dicom_samples.h"
#include "support/sought_planes.h"
#include "support/source_files.h"

namespace octavo::testing {namespace {

using Plane = std::vector<std::int16_t>;

/// 4 x 3 values that grow by 100 per millimeter of height, by 7 per row and 1 per column: linear
/// interpolation anywhere inside gives them again.
std::int16_t value_at(double x, double y, double height_mm) {
  return static_cast<std::int16_t>(std::lround(100 * height_mm + 7 * y + x - 50));
}

Plane plane_at(double height_mm, double y_shift = 0, int rows = 3) {
  Plane plane;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < 4; ++x) plane.push_back(value_at(x, y - y_shift, height_mm));
  return plane;
}

DicomSample slice_at(double height_mm) {
  DicomSample sample;
  sample.position = "-10\\20\\" + std::to_string(height_mm);
  sample.voxels = bytes_of(plane_at(height_mm));
  return sample;
}

void write_slices(const TempFolder& folder, const std::vector<double>& heights_mm) {
  for (std::size_t i = 0; i < heights_mm.size(); ++i) {
    write_dicom(folder.file("s" + std::to_string(i)), slice_at(heights_mm[i]));
  }
}

SourceOptions with_gaps(GapPolicy policy) {
  SourceOptions options;
  options.on_gap = policy;
  return options;
}

nlohmann::json prepared(const PlaneSource& source) {
  const auto metadata = nlohmann::json::parse(source.description().metadata.text());
  return metadata.value("prepared", nlohmann::json());
}

std::string planes_at(const std::vector<double>& heights_mm) {
  std::string all;
  for (const double height : heights_mm) all += bytes_of(plane_at(height));
  return all;
}

TEST(SourceDicomGaps, FillingMakesMissingPlanesAndKeepsTheOthers) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 8, 10});
  const auto source = open_source({folder.path()}, with_gaps(GapPolicy::fill));
  EXPECT_EQ(source->description().size, (Size3{4, 3, 6}));
  EXPECT_DOUBLE_EQ(source->description().geometry.spacing_mm[2], 2);
  EXPECT_EQ(voxels_of(*source), planes_at({0, 2, 4, 6, 8, 10}));
  expect_same_from_anywhere(*source);
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(source->warnings()[0], "2 missing planes interpolated"));
  const nlohmann::json gaps = prepared(*source)["gaps"];
  EXPECT_EQ(gaps["on_gap"], "fill");
  EXPECT_EQ(gaps["made_planes"], nlohmann::json({{2, 3}}));
}

TEST(SourceDicomGaps, FillingRejectsSlicesOnNoEvenGrid) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 5, 7});
  const Error error = source_error({folder.path()}, with_gaps(GapPolicy::fill));
  for (const char* part : {"s1", "s2", "3 mm", "2 mm", "[on_gap=resample]"})
    EXPECT_TRUE(contains(error, part)) << error.what();
}

TEST(SourceDicomGaps, FillingRejectsToInventMoreThanThereIs) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 4, 14});
  EXPECT_EQ(open_source({folder.path()}, with_gaps(GapPolicy::fill))->description().size.z, 8);
  write_slices(folder, {0, 2, 4, 16});
  const Error error = source_error({folder.path()}, with_gaps(GapPolicy::fill));
  EXPECT_TRUE(contains(error, "5 planes would be made from 4 slices")) << error.what();
}

TEST(SourceDicomGaps, ResamplingTakesTheSmallestStepThatIsShared) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 4, 4.5, 7.5, 10.5});
  auto source = open_source({folder.path()}, with_gaps(GapPolicy::resample));
  EXPECT_NEAR(source->description().geometry.spacing_mm[2], 2, 1e-9);
  EXPECT_EQ(voxels_of(*source), planes_at({0, 2, 4, 6, 8, 10}));
  EXPECT_TRUE(contains(source->warnings()[0], "the last 0.5 mm")) << source->warnings()[0];
  EXPECT_EQ(prepared(*source)["gaps"]["made_plane_count"], 3);
  source = make_prefetch_source(open_source({folder.path()}, with_gaps(GapPolicy::resample)), {3});
  EXPECT_EQ(voxels_of(*source), planes_at({0, 2, 4, 6, 8, 10}));
}

TEST(SourceDicomGaps, AnEvenStackIsLeftAloneByEveryOption) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 4});
  SourceOptions options = with_gaps(GapPolicy::resample);
  options.drop_duplicates = true;
  options.untilt = true;
  const auto source = open_source({folder.path()}, options);
  EXPECT_EQ(voxels_of(*source), planes_at({0, 2, 4}));
  EXPECT_TRUE(source->warnings().empty());
  EXPECT_TRUE(prepared(*source).is_null());
}

TEST(SourceDicomGaps, PaddingIsNeverMixedWithMeasurements) {
  const TempFolder folder;
  for (const int height : {0, 2, 6, 8}) {
    DicomSample sample = slice_at(height);
    sample.padding = -2000;
    Plane plane = plane_at(height);
    if (height == 2) plane[0] = -2000;
    sample.voxels = bytes_of(plane);
    write_dicom(folder.file("s" + std::to_string(height)), sample);
  }
  const std::string all =
      voxels_of(*open_source({folder.path()}, with_gaps(GapPolicy::fill)));
  std::int16_t made = 0;
  std::memcpy(&made, all.data() + 2 * 24, sizeof made);
  EXPECT_EQ(made, value_at(0, 0, 6));
  EXPECT_EQ(all.substr(2 * 24 + 2, 22), bytes_of(plane_at(4)).substr(2));
}

TEST(SourceDicomDuplicates, CopiesAreLeftOutWithANoticeWhenAsked) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 2, 4, 4, 4});
  const Error error = source_error({folder.path()});
  EXPECT_TRUE(contains(error, "[drop_duplicates]")) << error.what();
  SourceOptions options;
  options.drop_duplicates = true;
  const auto source = open_source({folder.path()}, options);
  EXPECT_EQ(voxels_of(*source), planes_at({0, 2, 4}));
  EXPECT_TRUE(contains(source->warnings()[0], "3 copies of slices left out"));
  EXPECT_EQ(prepared(*source), nlohmann::json({{"dropped_duplicates", 3}}));
}

TEST(SourceDicomDuplicates, APlaceHasNoNegativeZeros) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 4});
  DicomSample sample = slice_at(0);
  for (const char* name : {"s0", "s1"}) {
    sample.position = "0\\-0.0\\-0.00000001";
    write_dicom(folder.file(name), sample);
  }
  expect_rejected(folder.path(), {"lie at the same position (0, 0, 0 mm)"});
}

TEST(SourceDicomDuplicates, OtherVoxelsAtTheSamePositionAreRejectedWithBothNames) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 2});
  DicomSample other = slice_at(2);
  other.voxels[5] = static_cast<char>(other.voxels[5] + 1);
  write_dicom(folder.file("s2"), other);
  SourceOptions options;
  options.drop_duplicates = true;
  const Error error = source_error({folder.path()}, options);
  for (const char* part : {"s1 and s2", "same position", "voxels differ"})
    EXPECT_TRUE(contains(error, part)) << error.what();
}

TEST(SourceDicomDuplicates, TheSameHeightAtAnotherPlaceIsNoCopy) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 2});
  DicomSample other = slice_at(2);
  other.position = "-4\\20\\2";
  write_dicom(folder.file("s2"), other);
  SourceOptions options;
  options.drop_duplicates = true;
  const Error error = source_error({folder.path()}, options);
  EXPECT_TRUE(contains(error, "6 mm apart sideways")) << error.what();
}

/// Slices 2 mm apart whose first row moves by `rows_per_step` rows of 0.5 mm each time.
void write_tilted(const TempFolder& folder, double rows_per_step,
                  const std::vector<double>& heights_mm) {
  for (std::size_t i = 0; i < heights_mm.size(); ++i) {
    const double shift_rows = rows_per_step * heights_mm[i] / 2;
    DicomSample sample = slice_at(heights_mm[i]);
    sample.position = "-10\\" + std::to_string(20 + shift_rows * 0.5) + "\\" +
                      std::to_string(heights_mm[i]);
    sample.voxels = bytes_of(plane_at(heights_mm[i], -shift_rows));
    write_dicom(folder.file("s" + std::to_string(i)), sample);
  }
}

SourceOptions upright(GapPolicy policy = GapPolicy::error) {
  SourceOptions options;
  options.untilt = true;
  options.on_gap = policy;
  return options;
}

/// Rows first .. last of a plane of 4 columns.
std::string rows_of(const std::string& voxels, int rows, int plane, int first, int last) {
  const auto at = static_cast<std::size_t>((plane * rows + first) * 8);
  return voxels.substr(at, static_cast<std::size_t>((last - first + 1) * 8));
}

TEST(SourceDicomTilt, ATiltOfWholeRowsMovesVoxelsUnchanged) {
  const TempFolder folder;
  write_tilted(folder, 2, {0, 2, 4});
  EXPECT_TRUE(contains(source_error({folder.path()}), "[untilt]"));
  const auto source = open_source({folder.path()}, upright());
  const VolumeDescription& d = source->description();
  EXPECT_EQ(d.size, (Size3{4, 7, 3}));
  EXPECT_EQ(d.geometry.origin_mm, (Point3{-10, 20, 0}));
  EXPECT_EQ(d.geometry.spacing_mm, (Point3{0.25, 0.5, 2}));
  const std::string all = voxels_of(*source);
  const std::string two_rows_of_air = bytes_of(Plane(8, 24));  // -1000 HU at -1024
  for (int z = 0; z < 3; ++z) {
    const std::string slice = bytes_of(plane_at(2 * z, -2 * z));
    EXPECT_EQ(rows_of(all, 7, z, 2 * z, 2 * z + 2), slice) << z;
    for (int below = 0; below < z; ++below)
      EXPECT_EQ(rows_of(all, 7, z, 2 * below, 2 * below + 1), two_rows_of_air) << z;
    for (int above = z; above < 2; ++above)
      EXPECT_EQ(rows_of(all, 7, z, 2 * above + 3, 2 * above + 4), two_rows_of_air) << z;
  }
}

TEST(SourceDicomTilt, ATiltTheOtherWayMovesTheOrigin) {
  const TempFolder folder;
  write_tilted(folder, -2, {0, 2, 4});
  const auto source = open_source({folder.path()}, upright());
  EXPECT_EQ(source->description().size, (Size3{4, 7, 3}));
  EXPECT_NEAR(source->description().geometry.origin_mm[1], 18, 1e-9);
  EXPECT_EQ(rows_of(voxels_of(*source), 7, 2, 0, 2), bytes_of(plane_at(4, 4)));
}

TEST(SourceDicomTilt, VoxelsBetweenRowsAreInterpolatedAndRecorded) {
  const TempFolder folder;
  write_tilted(folder, 0.5, {0, 2, 4});
  const auto source = open_source({folder.path()}, upright());
  EXPECT_EQ(source->description().size, (Size3{4, 4, 3}));
  const std::string all = voxels_of(*source);
  // Rows 1 and 2 of the canvas lie half-way between those of slice 1.
  for (int y = 1; y <= 2; ++y) {
    for (int x = 0; x < 4; ++x) {
      std::int16_t found = 0;
      std::memcpy(&found, all.data() + ((4 + y) * 4 + x) * 2, sizeof found);
      EXPECT_NEAR(found, 100 * 2 + 7 * y + x - 50, 1);
    }
  }
  const nlohmann::json tilt = prepared(*source)["tilt"];
  EXPECT_NEAR(tilt["angle_degrees"].get<double>(),
              std::atan(0.25 / 2) * 180 / std::numbers::pi, 1e-6);
  EXPECT_EQ(tilt["slice_size"], nlohmann::json({4, 3}));
}

TEST(SourceDicomTilt, UnevenTiltedSlicesNeedBothOptions) {
  const TempFolder folder;
  write_tilted(folder, 2, {0, 2, 4, 5, 8, 11});
  const Error both = source_error({folder.path()});
  EXPECT_TRUE(contains(both, "[untilt]")) << both.what();
  EXPECT_TRUE(contains(both, "[on_gap=")) << both.what();
  EXPECT_TRUE(contains(source_error({folder.path()}, upright()), "[on_gap="));
  EXPECT_TRUE(contains(source_error({folder.path()}, with_gaps(GapPolicy::resample)),
                       "[untilt]"));
  const auto source = open_source({folder.path()}, upright(GapPolicy::resample));
  EXPECT_EQ(source->description().size, (Size3{4, 14, 6}));
  expect_same_from_anywhere(*source);
}

TEST(SourceDicomTilt, PlanesBetweenTiltedSlicesAreInterpolatedAlongTheNormal) {
  const TempFolder folder;
  write_tilted(folder, 0.5, {0, 2, 4, 5, 8, 11});
  const auto source = open_source({folder.path()}, upright(GapPolicy::resample));
  ASSERT_EQ(source->description().size, (Size3{4, 6, 6}));
  const std::string all = voxels_of(*source);
  // The plane at 6 mm: its rows 2 and 3 are reached by the slices at 5 and at 8 mm.
  for (int y = 2; y <= 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      std::int16_t found = 0;
      std::memcpy(&found, all.data() + ((3 * 6 + y) * 4 + x) * 2, sizeof found);
      EXPECT_NEAR(found, 100 * 6 + 7 * y + x - 50, 2);
    }
  }
}

TEST(SourceDicomTilt, AJumpOfOneSliceIsNoTilt) {
  const TempFolder folder;
  write_slices(folder, {0, 2, 4, 6});
  DicomSample moved = slice_at(4);
  moved.position = "-9\\20\\4";
  write_dicom(folder.file("s2"), moved);
  const Error error = source_error({folder.path()}, upright());
  EXPECT_TRUE(contains(error, "1 mm sideways")) << error.what();
}

TEST(SourceDicomTilt, MoreThanAnyGantryIsRejected) {
  const TempFolder folder;
  write_tilted(folder, 5, {0, 2, 4});
  const Error error = source_error({folder.path()}, upright());
  EXPECT_TRUE(contains(error, "51.34 degrees")) << error.what();
}

TEST(SourceDicomTilt, PositionsFarAwayMakeNoVolumeWithoutEnd) {
  const TempFolder folder;
  write_tilted(folder, 2, {0, 200});
  EXPECT_TRUE(contains(source_error({folder.path()}, upright()), "times their size"));
  write_slices(folder, {0, 0.1, 0.2, 400});
  const Error error = source_error({folder.path()}, with_gaps(GapPolicy::resample));
  EXPECT_TRUE(contains(error, "4001 planes")) << error.what();
  write_slices(folder, {0, 0.1, 0.2, 1e9});
  EXPECT_TRUE(contains(source_error({folder.path()}), "10 km"));
}

TEST(SourceDicomTilt, APixelSpacingOfZeroIsRejected) {
  const TempFolder folder;
  DicomSample sample = slice_at(0);
  sample.pixel_spacing = "0\\0.5";
  write_dicom(folder.file("a.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.path()}, upright()), "not positive"));
}

/// A segmentation of 5 x 3 voxels: frame f stands at heights_mm[f], and bit i of all frames behind
/// one another is i % 3 == 0.
SegmentationSample segmentation(const std::vector<double>& heights_mm) {
  SegmentationSample sample;
  for (const double height : heights_mm)
    sample.positions.push_back("0\\0\\" + std::to_string(height));
  for (std::size_t i = 0; i < 15 * heights_mm.size(); ++i) sample.voxels.push_back(i % 3 == 0);
  return sample;
}

std::string labels_of(const SegmentationSample& sample, std::size_t frame) {
  std::string labels;
  for (std::size_t i = 15 * frame; i < 15 * (frame + 1); ++i)
    labels += static_cast<char>(sample.voxels[i] ? 1 : 0);
  return labels;
}

TEST(SourceDicomSegmentation, OneBitVoxelsBecomeLabels) {
  const TempFolder folder;
  const SegmentationSample sample = segmentation({4, 2, 0});
  write_segmentation(folder.file("seg.dcm"), sample);
  const auto source = open_source({folder.file("seg.dcm")}, {});
  const VolumeDescription& d = source->description();
  EXPECT_EQ(d.kind, VolumeKind::labels);
  EXPECT_EQ(d.type, VoxelType::uint8);
  EXPECT_EQ(d.size, (Size3{5, 3, 3}));
  EXPECT_DOUBLE_EQ(d.geometry.spacing_mm[2], 2);
  EXPECT_EQ(voxels_of(*source),
            labels_of(sample, 2) + labels_of(sample, 1) + labels_of(sample, 0));
}

TEST(SourceDicomSegmentation, PlanesWithoutAFrameAreEmptyWhenFilled) {
  const TempFolder folder;
  const SegmentationSample sample = segmentation({0, 2, 8});
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("seg.dcm")}), "[on_gap=fill]"));
  for (const GapPolicy policy : {GapPolicy::fill, GapPolicy::resample}) {
    const auto source = open_source({folder.file("seg.dcm")}, with_gaps(policy));
    EXPECT_EQ(voxels_of(*source), labels_of(sample, 0) + labels_of(sample, 1) +
                                      std::string(30, '\0') + labels_of(sample, 2));
    EXPECT_EQ(prepared(*source)["gaps"]["method"], "background");
  }
}

TEST(SourceDicomSegmentation, FramesLeftOutAtEvenDistancesAreEmptyPlanes) {
  const TempFolder folder;
  SegmentationSample sample = segmentation({0, 4, 8});
  sample.spacing = "2";
  write_segmentation(folder.file("seg.dcm"), sample);
  const std::string empty(15, '\0');
  const auto source = open_source({folder.file("seg.dcm")}, {});
  EXPECT_DOUBLE_EQ(source->description().geometry.spacing_mm[2], 2);
  EXPECT_EQ(voxels_of(*source), labels_of(sample, 0) + empty + labels_of(sample, 1) + empty +
                                    labels_of(sample, 2));
  EXPECT_TRUE(contains(source->warnings().front(), "2 missing planes left empty"));
  sample = segmentation({0, 4, 12});
  sample.spacing = "2";
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_EQ(open_source({folder.file("seg.dcm")}, {})->description().size, (Size3{5, 3, 7}));
  // No whole number of steps.
  sample.spacing = "3";
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("seg.dcm")}), "[on_gap=fill]"));
}

/// What rounding makes of one length, and lengths that differ, are no gap between segmented planes:
/// their spacing is one of centers.
TEST(SourceDicomSegmentation, FramesLeftOutBesideAnyThicknessAreEmptyPlanes) {
  const std::string empty(15, '\0');
  for (const char* spacing : {"2.0000001", "1.99999999", "2.001", "2.00000000000014"}) {
    for (const char* thickness : {"2", "1.99", "2.02"}) {
      const TempFolder folder;
      SegmentationSample sample = segmentation({0, 4, 6});
      sample.spacing = spacing;
      sample.thickness = thickness;
      write_segmentation(folder.file("seg.dcm"), sample);
      const auto source = open_source({folder.file("seg.dcm")}, {});
      EXPECT_NEAR(source->description().geometry.spacing_mm[2], 2, 1e-9) << spacing;
      EXPECT_EQ(voxels_of(*source),
                labels_of(sample, 0) + empty + labels_of(sample, 1) + labels_of(sample, 2));
      sample = segmentation({0, 4});
      sample.spacing = spacing;
      sample.thickness = thickness;
      write_segmentation(folder.file("seg.dcm"), sample);
      const auto two = open_source({folder.file("seg.dcm")}, {});
      EXPECT_EQ(two->description().size, (Size3{5, 3, 3})) << spacing << " " << thickness;
    }
  }
}

TEST(SourceDicomSegmentation, ThickGapsWithoutASpacingBringAWarning) {
  const TempFolder folder;
  SegmentationSample sample = segmentation({0, 8});
  sample.thickness = "2";
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_TRUE(contains(open_source({folder.file("seg.dcm")}, {})->warnings().front(),
                       "8 mm apart, 4 times their Slice Thickness"));
  sample.thickness = "8";
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_TRUE(open_source({folder.file("seg.dcm")}, {})->warnings().empty());
}

TEST(SourceDicomSegmentation, ATiltedOneKeepsItsLabels) {
  const TempFolder folder;
  SegmentationSample sample = segmentation({0, 2, 4});
  // 0.4 rows of 0.5 mm per frame: shifts of 0, 0.4 and 0.8 rows.
  sample.positions = {"0\\0\\0", "0\\0.2\\2", "0\\0.4\\4"};
  write_segmentation(folder.file("seg.dcm"), sample);
  const auto source = open_source({folder.file("seg.dcm")}, upright());
  ASSERT_EQ(source->description().size, (Size3{5, 4, 3}));
  const std::string empty_row(5, '\0');
  EXPECT_EQ(voxels_of(*source), labels_of(sample, 0) + empty_row + labels_of(sample, 1) +
                                    empty_row + empty_row + labels_of(sample, 2));
}

TEST(SourceDicomSegmentation, WhatIsNoPlainMaskIsRejected) {
  const TempFolder folder;
  SegmentationSample sample = segmentation({0, 2});
  sample.type = "FRACTIONAL";
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("seg.dcm")}), "FRACTIONAL"));
  sample.type = "BINARY";
  sample.voxels.resize(16);
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("seg.dcm")}), "hold 2 bytes, 4 are"));
}

/// Slices 4 mm apart, each with these lengths and every `number_step`-th instance number.
struct ThinnedSample {
  const char* name;
  std::string thickness;
  std::string spacing;
  int number_step;
  std::string warning;  ///< empty: none
};

TEST(SourceDicomThinned, EvenSlicesOfWhichOthersMayBeMissingBringAWarning) {
  const std::vector<ThinnedSample> rows = {
      {"every second by its spacing", "2", "2", 1, "2 times what their Spacing Between Slices"},
      {"overlapping slices", "5", "1", 1, "4 times what their Spacing Between Slices"},
      {"every second by its number", "2", "", 2, "2 times what their thickness"},
      {"every second, rounded", "2", "2.000000005", 1, "2 times what their Spacing"},
      {"every second, rounded otherwise", "2.003", "1.9999", 1, "2 times what their Spacing"},
      {"complete", "4", "4", 1, ""},
      {"overlapping and complete", "8", "4", 1, ""},
      {"a gap in place of the spacing", "3", "1", 1, ""},
      {"thin slices with gaps, numbered one by one", "2", "", 1, ""},
      {"numbers that skip otherwise", "2", "", 3, ""},
      {"no whole number of times", "2.7", "2.7", 2, ""},
      {"lengths of 0", "0", "0", 2, ""}};
  for (const ThinnedSample& row : rows) {
    const TempFolder folder;
    for (int z = 0; z < 4; ++z) {
      DicomElements slice = ct_elements(3, 2, 8, 4 * z);
      slice.set(0x00180050, "DS", row.thickness);
      if (!row.spacing.empty()) slice.set(0x00180088, "DS", row.spacing);
      slice.set(0x00200013, "IS", std::to_string(1 + z * row.number_step));
      slice.write(folder.file("s" + std::to_string(z)), kExplicitLittle);
    }
    const auto source = open_source({folder.path()}, {});
    EXPECT_EQ(source->description().geometry.spacing_mm[2], 4) << row.name;
    ASSERT_EQ(source->warnings().size(), row.warning.empty() ? 0U : 1U) << row.name;
    if (row.warning.empty()) continue;
    EXPECT_TRUE(contains(source->warnings().front(), row.warning)) << row.name;
  }
}

TEST(SourceDicomThinned, ASingleSliceTakesItsSpacingBeforeItsThickness) {
  const std::string spacing = "its Spacing Between Slices (0018,0088) of 3.3 mm stands for";
  const std::vector<std::tuple<const char*, const char*, double, std::string>> rows = {
      {"3", "3.3", 3.3, spacing},
      {"", "3.3", 3.3, spacing},
      {"3", "", 3, "its thickness of 3 mm stands for"},
      {"3", "0", 3, "its thickness of 3 mm stands for"},
      {"3", "-3.3", 3, "its thickness of 3 mm stands for"},
      {"0", "", 1, "its thickness of 1 mm (assumed) stands for"}};
  for (const auto& [thickness, between, expected_mm, words] : rows) {
    const TempFolder folder;
    DicomElements slice = ct_elements(3, 2, 8);
    slice.set(0x00180050, "DS", thickness);
    slice.set(0x00180088, "DS", between);
    slice.write(folder.file("s"), kExplicitLittle);
    const auto source = open_source({folder.file("s")}, {});
    EXPECT_EQ(source->description().geometry.spacing_mm[2], expected_mm) << thickness;
    ASSERT_EQ(source->warnings().size(), 1U);
    EXPECT_TRUE(contains(source->warnings().front(), words)) << source->warnings().front();
  }
}

TEST(SourceDicomFrames, SeveralWithoutGeometryNeedASpacing) {
  const TempFolder folder;
  DicomSample sample = slice_at(0);
  sample.position.reset();
  sample.frames = 3;
  sample.voxels = planes_at({0, 2, 4});
  write_dicom(folder.file("m.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("m.dcm")}), "[spacing_mm]"));
  SourceOptions options;
  options.spacing_mm = Point3{1, 1, 3};
  const auto source = open_source({folder.file("m.dcm")}, options);
  EXPECT_EQ(voxels_of(*source), planes_at({0, 2, 4}));
  const std::string& metadata = source->description().metadata.text();
  EXPECT_TRUE(contains(metadata, "\"place_known\":false")) << metadata;
  EXPECT_TRUE(contains(metadata, "\"spacing_source\":\"user\"")) << metadata;
}

}  // namespace
}  // namespace octavo::testing
