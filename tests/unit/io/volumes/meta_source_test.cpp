#include "octavo/io/volumes/meta_source.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(MetaSource, VoxelsAreReadInsideDetachedAndCompressed) {
  const TempFolder folder;
  const std::string header =
      "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
      "ElementSpacing = 2 3 4\nOffset = 10 20 30\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\n";
  write_file(folder.file("a.mha"), header +
                                       "BinaryDataByteOrderMSB = True\nElementDataFile = LOCAL\n" +
                                       bytes_of(kStoredValues, true));
  write_file(folder.file("b.mhd"), header + "ElementDataFile = data/b.raw\n");
  write_file(folder.file("data/b.raw"), bytes_of(kStoredValues));
  write_file(folder.file("c.mhd"), header + "CompressedData = True\nElementDataFile = c.zraw\n");
  write_file(folder.file("c.zraw"), zlib_stream(bytes_of(kStoredValues)));
  write_file(folder.file("d.mhd"), header + "HeaderSize = -1\nElementDataFile = d.raw\n");
  write_file(folder.file("d.raw"), "some header" + bytes_of(kStoredValues));
  for (const char* name : {"a.mha", "b.mhd", "c.mhd", "d.mhd"}) {
    const auto source = open_source({folder.file(name)}, {});
    EXPECT_EQ(source->description().geometry.origin_mm, (Point3{10, 20, 30})) << name;
    EXPECT_EQ(source->description().geometry.direction,
              (std::array<double, 9>{0, -1, 0, 1, 0, 0, 0, 0, 1}))
        << name;
    EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues)) << name;
    EXPECT_EQ(source->resident_bytes(), 0U);
  }
}

TEST(MetaSource, HeadersThatAskForTheUnreadableAreRejected) {
  const TempFolder folder;
  const std::string good =
      "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nElementDataFile = ";
  for (const std::string& header :
       {good + "../b.raw\n", good + "/etc/passwd\n", good + "b%03d.raw 1 2 1\n",
        good + "LIST\na\nb\n", good + "LIST D\na\n", good + "LIST 2DD\na\nb\n",
        good + "missing.raw\n",
        "ElementNumberOfChannels = 3\n" + good + "LOCAL\n",
        "BinaryData = False\n" + good + "LOCAL\n",
        std::string(
            "NDims = 3\nDimSize = 4 3 2\nElementType = MET_STRING\nElementDataFile = LOCAL\n"),
        std::string(
            "NDims = 4\nDimSize = 4 3 2 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"),
        std::string("NDims = 3\nDimSize = 4 3 2\n")}) {
    write_file(folder.file("a.mha"), header + std::string(500, '\0'));
    EXPECT_EQ(source_error({folder.file("a.mha")}).kind(), ErrorKind::source_rejected) << header;
  }
}

TEST(MetaSource, KeysOfTheByteOrderMayNotContradictEachOther) {
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  const auto write = [&](const std::string& keys) {
    write_file(path, "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n" + keys +
                         "ElementDataFile = LOCAL\n" + bytes_of(kStoredValues));
  };
  write("ElementByteOrderMSB = False\nBinaryDataByteOrderMSB = 0\n");
  EXPECT_EQ(voxels_of(*open_source({path}, {})), bytes_of(kStoredValues));
  for (const char* keys : {"ElementByteOrderMSB = True\nBinaryDataByteOrderMSB = False\n",
                           "ElementByteOrderMSB = False\nBinaryDataByteOrderMSB = True\n"}) {
    write(keys);
    expect_rejected(path, {"ElementByteOrderMSB", "BinaryDataByteOrderMSB", "contradict"});
  }
}

TEST(MetaSource, WordsThatAreNeitherTrueNorFalseAreRejected) {
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  const auto write = [&](const std::string& line, const std::string& voxels) {
    write_file(path, "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n" + line +
                         "\nElementDataFile = LOCAL\n" + voxels);
  };
  for (const char* word : {"True", "true", "TRUE", "T", "t", "1"}) {
    write("ElementByteOrderMSB = " + std::string(word), bytes_of(kStoredValues, true));
    EXPECT_EQ(voxels_of(*open_source({path}, {})), bytes_of(kStoredValues)) << word;
    write("CompressedData = " + std::string(word), zlib_stream(bytes_of(kStoredValues)));
    EXPECT_EQ(voxels_of(*open_source({path}, {})), bytes_of(kStoredValues)) << word;
    write("BinaryData = " + std::string(word), bytes_of(kStoredValues));
    EXPECT_EQ(voxels_of(*open_source({path}, {})), bytes_of(kStoredValues)) << word;
  }
  for (const char* word : {"False", "false", "FALSE", "F", "f", "0", "No", "off"}) {
    write("ElementByteOrderMSB = " + std::string(word), bytes_of(kStoredValues));
    EXPECT_EQ(voxels_of(*open_source({path}, {})), bytes_of(kStoredValues)) << word;
  }
  for (const std::string field :
       {"ElementByteOrderMSB", "BinaryDataByteOrderMSB", "CompressedData", "BinaryData"}) {
    for (const std::string word : {"yes", "Y", "on", "maybe", "2", "-1", "10", "=rue", "Trues",
                                   "True False", ""}) {
      write(field + " = " + word, bytes_of(kStoredValues));
      expect_rejected(path, {field, "\"" + word + "\"", "True or False expected"});
    }
  }
}

