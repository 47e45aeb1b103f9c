#include "octavo/io/volumes/nrrd_geometry.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

using Rows = std::vector<std::pair<std::string, std::string>>;

const std::string kDirections = "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)";

TEST(NrrdGeometry, SpacesAndVoxelsAreTurnedToLps) {
  const TempFolder folder;
  const std::string rest = "type: int16\ndimension: 3\nsizes: 4 3 2\nendian: big\nencoding: raw\n"
                           "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n";
  for (const auto& [space, origin] :
       std::vector<std::pair<std::string, Point3>>{{"left-posterior-superior", {10, 20, 30}},
                                                   {"right-anterior-superior", {-10, -20, 30}},
                                                   {"LAS", {10, -20, 30}}}) {
    write_file(folder.file("a.nrrd"), "NRRD0004\n# a remark\nspace: " + space + "\n" + rest + "\n" +
                                          bytes_of(kStoredValues, true));
    const auto source = open_source({folder.file("a.nrrd")}, {});
    EXPECT_EQ(source->description().geometry.origin_mm, origin);
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
    EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues));
  }
}

TEST(NrrdGeometry, AxesWithoutALengthAreRejectedByName) {
  const TempFolder folder;
  write_nrrd(folder.file("a.nrrd"), "space: LPS\nspace directions: (1,0,0) (0,0,0) (0,0,2)");
  expect_rejected(folder.file("a.nrrd"), {"space directions", "axis y has no length"});
}

TEST(NrrdGeometry, AxesOfSpacesThatNameLeftAreTurnedToLps) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  for (const auto& [space, signs] : std::vector<std::pair<std::string, Point3>>{
           {"left-posterior-superior", {1, 1, 1}}, {"LPS", {1, 1, 1}},
           {"right-anterior-superior", {-1, -1, 1}}, {"RAS", {-1, -1, 1}},
           {"Left-Anterior-Superior", {1, -1, 1}}, {"las", {1, -1, 1}}}) {
    write_nrrd(path, "space: " + space + "\n" + kDirections);
    const auto source = open_source({path}, {});
    const Geometry& g = source->description().geometry;
    EXPECT_EQ(g.direction, (Matrix3{signs[0], 0, 0, 0, signs[1], 0, 0, 0, signs[2]})) << space;
    EXPECT_EQ(g.origin_mm, (Point3{signs[0], 2 * signs[1], 3 * signs[2]})) << space;
    EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"place_known\":true")) << space;
  }
}

TEST(NrrdGeometry, AxesOfSpacesThatDoNotNameLeftStayAndAreReportedAsUnplaced) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  for (const auto& [line, word] :
       Rows{{"space: scanner-xyz\n", "scanner-xyz"}, {"space: 3D-right-handed\n", "3D-right"},
            {"space: 3D-left-handed\n", "mirror image"}, {"space dimension: 3\n", "no space"},
            {"", "no space"}}) {
    write_nrrd(path, line + kDirections);
    const auto source = open_source({path}, {});
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
    EXPECT_EQ(source->description().geometry.origin_mm, (Point3{1, 2, 3}));
    const std::string said = with_hints(source->warnings());
    EXPECT_TRUE(contains(said, word) && contains(said, "does not say where left is")) << said;
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"place_known\":false")) << line;
  }
}

TEST(NrrdGeometry, SpacesOfAnotherNameAreRejectedWithTheNamesThatAreRead) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  for (const char* space : {"right-posterior-superior", "RPS", "foo", "RAST", "3D-left"}) {
    write_nrrd(path, std::string("space: ") + space + "\n" + kDirections);
    expect_rejected(path, {std::string("\"") + space + "\" is not read", "(LPS)", "(RAS)", "(LAS)",
                           "scanner-xyz"});
    write_nrrd(path, std::string("space: ") + space + "\nspacings: 1 1 2");
    EXPECT_TRUE(contains(with_hints(open_source({path}, {})->warnings()), "are left out")) << space;
  }
}

TEST(NrrdGeometry, ASpaceWithoutDirectionsIsLeftOutWithAWarning) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  write_nrrd(path, "space: RAS\nspacings: 2 3 4\nspace origin: (1,2,3)");
  const auto source = open_source({path}, {});
  EXPECT_EQ(source->description().geometry, (Geometry{{0, 0, 0}, {2, 3, 4}}));
  EXPECT_TRUE(contains(with_hints(source->warnings()), "orientation and origin are left out"));
}

