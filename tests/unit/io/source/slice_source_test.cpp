// Planes of a few files of a stack are those of the stack, and no other file is opened.
#include "octavo/io/source/slice_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "octavo/io/open_source.h"
#include "octavo/planes/between/isotropic_source.h"
#include "support/dicom_samples.h"
#include "support/image_samples.h"
#include "support/sought_planes.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

namespace fs = std::filesystem;

std::string numbers(int start, int count) {
  std::vector<std::int16_t> values;
  for (int i = 0; i < count; ++i) values.push_back(static_cast<std::int16_t>(start + i * i));
  return bytes_of(values);
}

/// Slices of 4 x 3 voxels, each moved `rows_per_mm` rows against the one below.
void write_series(const TempFolder& folder, const std::vector<double>& heights_mm,
                  double rows_per_mm = 0, std::optional<std::int16_t> padding = {}) {
  for (std::size_t i = 0; i < heights_mm.size(); ++i) {
    DicomSample sample;
    sample.position = "0\\" + std::to_string(heights_mm[i] * rows_per_mm * 0.5) + "\\" +
                      std::to_string(heights_mm[i]);
    sample.voxels = numbers(static_cast<int>(i) * 1000, 12);
    sample.padding = padding;
    write_dicom(folder.file("s" + std::to_string(i) + ".dcm"), sample);
  }
}

/// Opens slices as open_source does and notes which.
struct NotingOpener {
  std::shared_ptr<std::set<std::string>> opened = std::make_shared<std::set<std::string>>();

  std::unique_ptr<PlaneSource> operator()(const std::vector<std::string>& paths,
                                          const SourceOptions& options) const {
    opened->insert(paths.begin(), paths.end());
    return open_source(paths, options);
  }
};

std::set<std::string> files_of_run(const PlaneFiles& files, std::int64_t first, std::int64_t end) {
  const FileRange range = files_of_planes(files, first, end);
  return {files.paths.begin() + range.first, files.paths.begin() + range.end};
}

/// Compares every run of planes with those of the whole stack, and the files opened for it with
/// those that its planes are made of.
void expect_own_slices(const std::vector<std::string>& paths, const SourceOptions& options) {
  const auto whole = open_source(paths, options);
  const auto stack = slice_stack_of(*whole);
  ASSERT_TRUE(stack) << paths.front();
  EXPECT_EQ(fault_of(*stack), "");
  const std::int64_t count = whole->description().size.z;
  const auto all = planes_between(*whole, 0, count);
  for (std::int64_t first = 0; first < count; ++first) {
    for (std::int64_t end = first + 1; end <= count; ++end) {
      const NotingOpener opener;
      const auto some = make_slice_source(*stack, options, opener);
      EXPECT_EQ(some->description().metadata.text(), whole->description().metadata.text());
      EXPECT_EQ(some->files(), whole->files());
      EXPECT_TRUE(opener.opened->empty());
      const auto planes = planes_between(*some, first, end);
      EXPECT_TRUE(std::equal(planes.begin(), planes.end(), all.begin() + first))
          << paths.front() << ", planes " << first << " to " << end;
      EXPECT_EQ(*opener.opened, files_of_run(stack->files, first, end));
    }
  }
  const auto source = make_slice_source(*stack, options, NotingOpener{});
  expect_same_from_anywhere(*source);
}

TEST(SliceSource, PicturesAreOpenedAlone) {
  const TempFolder folder;
  std::vector<std::string> tiffs;
  std::vector<std::string> pngs;
  for (int z = 7; z < 12; ++z) {
    TiffSample sample;
    sample.bits = 16;
    sample.format = 2;
    sample.pages = {numbers(z * 100, 12)};
    tiffs.push_back(folder.file("s" + std::to_string(z) + ".tif"));
    write_tiff(tiffs.back(), sample);
    pngs.push_back(folder.file("s" + std::to_string(z) + ".png"));
    write_png(pngs.back(), 3, 2, 8, 2, counted(18, z));
  }
  expect_own_slices(tiffs, {});
  SourceOptions options;
  options.channel = "1";
  expect_own_slices(pngs, options);
}

TEST(SliceSource, RawPlanesAreOpenedAlone) {
  const TempFolder folder;
  std::vector<std::string> files;
  SourceOptions options;
  options.raw = parse_raw_layout("4,3,6,int16:be");
  options.raw->header_bytes = 5;
  options.on_gap = GapPolicy::ignore;
  for (const int z : {3, 4, 5, 8, 9, 12}) {
    files.push_back(folder.file("s" + std::to_string(z)));
    write_file(files.back(), "12345" + numbers(z * 100, 12));
  }
  expect_own_slices(files, options);
}

TEST(SliceSource, SlicesOfASeriesAreOpenedAloneWithTheirNeighborsWherePlanesNeedThem) {
  SourceOptions options;
  {
    const TempFolder folder;
    write_series(folder, {0, 2, 4, 6, 8});
    expect_own_slices({folder.path()}, options);
  }
  options.on_gap = GapPolicy::fill;
  {
    const TempFolder folder;
    write_series(folder, {0, 2, 6, 8, 12});
    expect_own_slices({folder.path()}, options);
  }
  options.on_gap = GapPolicy::resample;
  {
    const TempFolder folder;
    write_series(folder, {0, 2, 4, 4.5, 7.5, 10.5}, 0, std::int16_t{1004});
    expect_own_slices({folder.path()}, options);
  }
  options.untilt = true;
  {
    const TempFolder folder;
    write_series(folder, {0, 2, 4, 5, 8, 11}, 0.25);
    expect_own_slices({folder.path()}, options);
  }
}