TEST(MetaSource, FieldsThatContradictEachOtherAreRejected) {
  struct Case {
    std::string name;
    std::string first;
    std::string other_name;
    std::string other;
    bool is_same;
  };
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  const std::string unit = "1 0 0 0 1 0 0 0 1";
  const std::string turned = "0 1 0 1 0 0 0 0 1";
  for (const Case& one : std::vector<Case>{
           {"ElementSpacing", "1 1 2", "ElementSpacing", "1 1 3", false},
           {"ElementSpacing", "1 1 2", "ElementSpacing", "1.0  1 2.0", true},
           {"DimSize", "4 3 2", "DimSize", "3 4 2", false},
           {"ElementType", "MET_UCHAR", "ElementType", "MET_CHAR", false},
           {"ElementType", "MET_UCHAR", "ElementType", "MET_UCHAR", true},
           {"Offset", "1 1 1", "Offset", "5 5 5", false},
           {"Offset", "1 1 1", "Position", "5 5 5", false},
           {"Offset", "1 1 1", "Origin", "1 1 1", true},
           {"Position", "1 1 1", "Origin", "1 1 2", false},
           {"TransformMatrix", unit, "TransformMatrix", turned, false},
           {"TransformMatrix", unit, "Rotation", turned, false},
           {"Rotation", unit, "Orientation", turned, false},
           {"TransformMatrix", unit, "Orientation", unit, true},
           {"ElementByteOrderMSB", "False", "ElementByteOrderMSB", "True", false},
           {"HeaderSize", "0", "HeaderSize", "-1", false},
           {"Comment", "one", "Comment", "two", true},
           {"Scanner", "one", "Scanner", "two", true},
           // The extent of a voxel may be another than the distance to the next one.
           {"ElementSpacing", "1 1 2", "ElementSize", "1 1 5", true}}) {
    write_meta(path, one.name + " = " + one.first + "\n" + one.other_name + " = " + one.other);
    if (one.is_same) {
      EXPECT_EQ(voxels_of(*open_source({path}, {})), std::string(24, '\1')) << one.name;
    } else {
      expect_rejected(path, {one.name, one.first, one.other_name, one.other, "contradict"});
    }
  }
}

TEST(MetaSource, AListOfFilesThatHoldAllNamesOne) {
  const TempFolder folder;
  write_parts(folder, 2);
  write_file(folder.file("a.mhd"), "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
                                   "ElementDataFile = LIST 3\np1.raw\np2.raw\n");
  expect_rejected(folder.file("a.mhd"), {"names 2 data files", "1 expected"});
}

TEST(MetaSource, VoxelsMayStandInSeveralFiles) {
  struct Case {
    std::size_t files;
    std::string fields;
    bool is_zlib = false;
    std::string front = {};
  };
  for (const Case& one : std::vector<Case>{
           {2, "ElementDataFile = LIST\np1.raw\np2.raw\n"},
           {2, "ElementDataFile = LIST 2\r\np1.raw\r\np2.raw"},
           {2, "ElementDataFile = LIST 7\np1.raw\np2.raw\n"},
           {2, "ElementDataFile = LIST 2D\np1.raw\np2.raw\n"},
           {1, "ElementDataFile = LIST 3d\np1.raw\n"},
           {6, "ElementDataFile = LIST 1\np1.raw\np2.raw\np3.raw\np4.raw\np5.raw\np6.raw\n"},
           {1, "ElementDataFile = LIST 3\np1.raw\n"},
           {2, "ElementDataFile = p%d.raw\n"},
           {2, "ElementDataFile = p%01d.raw 1\n"},
           {2, "ElementDataFile = p%d.raw 1 2\n"},
           {2, "ElementDataFile = p%d.raw 1 2 1\n"},
           {2, "CompressedData = True\nElementDataFile = p%d.raw 1 2 1\n", true},
           {2, "HeaderSize = 3\nElementDataFile = p%d.raw 1 2 1\n", false, "abc"},
           {2, "HeaderSize = -1\nElementDataFile = LIST\np1.raw\np2.raw\n", false, "ab"}}) {
    const TempFolder folder;
    write_parts(folder, one.files, [&](const std::string& part) {
      return one.front + (one.is_zlib ? zlib_stream(part) : part);
    });
    write_file(folder.file("a.mhd"), "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 1 1\n"
                                     "ElementType = MET_SHORT\n" + one.fields);
    const auto source = open_source({folder.file("a.mhd")}, {});
    EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues)) << one.fields;
    EXPECT_EQ(source->files().paths.size(), one.files + 1);
    EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
  }
}

