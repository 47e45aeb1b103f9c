#include "octavo/io/volumes/vtk_source.h"

#include <gtest/gtest.h>

#include "support/source_files.h"
#include "support/volume_readers.h"

namespace octavo::testing {
namespace {

/// 24 values, among them bytes that look like line ends and keywords' letters.
const std::vector<std::int16_t> kValues = {0,  1,  -1, 10,  2570, 3338, 83, 21313, 8, 9, 32767, -7,
                                           12, 13, 14, -15, 16,   17,   18, 19,    2, 3, 4,     5};

/// kValues as text, three in a line.
std::string text_of_values() {
  std::string text;
  for (std::size_t i = 0; i < kValues.size(); ++i) {
    text += std::to_string(kValues[i]) + (i % 3 == 2 ? "\n" : " ");
  }
  return text;
}

/// The parts of a legacy file that tests change.
struct VtkSample {
  std::string title = "a title";
  std::string kind = "BINARY\nDATASET STRUCTURED_POINTS\n";
  std::string grid = "DIMENSIONS 4 3 2\nSPACING 2 3 4\nORIGIN 1 2 3\n";
  std::string array = "POINT_DATA 24\nSCALARS s short 1\nLOOKUP_TABLE default\n";
  std::string voxels = bytes_of(kValues, true);
  std::string behind;
};

std::string bytes_of_vtk(const VtkSample& s) {
  return "# vtk DataFile Version 3.0\n" + s.title + "\n" + s.kind + s.grid + s.array + s.voxels +
         s.behind;
}

class VtkSource : public ::testing::Test {
 protected:
  void expect_voxels(const VtkSample& sample) {
    write_file(path_, bytes_of_vtk(sample));
    EXPECT_EQ(voxels_of(*open_source({path_}, {})), bytes_of(kValues));
  }
  void expect_rejected(const VtkSample& sample, const std::string& words) {
    write_file(path_, bytes_of_vtk(sample));
    const Error error = source_error({path_});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, words)) << error.what();
  }

  TempFolder folder_;
  std::string path_ = folder_.file("a.vtk");
};

VtkSample text_sample() {
  VtkSample sample;
  sample.kind = "ASCII\nDATASET STRUCTURED_POINTS\n";
  sample.voxels = text_of_values();
  return sample;
}

TEST_F(VtkSource, EveryReaderFindsTheSameInBinaryAndInText) {
  for (const VtkSample& sample : {VtkSample{}, text_sample()}) {
    write_file(path_, bytes_of_vtk(sample));
    for (const VolumeReader& reader : volume_readers()) {
      SCOPED_TRACE(reader.name + " " + sample.kind);
      const ReadVolume found = reader.read(path_);
      EXPECT_EQ(found.type, VoxelType::int16);
      EXPECT_EQ(found.size, (Size3{4, 3, 2}));
      EXPECT_EQ(found.geometry.spacing_mm, (Point3{2, 3, 4}));
      EXPECT_EQ(found.geometry.origin_mm, (Point3{1, 2, 3}));
      EXPECT_EQ(found.values, std::vector<double>(kValues.begin(), kValues.end()));
    }
    EXPECT_EQ(open_source({path_}, {})->resident_bytes(), 0U);
  }
}

TEST_F(VtkSource, TextOfEveryTypeIsRead) {
  VtkSample sample = text_sample();
  sample.grid = "DIMENSIONS 3 1 1\n";
  sample.voxels = "1 2 +3\n";
  for (const auto& [name, type] : std::vector<std::pair<std::string, VoxelType>>{
           {"char", VoxelType::int8}, {"unsigned_char", VoxelType::uint8},
           {"short", VoxelType::int16}, {"unsigned_short", VoxelType::uint16},
           {"int", VoxelType::int32}, {"unsigned_int", VoxelType::uint32},
           {"float", VoxelType::float32}}) {
    sample.array = "POINT_DATA 3\nSCALARS s " + name + "\nLOOKUP_TABLE default\n";
    write_file(path_, bytes_of_vtk(sample));
    const auto source = open_source({path_}, {});
    ASSERT_EQ(source->description().type, type);
    std::string expected;
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      expected = bytes_of(std::vector<T>{T{1}, T{2}, T{3}});
    });
    EXPECT_EQ(voxels_of(*source), expected) << name;
  }
}