TEST(SliceSource, PlanesBetweenSlicesTakeTheSlicesAroundThem) {
  const TempFolder folder;
  write_series(folder, {0, 2, 4, 6, 8, 10, 12, 14});
  const auto isotropic = [](std::unique_ptr<PlaneSource> slices, PlaneInterpolation method) {
    const IsotropicPlan plan = plan_isotropic(slices->description(), method);
    return make_isotropic_source(std::move(slices), plan);
  };
  // Pixels are square for that
  SourceOptions options;
  options.spacing_mm = Point3{0.5, 0.5, 2};
  for (const auto method : {PlaneInterpolation::linear, PlaneInterpolation::cubic}) {
    const auto base = open_source({folder.path()}, options);
    const auto stack = slice_stack_of(*base);
    ASSERT_TRUE(stack);
    const auto whole = isotropic(open_source({folder.path()}, options), method);
    EXPECT_FALSE(slice_stack_of(*whole));
    const NotingOpener opener;
    const auto some = isotropic(make_slice_source(*stack, options, opener), method);
    EXPECT_EQ(planes_between(*some, 9, 12), planes_between(*whole, 9, 12));
    EXPECT_EQ(*opener.opened, files_of_run(whole->files(), 9, 12));
    EXPECT_LE(opener.opened->size(), 5U);
  }
}

TEST(SliceSource, WhatOnlyTheWholeTellsIsNotOpenedApart) {
  const TempFolder folder;
  TiffSample sample;
  sample.pages = {counted(12, 0), counted(12, 1), counted(12, 2)};
  write_tiff(folder.file("pages.tif"), sample);
  EXPECT_FALSE(slice_stack_of(*open_source({folder.file("pages.tif")}, {})));
  // Wide numbers, which the first planes give their type
  std::vector<std::string> files;
  for (int z = 0; z < 3; ++z) {
    files.push_back(folder.file("wide" + std::to_string(z)));
    write_file(files.back(), bytes_of(std::vector<double>{1.0 * z, 2, 3, 4}));
  }
  SourceOptions options;
  options.raw = parse_raw_layout("2,2,3,float64");
  EXPECT_FALSE(slice_stack_of(*open_source(files, options)));
}

TEST(SliceSource, SlicesThatBecameOthersAreRejectedByName) {
  const TempFolder folder;
  write_series(folder, {0, 2, 4, 6});
  const auto stack = slice_stack_of(*open_source({folder.path()}, {}));
  ASSERT_TRUE(stack);
  DicomSample sample;
  sample.position = "0\\0\\4";
  sample.columns = 5;
  sample.voxels = numbers(0, 15);
  write_dicom(folder.file("s2.dcm"), sample);
  const auto source = make_slice_source(*stack, {}, open_source);
  planes_between(*source, 0, 2);
  const Error alone = error_of([&] { planes_between(*source, 2, 3); });
  EXPECT_EQ(alone.kind(), ErrorKind::source_rejected);
  EXPECT_TRUE(contains(alone, "s2.dcm")) << alone.what();
  EXPECT_TRUE(contains(alone, "5 x 3")) << alone.what();
  EXPECT_EQ(error_of([&] { planes_between(*source, 1, 4); }).kind(), ErrorKind::source_rejected);
  fs::remove(folder.file("s3.dcm"));
  EXPECT_EQ(error_of([&] { planes_between(*source, 3, 4); }).kind(), ErrorKind::io);
}

TEST(SliceSource, SlicesOfAnotherRescaleThanTheStackAreRejected) {
  const TempFolder folder;
  write_series(folder, {0, 2, 4, 6});
  const auto stack = slice_stack_of(*open_source({folder.path()}, {}));
  ASSERT_TRUE(stack);
  DicomSample sample;
  sample.position = "0\\0\\4";
  sample.voxels = numbers(2000, 12);
  sample.slope = "2";
  write_dicom(folder.file("s2.dcm"), sample);
  const auto source = make_slice_source(*stack, {}, open_source);
  planes_between(*source, 0, 2);
  const Error error = error_of([&] { planes_between(*source, 2, 3); });
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  EXPECT_TRUE(contains(error, "s2.dcm")) << error.what();
  EXPECT_TRUE(contains(error, "2 x + -1024")) << error.what();
  EXPECT_TRUE(contains(error, "1 x + -1024")) << error.what();
}

TEST(SliceSource, AStackThatNamesOtherSlicesThanThereAreIsRejected) {
  const TempFolder folder;
  write_series(folder, {0, 2, 6, 8});
  SourceOptions options;
  options.on_gap = GapPolicy::fill;
  const auto stack = slice_stack_of(*open_source({folder.path()}, options));
  ASSERT_TRUE(stack);
  const auto expect_fault = [&](auto change) {
    SliceStack changed = *stack;
    change(changed);
    EXPECT_NE(fault_of(changed), "");
    EXPECT_THROW(make_slice_source(changed, options, open_source), Error);
  };
  expect_fault([](SliceStack& s) { s.files.outline.reset(); });
  expect_fault([](SliceStack& s) { s.files.paths.pop_back(); });
  expect_fault([](SliceStack& s) { s.files.of_plane.pop_back(); });
  expect_fault([](SliceStack& s) { s.files.outline->planes.pop_back(); });
  expect_fault([](SliceStack& s) { s.files.outline->planes.back().weight_above = 0.5; });
  expect_fault([](SliceStack& s) { s.files.outline->planes[1].weight_above = -0.5; });
  expect_fault([](SliceStack& s) { s.files.outline->planes[1].below = 2; });
  expect_fault([](SliceStack& s) { s.files.outline->tilt.emplace(); });
  expect_fault([](SliceStack& s) {
    s.files.outline->tilt = TiltRemoval{1, {{0, 0}, {0, 1}, {0, 2}, {0, 3}}, 4, 3, 0};
  });
}

}  // namespace
}  // namespace octavo::testing