TEST(MetaSource, AListOfFilesMayHaveAMebibyte) {
  constexpr std::size_t kMost = std::size_t{1} << 20;
  const TempFolder folder;
  write_parts(folder, 2);
  const std::string header = "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 1 1\n"
                             "ElementType = MET_SHORT\nElementDataFile = LIST\np1.raw\np2.raw";
  write_file(folder.file("a.mhd"), header + std::string(kMost - header.size(), '\n'));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.mhd")}, {})), bytes_of(kStoredValues));
  write_file(folder.file("a.mhd"), header + std::string(kMost - header.size() + 1, '\n'));
  expect_rejected(folder.file("a.mhd"), {"the list of data files exceeds 1 MiB"});
}

TEST(MetaSource, AFileShorterThanTheVoxelsAtItsEndIsNamed) {
  const TempFolder folder;
  write_file(folder.file("a.mhd"), "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
                                   "HeaderSize = -1\nElementDataFile = a.raw\n");
  write_file(folder.file("a.raw"), std::string(47, '\0'));
  const Error error = source_error({folder.file("a.mhd")});
  EXPECT_EQ(error.path(), folder.file("a.raw"));
  EXPECT_TRUE(contains(error, "48 bytes of voxels expected at its end, 47 found"));
}

TEST(MetaSource, EveryTruncationIsRejected) {
  const TempFolder folder;
  expect_every_truncation_rejected(
      folder.file("a.mha"),
      "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n" +
          bytes_of(kStoredValues));
}

TEST(MetaSource, AxesThatContradictTheSpacingAreRejectedUnlessASpacingIsGiven) {
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  write_meta(path, "TransformMatrix = 2 0 0 0 2 0 0 0 2");
  expect_rejected(path, {"TransformMatrix", "axis x has length 2, 1 expected", "[spacing_mm]"});
  const Geometry given = geometry_of(path, with_spacing(3, 4, 5));
  EXPECT_EQ(given.direction, Geometry{}.direction);
  EXPECT_EQ(given.spacing_mm, (Point3{3, 4, 5}));
  write_meta(path, "Rotation = 1 0 0 0 1 0 0 0 0");
  expect_rejected(path, {"Rotation", "axis z has length 0", "repair"}, with_spacing(1, 1, 1));
}

TEST(MetaSource, AxesWithinAThousandthOfAGridStayAsTheyAre) {
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  for (const Matrix3& m : {Matrix3{1.0005, 0, 0, 0, 1, 0, 0, 0, 1},
                           Matrix3{1, 0.0005, 0, 0, 1, 0, 0, 0, 1},
                           Matrix3{0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, -1}}) {
    std::string text = "TransformMatrix =";
    for (const double v : m) text += " " + std::to_string(v);
    write_meta(path, text);
    // The file lists one axis after the other.
    const Matrix3 columns = {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]};
    EXPECT_EQ(geometry_of(path).direction, columns);
  }
}

TEST(MetaSource, LengthsAreInTheUnitOfTheHeader) {
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  const auto write = [&](const std::string& unit) {
    write_file(path, "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 2 3 4\nOffset = 10 20 30\n" +
                         (unit.empty() ? "" : "DistanceUnits = " + unit + "\n") +
                         "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                         std::string(24, '\1'));
  };
  for (const auto& [unit, mm] : std::vector<std::pair<std::string, double>>{
           {"", 1}, {"?", 1}, {"mm", 1}, {"um", 1e-3}, {"cm", 10}}) {
    write(unit);
    EXPECT_EQ(spacing_of(path), (Point3{2 * mm, 3 * mm, 4 * mm})) << unit;
    EXPECT_DOUBLE_EQ(open_source({path}, {})->description().geometry.origin_mm[2], 30 * mm);
  }
  write("parsec");
  EXPECT_TRUE(contains(source_error({path}), "parsec"));
}

}  // namespace
}  // namespace octavo::testing