TEST_F(VtkSource, WhatFollowsVoxelsOfTextIsExaminedWithTheLastPlane) {
  VtkSample sample = text_sample();
  for (const char* text : {"", "\n", "METADATA\nINFORMATION 0\n\n"}) {
    sample.behind = text;
    expect_voxels(sample);
  }
  sample.behind = "LOOKUP_TABLE colors 2\n0 0.5 1 1\n0 0 0 1\n";
  write_file(path_, bytes_of_vtk(sample));
  const auto source = open_source({path_}, {});
  EXPECT_EQ(voxels_of(*source), bytes_of(kValues));
  EXPECT_TRUE(contains(first_warning(*source), "color table"));
  sample.behind = "LOOKUP_TABLE colors 3\n0 0.5 1 1\n0 0 0 1\n";
  expect_rejected(sample, "cut");
  sample.behind = "SCALARS t short\nLOOKUP_TABLE default\n" + sample.voxels;
  expect_rejected(sample, "several arrays");
  sample.behind = "77\n";
  expect_rejected(sample, "no part of them");
}

TEST_F(VtkSource, TextThatIsNoVoxelsIsRejected) {
  for (const auto& [voxels, words] : std::vector<std::pair<std::string, std::string>>{
           {text_of_values().replace(0, 1, "32768"), "32768"},
           {text_of_values().replace(0, 1, "1.5"), "1.5"},
           {text_of_values().replace(0, 1, "one"), "one"},
           {"1 2 3\n", "too short"},
           {"1 2 3\n" + std::string(100, ' '), "cut"}}) {
    VtkSample sample = text_sample();
    sample.voxels = voxels;
    expect_rejected(sample, words);
  }
  VtkSample sample = text_sample();
  sample.grid = "DIMENSIONS 1000000 1000000 1000000\n";
  sample.array = "POINT_DATA 1000000000000000000\nSCALARS s short\n";
  expect_rejected(sample, "too short");
}

TEST_F(VtkSource, HeadersOfOnePointArrayGiveItsVoxels) {
  VtkSample sample;
  expect_voxels(sample);
  sample.title = "SCALARS LOOKUP_TABLE";
  expect_voxels(sample);
  sample.title = "";
  expect_voxels(sample);
  sample.kind = "binary\n\ndataset structured_points\n";
  sample.grid = "origin 1 2 3\r\naspect_ratio 2 3 4\r\ndimensions 4 3 2\r\n";
  expect_voxels(sample);
  for (const char* name : {"spacing", "ORIGIN", "vector_x", "METADATA", "LOOKUP_TABLE"}) {
    sample.array = "POINT_DATA 24\nSCALARS " + std::string(name) + " short\nLOOKUP_TABLE default\n";
    expect_voxels(sample);
  }
  sample.array = "POINT_DATA 24\nSCALARS s short\n";
  expect_voxels(sample);
}

TEST_F(VtkSource, NotesAndAColorTableMayFollowTheVoxels) {
  VtkSample sample;
  for (const char* text :
       {"\n", "\r\n \n", "\nMETADATA\nINFORMATION 0\n\n",
        "\nMETADATA\nINFORMATION 1\nNAME L2 LOCATION vtkDataArray\nDATA 2 0 1\n\n"}) {
    sample.behind = text;
    expect_voxels(sample);
  }
  sample.behind = "\nLOOKUP_TABLE colors 2\nabcdSCAL\n";
  expect_voxels(sample);
  EXPECT_TRUE(contains(first_warning(*open_source({path_}, {})), "color table"));
  sample.behind = "\nLOOKUP_TABLE colors 3\nabcdSCAL\n";
  expect_rejected(sample, "ends early");
}

TEST_F(VtkSource, BytesMayStandAsColorsOfOneValue) {
  VtkSample sample;
  sample.array = "POINT_DATA 24\nCOLOR_SCALARS s 1\n";
  sample.voxels = "LOOKUP_TABLE abcdefghijk";
  ASSERT_EQ(sample.voxels.size(), 24u);
  sample.behind = "\n";
  write_file(path_, bytes_of_vtk(sample));
  const auto source = open_source({path_}, {});
  EXPECT_EQ(source->description().type, VoxelType::uint8);
  EXPECT_EQ(voxels_of(*source), sample.voxels);
  sample.array = "POINT_DATA 24\nCOLOR_SCALARS s 3\n";
  expect_rejected(sample, "3 values per voxel (color)");
  sample.array = "POINT_DATA 24\nCOLOR_SCALARS s\n";
  expect_rejected(sample, "2 words, 3 expected");
  sample.kind = text_sample().kind;
  sample.array = "POINT_DATA 24\nCOLOR_SCALARS s 1\n";
  expect_rejected(sample, "save it as binary");
}