TEST(NrrdGeometry, TheOriginIsWhereAxisMinsSay) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  struct Row {
    std::string lines;
    Point3 origin;
    bool is_told;  ///< that cells are assumed
  };
  for (const auto& [lines, origin, is_told] : std::vector<Row>{
           {"spacings: 1 1 2\naxis mins: 10 20 30", {10.5, 20.5, 31}, true},
           {"spacings: 1 1 2\naxismins: 10 20 30\ncenters: cell cell cell",
            {10.5, 20.5, 31}, false},
           {"spacings: 1 1 2\naxis mins: 10 20 30\ncenterings: node node node",
            {10, 20, 30}, false},
           {"spacings: 1 1 2\naxis mins: 10 20 30\ncenters: cell node ???", {10.5, 20, 31}, true},
           {"spacings: -1 1 2\naxis mins: 10 nan 30\ncenters: cell cell cell", {9.5, 0, 31}, false},
           {"spacings: 1 1 2\naxis mins: 10 20 30\ncenters: node node node\n"
            "units: \"cm\" \"mm\" \"mm\"", {100, 20, 30}, false}}) {
    write_nrrd(path, lines);
    const auto source = open_source({path}, {});
    EXPECT_EQ(source->description().geometry.origin_mm, origin) << lines;
    EXPECT_EQ(contains(with_hints(source->warnings()), "taken as the borders"), is_told) << lines;
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"place_known\":false")) << lines;
  }
  write_nrrd(path, "spacings: 1 1 2\naxis mins: 10 20");
  expect_rejected(path, {"axis mins: 3 numbers expected, 2 found"});
  write_nrrd(path, "spacings: 1 1 2\naxis mins: 10 20 30\ncenters: cell");
  expect_rejected(path, {"centers has 1 word for 3 axes"});
  write_nrrd(path, "axis mins: 10 20 30");
  EXPECT_TRUE(contains(with_hints(open_source({path}, {})->warnings()), "the origin is left out"));
}

TEST(NrrdGeometry, BordersOfAxesGiveTheirSpacing) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  // Of 4 x 3 x 2 voxels
  struct Row {
    std::string lines;
    Point3 spacing;
    Point3 origin;
  };
  for (const auto& [lines, spacing, origin] : std::vector<Row>{
           {"axis mins: 0 10 20\naxis maxs: 2 16 25\ncenters: cell cell cell",
            {0.5, 2, 2.5}, {0.25, 11, 21.25}},
           {"axis mins: 0 10 20\naxis maxs: 6 16 25\ncenters: node node node",
            {2, 3, 5}, {0, 10, 20}},
           {"axis mins: 2 10 20\naxis maxs: 0 16 25\ncenters: cell cell cell",
            {0.5, 2, 2.5}, {1.75, 11, 21.25}},
           {"spacings: nan 2 nan\naxis mins: 0 10 20\naxis maxs: 2 16 25\ncenters: cell cell cell",
            {0.5, 2, 2.5}, {0.25, 11, 21.25}},
           {"axis mins: 0 10 20\naxis maxs: 2 16 25\ncenters: cell cell cell\n"
            "units: \"cm\" \"mm\" \"mm\"", {5, 2, 2.5}, {2.5, 11, 21.25}}}) {
    write_nrrd(path, lines);
    const auto source = open_source({path}, {});
    EXPECT_EQ(source->description().geometry.spacing_mm, spacing) << lines;
    EXPECT_EQ(source->description().geometry.origin_mm, origin) << lines;
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"spacing_known\":true")) << lines;
  }
  for (const char* lines : {"axis mins: 0 10 20\naxis maxs: 2 10 25", "axis maxs: 2 16 25",
                            "axis mins: 0 nan 20\naxis maxs: 2 16 25"}) {
    write_nrrd(path, lines);
    EXPECT_TRUE(contains(open_source({path}, {})->description().metadata.text(),
                         "\"spacing_known\":false")) << lines;
  }
  write_nrrd(path, "axis mins: 0 10 20\naxis maxs: 2 16");
  expect_rejected(path, {"3 numbers expected, 3 and 2 found"});
}

