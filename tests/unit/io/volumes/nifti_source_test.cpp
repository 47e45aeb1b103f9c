#include "octavo/io/volumes/nifti_source.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(NiftiSource, GivesStoredVoxelsAndLpsGeometry) {
  const TempFolder folder;
  for (const bool big_endian : {false, true}) {
    NiftiSample sample;
    sample.big_endian = big_endian;
    sample.slope = 0.1F;
    sample.intercept = -3;
    const std::string bytes = nifti_header(sample) + bytes_of(kStoredValues, big_endian);
    for (const std::string& name : {std::string("a.nii"), std::string("b.nii.gz")}) {
      write_file(folder.file(name), name.ends_with("gz") ? gzip(bytes) : bytes);
      const auto source = open_source({folder.file(name)}, {});
      const VolumeDescription& d = source->description();
      EXPECT_EQ(d.size, (Size3{4, 3, 2}));
      EXPECT_EQ(d.geometry.spacing_mm, (Point3{2, 3, 4}));
      EXPECT_EQ(d.geometry.origin_mm, (Point3{-10, -20, 30}));
      EXPECT_EQ(d.geometry.direction, (std::array<double, 9>{-1, 0, 0, 0, -1, 0, 0, 0, 1}));
      EXPECT_EQ(d.rescale, (Rescale{static_cast<double>(0.1F), -3}));
      EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues));
      EXPECT_TRUE(source->warnings().empty());
    }
  }
}

TEST(NiftiSource, WhatIsNoNumberOrOutOfTheFileIsNamed) {
  const TempFolder folder;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  struct Case {
    std::size_t at;
    float value;
    std::string words;
  };
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::string no_offset = "vox_offset of the header is no number of bytes that a file has";
  for (const Case& one : {Case{108, kNan, no_offset}, Case{108, kInfinity, no_offset},
                          Case{108, -kInfinity, no_offset}, Case{108, 2e15F, no_offset},
                          Case{108, -5, "are said to start at byte -5, before the file"},
                          Case{108, 0, "at byte 0, inside the header of 348 bytes"},
                          Case{108, 347, "at byte 347, inside the header of 348 bytes"},
                          Case{116, kNan, "scl_inter of the header is no number"}}) {
    NiftiSample sample;
    sample.slope = 2;
    std::string header = nifti_header(sample);
    header.replace(one.at, 4, bytes_of<float>({one.value}));
    write_file(folder.file("a.nii"), header + bytes_of(kStoredValues));
    expect_rejected(folder.file("a.nii"), {one.words});
  }
}

TEST(NiftiSource, ColorsAreNotScaled) {
  const TempFolder folder;
  for (const int datatype : {128, 2304}) {
    NiftiSample sample;
    sample.datatype = static_cast<std::int16_t>(datatype);
    sample.slope = 2;
    sample.intercept = std::numeric_limits<float>::quiet_NaN();
    write_file(folder.file("a.nii"), nifti_header(sample) + counted(96, 0));
    SourceOptions options;
    options.channel = "red";
    const auto source = open_source({folder.file("a.nii")}, options);
    EXPECT_TRUE(source->description().rescale.is_identity()) << datatype;
  }
}

TEST(NiftiSource, ALabelIntentMakesLabels) {
  const TempFolder folder;
  NiftiSample sample;
  sample.intent = 1002;
  write_file(folder.file("a.nii"), nifti_header(sample) + bytes_of(kStoredValues));
  EXPECT_EQ(open_source({folder.file("a.nii")}, {})->description().kind, VolumeKind::labels);
}

TEST(NiftiSource, APairIsReadFromItsOwnFolder) {
  const TempFolder folder;
  std::string header = nifti_header({});
  header.replace(344, 4, std::string("ni1\0", 4));
  header.replace(108, 4, bytes_of<float>({0}));
  write_file(folder.file("a.hdr"), header);
  EXPECT_TRUE(contains(source_error({folder.file("a.hdr")}), "a.img"));
  write_file(folder.file("a.img"), bytes_of(kStoredValues));
  EXPECT_TRUE(contains(source_error({folder.file("a.img")}), "give that"));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.hdr")}, {})), bytes_of(kStoredValues));
}

TEST(NiftiSource, WhatIsNoScalarVolumeIsRejectedByName) {
  const TempFolder folder;
  const std::vector<std::pair<std::int16_t, std::string>> types = {
      {128, "3 channels (red, green, blue)"}, {2304, "alpha"}, {32, "complex"}, {1536, "float 128"},
      {1, "1 bit"}, {77, "77"}};
  for (const auto& [datatype, word] : types) {
    NiftiSample sample;
    sample.datatype = datatype;
    write_file(folder.file("a.nii"), nifti_header(sample) + std::string(1000, '\0'));
    const Error error = source_error({folder.file("a.nii")});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, word)) << error.what();
  }
  NiftiSample sample;
  sample.size = {4, 3, 2, 5};
  write_file(folder.file("a.nii"), nifti_header(sample) + std::string(1000, '\0'));
  EXPECT_TRUE(contains(source_error({folder.file("a.nii")}), "5 points in time"));
}

TEST(NiftiSource, BitsOfAVoxelThatContradictItsTypeAreWarnedOf) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  const auto open_with = [&](std::int16_t datatype, std::int16_t bits, std::int16_t said) {
    NiftiSample sample;
    sample.datatype = datatype;
    sample.bits = said;
    write_file(path, nifti_header(sample) + counted(24U * static_cast<std::size_t>(bits) / 8, 0));
    SourceOptions options;
    options.channel = datatype == 128 || datatype == 2304 ? "red" : "";
    return open_source({path}, options);
  };
  for (const auto& [datatype, bits] : std::vector<std::pair<std::int16_t, std::int16_t>>{
           {2, 8}, {4, 16}, {8, 32}, {16, 32}, {128, 24}, {256, 8}, {512, 16}, {768, 32},
           {2304, 32}}) {
    const auto right = open_with(datatype, bits, bits);
    EXPECT_TRUE(right->warnings().empty()) << datatype;
    const std::string voxels = voxels_of(*right);
    const auto silent = open_with(datatype, bits, 0);
    EXPECT_TRUE(silent->warnings().empty()) << datatype;
    EXPECT_EQ(voxels_of(*silent), voxels) << datatype;
    const auto wrong = open_with(datatype, bits, 12);
    ASSERT_EQ(wrong->warnings().size(), 1U) << datatype;
    EXPECT_TRUE(contains(wrong->warnings()[0],
                         "bitpix of the header says that a voxel has 12 bits, datatype " +
                             std::to_string(datatype) + " has " + std::to_string(bits) +
                             ": the datatype counts: " + path));
    EXPECT_EQ(voxels_of(*wrong), voxels) << datatype;
  }
}

TEST(NiftiSource, EveryTruncationIsRejected) {
  const TempFolder folder;
  const std::string whole = nifti_header({}) + bytes_of(kStoredValues);
  expect_every_truncation_rejected(folder.file("a.nii"), whole);
  expect_every_truncation_rejected(folder.file("a.nii.gz"), gzip(whole));
}

}  // namespace
}  // namespace octavo::testing