TEST_F(VtkSource, SeveralArraysAreRejected) {
  VtkSample sample;
  for (const std::string notes : {"\n", "\nMETADATA\nINFORMATION 0\n\n"}) {
    for (const std::string next : {"SCALARS b short 1\n", "VECTORS v float\n", "FIELD f 1\n",
                                   "CELL_DATA 6\nSCALARS c short\n"}) {
      sample.behind = notes + next + sample.voxels;
      expect_rejected(sample, "several arrays");
    }
  }
  sample.behind = "\n" + std::string(5, '\0') + "LUMEN";
  expect_rejected(sample, "no part of them");
}

TEST_F(VtkSource, ValuesOfCellsAndOtherArraysAreRejected) {
  VtkSample sample;
  const std::string points = sample.array;
  sample.array = "CELL_DATA 6\nSCALARS c short 1\nLOOKUP_TABLE default\n" + std::string(12, '\1') +
                 "\n" + points;
  expect_rejected(sample, "CELL_DATA");
  sample.array = "POINT_DATA 24\nVECTORS v short\n";
  expect_rejected(sample, "one value per voxel");
  sample.array = "POINT_DATA 24\nFIELD FieldData 1\ns 1 24 short\n";
  expect_rejected(sample, "one value per voxel");
  sample.array = "POINT_DATA 24\nSCALARS s short 3\nLOOKUP_TABLE default\n";
  expect_rejected(sample, "3 values per voxel");
  sample.array = "POINT_DATA 24\nSCALARS s bit 1\nLOOKUP_TABLE default\n";
  expect_rejected(sample, "type bit");
}

TEST_F(VtkSource, HeadersThatContradictThemselvesAreRejected) {
  const std::string array = VtkSample{}.array.substr(14);
  for (const auto& [grid, points, words] : std::vector<std::array<std::string, 3>>{
           {"DIMENSIONS 4 3 2\n", "POINT_DATA 25\n", "25 points"},
           {"DIMENSIONS 4 3 2\n", "", "point_data"},
           {"", "POINT_DATA 24\n", "dimensions"},
           {"DIMENSIONS 4 3 2\nDIMENSIONS 3 4 2\n", "POINT_DATA 24\n", "twice"},
           {"DIMENSIONS 4 -3 -2\n", "POINT_DATA 24\n", "three numbers"},
           {"DIMENSIONS 4 3 2\nSPACING 1 1\n", "POINT_DATA 24\n", "3 numbers expected"},
           {"DIMENSIONS 4 3 2\nSPACING 1 1 0\n", "POINT_DATA 24\n", "geometry"},
           {"DIMENSIONS 4 3 2\nMIDDLE 1 1 1\n", "POINT_DATA 24\n", "MIDDLE"}}) {
    VtkSample sample;
    sample.grid = grid;
    sample.array = points + array;
    expect_rejected(sample, words);
  }
  VtkSample sample;
  sample.kind = "TEXT\nDATASET STRUCTURED_POINTS\n";
  expect_rejected(sample, "BINARY or ASCII expected");
  sample.kind = "BINARY\nDATASET RECTILINEAR_GRID\n";
  expect_rejected(sample, "RECTILINEAR_GRID");
  write_file(path_, "# something\n");
  EXPECT_TRUE(contains(source_error({path_}), "not a legacy VTK file"));
}

TEST_F(VtkSource, TheSpacingIsKnownOnlyWhereItStands) {
  VtkSample sample;
  sample.grid = "DIMENSIONS 4 3 2\nORIGIN 1 2 3\n";
  expect_voxels(sample);
  const auto source = open_source({path_}, {});
  EXPECT_TRUE(contains(source->description().metadata.text(), "\"spacing_source\":\"assumed\""));
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(source->warnings()[0], "[spacing_mm]"));
  EXPECT_EQ(source->description().geometry.origin_mm, (Point3{1, 2, 3}));
  for (const char* keyword : {"SPACING", "ASPECT_RATIO"}) {
    sample.grid = "DIMENSIONS 4 3 2\n" + std::string(keyword) + " 2 3 4\n";
    expect_voxels(sample);
    const auto known = open_source({path_}, {});
    EXPECT_EQ(known->description().geometry.spacing_mm, (Point3{2, 3, 4}));
    EXPECT_TRUE(known->warnings().empty());
  }
}

TEST_F(VtkSource, EveryTruncationIsRejected) {
  for (VtkSample sample : {VtkSample{}, text_sample()}) {
    sample.title = "SCALARS LOOKUP_TABLE";
    const std::string whole = bytes_of_vtk(sample);
    for (std::size_t length = 1; length < whole.size(); ++length) {
      write_file(path_, whole.substr(0, length));
      EXPECT_EQ(source_error({path_}).kind(), ErrorKind::source_rejected) << length;
    }
  }
}

}  // namespace
}  // namespace octavo::testing