TEST(NrrdGeometry, LengthsThatContradictEachOtherAreRejectedUnlessASpacingIsGiven) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const std::string space = "space: LPS\n" + kDirections + "\n";
  // Of 4 x 3 x 2 voxels
  for (const auto& [lines, word] :
       Rows{{space + "spacings: 2 3 5", "axis z"},
            {space + "spacings: nan 1 nan", "axis y"},
            {space + "spacings: 2 3 4\nunits: \"cm\" \"cm\" \"cm\"", "axis x"},
            {"spacings: 1 1 2\naxis mins: 0 0 0\naxis maxs: 4 30 4", "axis y"},
            {"spacings: 1 1 2\naxis mins: 0 0 0\naxis maxs: 4 3 2\ncenters: cell cell cell",
             "axis z"},
            {"spacings: 1 1 2\naxis mins: 4 0 0\naxis maxs: 0 3 4", "axis x"}}) {
    write_nrrd(path, lines);
    expect_rejected(path, {word, "spacings", "contradict", "[spacing_mm]"});
    EXPECT_EQ(geometry_of(path, with_spacing(3, 4, 5)).spacing_mm, (Point3{3, 4, 5})) << lines;
  }
  for (const std::string& lines :
       {space + "spacings: 2 -3 4.0001", space + "spacings: nan nan nan",
        space + "space units: \"mm\" \"mm\" \"mm\"\nspacings: 0.2 0.3 0.4\n"
                "units: \"cm\" \"cm\" \"cm\"",
        // Where "centers" is silent, voxels may be cells or nodes.
        std::string("spacings: 2 3 4\naxis mins: 0 0 0\naxis maxs: 8 6 8"),
        std::string("spacings: -2 3 4\naxis mins: 8 0 0\naxis maxs: 0 nan 8")}) {
    write_nrrd(path, lines);
    EXPECT_EQ(spacing_of(path), (Point3{2, 3, 4})) << lines;
  }
}

TEST(NrrdGeometry, TheUnitOfTimeIsNoLength) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const std::string units = "units: \"mm\" \"mm\" \"mm\" \"s\"\n";
  for (const std::string& lines :
       {"spacings: 2 3 4 0.5\n" + units + "kinds: space space space time\n",
        "spacings: nan nan 4 0.5\n" + units + "space: LPS\n"
        "space directions: (2,0,0) (0,3,0) (0,0,4) none\nkinds: space space space time\n"}) {
    write_file(path, "NRRD0005\ntype: uchar\ndimension: 4\nsizes: 4 3 2 1\nencoding: raw\n" +
                         lines + "\n" + std::string(24, '\1'));
    EXPECT_EQ(spacing_of(path), (Point3{2, 3, 4})) << lines;
  }
}

TEST(NrrdGeometry, MinsAndMaxsBesideDirectionsAreLeftOutWithAWarning) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  for (const auto& [lines, is_told] : std::vector<std::pair<std::string, bool>>{
           {"axis mins: 5 5 5", true}, {"axis maxs: nan nan 9", true},
           {"axis mins: nan nan nan\naxis maxs: nan nan nan", false}}) {
    write_nrrd(path, "space: LPS\n" + kDirections + "\n" + lines);
    const auto source = open_source({path}, {});
    EXPECT_EQ(source->description().geometry.origin_mm, (Point3{1, 2, 3}));
    EXPECT_EQ(contains(with_hints(source->warnings()), "are left out"), is_told) << lines;
  }
}

TEST(NrrdGeometry, ASpaceOfAnotherDimensionIsRejected) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  for (const std::string line : {"space: LPS\n", "space: scanner-xyz\n", ""}) {
    write_nrrd(path, line + "space dimension: 2\n" + kDirections);
    expect_rejected(path, {"space dimension is 2, 3 expected"});
  }
  write_nrrd(path, "space: LPS\nspace dimension: 3\n" + kDirections);
  EXPECT_EQ(spacing_of(path), (Point3{2, 3, 4}));
}

TEST(NrrdGeometry, AnImageLiesInThePlaneOrAsItsVectorsOfThreeNumbersSay) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const auto write = [&](const std::string& lines) {
    write_file(path, "NRRD0005\ntype: uchar\ndimension: 2\nsizes: 4 3\nencoding: raw\n" + lines +
                         "\n\n" + std::string(12, '\1'));
  };
  struct Row {
    std::string lines;
    Geometry geometry;
  };
  for (const auto& [lines, geometry] : std::vector<Row>{
           {"space dimension: 2\nspace directions: (2,0) (0,3)\nspace origin: (5,6)",
            {{5, 6, 0}, {2, 3, 1}}},
           {"space dimension: 2\nspace directions: (0,2) (-3,0)\nspace units: \"cm\" \"cm\"",
            {{0, 0, 0}, {20, 30, 1}, {0, -1, 0, 1, 0, 0, 0, 0, 1}}},
           {"space: RAS\nspace directions: (0,2,0) (0,0,3)\nspace origin: (5,6,7)",
            {{-5, -6, 7}, {2, 3, 1}, {0, 0, -1, -1, 0, 0, 0, 1, 0}}}}) {
    write(lines);
    const Geometry g = geometry_of(path);
    EXPECT_EQ(g.spacing_mm, geometry.spacing_mm) << lines;
    EXPECT_EQ(g.origin_mm, geometry.origin_mm) << lines;
    for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(g.direction[i], geometry.direction[i]) << lines;
  }
  write("space dimension: 2\nspace directions: (2,0,0) (0,3,0)");
  expect_rejected(path, {"space directions", "4 numbers expected, 6 found"});
  write("space dimension: 2\nspace directions: (2,0) (2,0)");
  expect_rejected(path, {"axes x and y stand at 0 degrees"});
  write("space dimension: 2\nspace directions: (2,0) (0,0)");
  expect_rejected(path, {"the vector of axis y has no length"});
  write("space dimension: 2\nspace directions: (2,0) (0,3)\nspace units: \"cm\"");
  expect_rejected(path, {"\"space units\" names 1 unit in quotes, 2 expected"});
}

TEST(NrrdGeometry, AnAxisRunsBackwardsWhereItsSpacingIsNegative) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  write_nrrd(path, "spacings: 1 -1 2");
  const Geometry g = geometry_of(path);
  EXPECT_EQ(g.spacing_mm, (Point3{1, 1, 2}));
  EXPECT_EQ(g.direction, (Matrix3{1, 0, 0, 0, -1, 0, 0, 0, 1}));
}

TEST(NrrdGeometry, LengthsAreInTheUnitsOfTheHeader) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const auto write = [&](const std::string& lines) {
    write_file(path, "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n" + lines +
                         "\n" + std::string(24, '\1'));
  };
  const std::string axes =
      "space: left-posterior-superior\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
      "space origin: (10,20,30)\n";
  for (const auto& [unit, mm] : std::vector<std::pair<std::string, double>>{
           {"mm", 1}, {"um", 1e-3}, {"\xc2\xb5m", 1e-3}, {"microns", 1e-3}, {"cm", 10},
           {"m", 1000}, {"", 1}}) {
    const std::string quoted = "\"" + unit + "\" ";
    write(axes + "space units: " + quoted + quoted + quoted + "\n");
    EXPECT_EQ(spacing_of(path), (Point3{2 * mm, 3 * mm, 4 * mm})) << unit;
    EXPECT_DOUBLE_EQ(open_source({path}, {})->description().geometry.origin_mm[2], 30 * mm);
    write("spacings: 2 3 4\nunits: " + quoted + quoted + quoted + "\n");
    EXPECT_EQ(spacing_of(path), (Point3{2 * mm, 3 * mm, 4 * mm})) << unit;
  }
  for (const std::string& lines : {axes + "space units: \"furlong\" \"mm\" \"mm\"\n",
                                  std::string("spacings: 2 3 4\nunits: \"pixel\" \"mm\" \"mm\"\n"),
                                  axes + "space units: \"mm\" \"mm\"\n"}) {
    write(lines);
    const Error error = source_error({path});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, "units")) << error.what();
  }
  write("spacings: 2 3 4\nunits: \"pixel\" \"pixel\" \"mm\"\n");
  SourceOptions options;
  options.spacing_mm = Point3{5, 6, 7};
  EXPECT_EQ(open_source({path}, options)->description().geometry.spacing_mm, (Point3{5, 6, 7}));
}

}  // namespace
}  // namespace octavo::testing
