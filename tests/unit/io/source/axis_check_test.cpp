// Axes that headers give: their lengths, their angles, and where the body's left is.
#include <gtest/gtest.h>

#include <limits>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

using Matrix3 = std::array<double, 9>;
using Rows = std::vector<std::pair<std::string, std::string>>;

std::string all_of(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + "\n";
  return all;
}

Geometry geometry_of(const std::string& path, const SourceOptions& options = {}) {
  return open_source({path}, options)->description().geometry;
}

SourceOptions with_spacing(double x, double y, double z) {
  SourceOptions options;
  options.spacing_mm = Point3{x, y, z};
  return options;
}

void expect_near(const Matrix3& found, const Matrix3& expected) {
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(found[i], expected[i], 1e-6) << i;
}

void expect_rejected(const std::string& path, const std::vector<std::string>& words,
                     const SourceOptions& options = {}) {
  const Error error = source_error({path}, options);
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  for (const std::string& word : words) {
    EXPECT_TRUE(contains(error.what(), word)) << error.what() << "\nlacks " << word;
  }
}

// ---- MetaImage

void write_meta(const std::string& path, const std::string& matrix) {
  write_file(path, "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 1 2\nElementType = MET_UCHAR\n" +
                       matrix + "\nElementDataFile = LOCAL\n" + std::string(24, '\1'));
}

TEST(SourceAxes, OfMetaImageThatContradictItsSpacingAreRefusedUnlessASpacingIsGiven) {
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  write_meta(path, "TransformMatrix = 2 0 0 0 2 0 0 0 2");
  expect_rejected(path, {"TransformMatrix", "axis x has length 2, 1 expected", "--spacing"});
  const Geometry given = geometry_of(path, with_spacing(3, 4, 5));
  EXPECT_EQ(given.direction, Geometry{}.direction);
  EXPECT_EQ(given.spacing_mm, (Point3{3, 4, 5}));
  write_meta(path, "Rotation = 1 0 0 0 1 0 0 0 0");
  expect_rejected(path, {"Rotation", "axis z has length 0", "repair"}, with_spacing(1, 1, 1));
}

TEST(SourceAxes, OfMetaImageWithinAThousandthOfAGridStayAsTheyAre) {
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

// ---- NRRD

void write_nrrd(const std::string& path, const std::string& lines) {
  write_file(path, "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n" + lines +
                       "\n\n" + std::string(24, '\1'));
}

const std::string kDirections = "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,2,3)";

TEST(SourceAxes, ThatAreShearedAreRefusedInEveryFormat) {
  const TempFolder folder;
  const std::vector<std::string> words = {"sheared", "axes x and y", "63.43495 degrees",
                                          "90 expected", "resample"};
  write_meta(folder.file("a.mha"), "TransformMatrix = 1 0.5 0 0 1 0 0 0 1");
  expect_rejected(folder.file("a.mha"), words);
  write_nrrd(folder.file("a.nrrd"), "space: LPS\nspace directions: (1,0.5,0) (0,1,0) (0,0,2)");
  expect_rejected(folder.file("a.nrrd"), words);
  NiftiSample sample;
  std::string nifti = nifti_header(sample) + std::string(48, '\1');
  nifti.replace(280, 32, bytes_of<float>({1, 0, 0, 0, 0.5F, 1, 0, 0}));
  nifti.replace(252, 2, std::string(2, '\0'));
  write_file(folder.file("a.nii"), nifti);
  expect_rejected(folder.file("a.nii"), words);
  for (const char* name : {"a.mha", "a.nrrd", "a.nii"}) {
    expect_rejected(folder.file(name), {"sheared"}, with_spacing(1, 1, 1));
  }
}

TEST(SourceAxes, OfNrrdWithoutALengthAreRefusedByName) {
  const TempFolder folder;
  write_nrrd(folder.file("a.nrrd"), "space: LPS\nspace directions: (1,0,0) (0,0,0) (0,0,2)");
  expect_rejected(folder.file("a.nrrd"), {"space directions", "axis y has no length"});
}

TEST(SourceAxes, OfNrrdSpacesThatNameLeftAreTurnedToLps) {
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
    EXPECT_TRUE(source->warnings().empty()) << all_of(source->warnings());
    EXPECT_TRUE(contains(source->description().metadata_json, "\"place_known\":true")) << space;
  }
}

TEST(SourceAxes, OfNrrdSpacesThatDoNotNameLeftStayAndAreToldToBeUnplaced) {
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
    const std::string told = all_of(source->warnings());
    EXPECT_TRUE(contains(told, word) && contains(told, "does not say where left is")) << told;
    EXPECT_TRUE(contains(source->description().metadata_json, "\"place_known\":false")) << line;
  }
}

TEST(SourceAxes, OfNrrdSpacesOfAnotherNameAreRefusedWithTheNamesThatAreRead) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  for (const char* space : {"right-posterior-superior", "RPS", "foo", "RAST", "3D-left"}) {
    write_nrrd(path, std::string("space: ") + space + "\n" + kDirections);
    expect_rejected(path, {std::string("\"") + space + "\" is not read", "(LPS)", "(RAS)", "(LAS)",
                           "scanner-xyz"});
    write_nrrd(path, std::string("space: ") + space + "\nspacings: 1 1 2");
    EXPECT_TRUE(contains(all_of(open_source({path}, {})->warnings()), "are left out")) << space;
  }
}

// A volume at the origin along the axes of LPS looks like one of which nothing is known.
TEST(SourceAxes, ThatAreStatedPlaceTheVolumeWhateverTheyAre) {
  const auto metadata = [](const std::string& path) {
    return open_source({path}, {})->description().metadata_json;
  };
  const TempFolder folder;
  NiftiSample nifti;
  nifti.srow = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 2, 0};
  write_file(folder.file("a.nii"), nifti_header(nifti) + std::string(48, 'v'));
  EXPECT_TRUE(contains(metadata(folder.file("a.nii")), "\"place_known\":true"));
  nifti.sform = 0;
  write_file(folder.file("a.nii"), nifti_header(nifti) + std::string(48, 'v'));
  EXPECT_TRUE(contains(metadata(folder.file("a.nii")), "\"place_known\":false"));
  const std::string matrix = "TransformMatrix = 1 0 0 0 1 0 0 0 1\n";
  for (const auto& [lines, expected] : std::vector<std::pair<std::string, std::string>>{
           {matrix + "AnatomicalOrientation = RAI\n", "\"place_known\":true"},
           {matrix + "AnatomicalOrientation = ???\n", "\"place_known\":false"},
           {matrix, ""},
           {"AnatomicalOrientation = RAI\n", ""}}) {
    write_file(folder.file("a.mha"), "ObjectType = Image\nNDims = 3\n" + lines +
                                         "ElementSpacing = 1 1 1\nDimSize = 2 2 2\n"
                                         "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                                         std::string(8, 'v'));
    EXPECT_EQ(contains(metadata(folder.file("a.mha")), "place_known"), !expected.empty()) << lines;
    EXPECT_TRUE(contains(metadata(folder.file("a.mha")), expected)) << lines;
  }
}

TEST(SourceAxes, OfNrrdWithASpaceButNoDirectionsAreLeftOutWithAWarning) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  write_nrrd(path, "space: RAS\nspacings: 2 3 4\nspace origin: (1,2,3)");
  const auto source = open_source({path}, {});
  EXPECT_EQ(source->description().geometry, (Geometry{{0, 0, 0}, {2, 3, 4}}));
  EXPECT_TRUE(contains(all_of(source->warnings()), "orientation and origin are left out"));
}

TEST(SourceAxes, OfNrrdStartWhereAxisMinsSay) {
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
    EXPECT_EQ(contains(all_of(source->warnings()), "taken as the borders"), is_told) << lines;
    EXPECT_TRUE(contains(source->description().metadata_json, "\"place_known\":false")) << lines;
  }
  write_nrrd(path, "spacings: 1 1 2\naxis mins: 10 20");
  expect_rejected(path, {"axis mins: 3 numbers expected, 2 found"});
  write_nrrd(path, "spacings: 1 1 2\naxis mins: 10 20 30\ncenters: cell");
  expect_rejected(path, {"centers has 1 words for 3 axes"});
  write_nrrd(path, "axis mins: 10 20 30");
  EXPECT_TRUE(contains(all_of(open_source({path}, {})->warnings()), "the origin is left out"));
}

TEST(SourceAxes, OfNrrdRunBackwardsWhereASpacingIsNegative) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  write_nrrd(path, "spacings: 1 -1 2");
  const Geometry g = geometry_of(path);
  EXPECT_EQ(g.spacing_mm, (Point3{1, 1, 2}));
  EXPECT_EQ(g.direction, (Matrix3{1, 0, 0, 0, -1, 0, 0, 0, 1}));
}

TEST(SourceAxes, BytesOfNrrdStandInOneOfTwoOrders) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const auto first_byte = [&](const std::string& endian) {
    write_file(path, "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n"
                     "spacings: 1 1 1\nendian: " + endian + "\n\n" +
                         bytes_of(std::vector<std::int16_t>(24, 7), false));
    return voxels_of(*open_source({path}, {}))[0];
  };
  EXPECT_EQ(first_byte("little"), '\7');
  EXPECT_EQ(first_byte("Little"), '\7');
  EXPECT_EQ(first_byte("BIG"), '\0');
  for (const char* endian : {"bigg", "1"}) {
    EXPECT_THROW(first_byte(endian), Error);
    expect_rejected(path, {std::string("endian is \"") + endian + "\"", "little or big expected"});
  }
}

// ---- NIfTI

struct Qform {
  std::array<float, 3> quaternion = {0, 0, 0};
  std::vector<float> pixdim = {1, 1, 1, 2};
  bool has_sform = false;
};

/// A NIfTI-1 header of mm and a qform.
std::string with_qform(const Qform& qform) {
  NiftiSample sample;
  std::string h = nifti_header(sample);
  h.replace(76, 16, bytes_of(qform.pixdim));
  h.replace(252, 2, bytes_of<std::int16_t>({1}));
  if (!qform.has_sform) h.replace(254, 2, std::string(2, '\0'));
  h.replace(256, 12, bytes_of<float>({qform.quaternion[0], qform.quaternion[1],
                                      qform.quaternion[2]}));
  return h + std::string(48, '\1');
}

TEST(SourceAxes, OfAQuaternionThatIsNoRotationAreRefused) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  for (const Qform& qform : {Qform{{0, 0, 1.1F}}, Qform{{0.8F, 0.8F, 0}}, Qform{{0, 0, -1.0001F}},
                             Qform{{0, 0, std::numeric_limits<float>::quiet_NaN()}}}) {
    write_file(path, with_qform(qform));
    expect_rejected(path, {"qform", "b^2 + c^2 + d^2", "at most 1 expected"});
  }
  write_file(path, with_qform({{0, 0, 1.1F}}));
  expect_rejected(path, {"is 1.21,"});
}

TEST(SourceAxes, OfAQuaternionThatRoundingMadeTooLongAreThoseOfAUnitOne) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  write_file(path, with_qform({{0, 0, 1.000004F}}));
  const Geometry g = geometry_of(path);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(g.spacing_mm[axis], axis == 2 ? 2 : 1, 1e-12);
  }
  expect_near(g.direction, {1, 0, 0, 0, 1, 0, 0, 0, 1});
}

TEST(SourceAxes, OfASformCountAlsoWhereTheQformIsNoRotation) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  write_file(path, with_qform({{0, 0, 1.1F}, {1, 2, 3, 4}, true}));
  const auto source = open_source({path}, {});
  EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
  EXPECT_TRUE(contains(all_of(source->warnings()), "is no rotation): the sform is used"));
}

TEST(SourceAxes, OfAQformStayWhereItsSpacingIsMissing) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  std::string bytes = with_qform({{0, 0, 1}, {1, 0.5F, 0.5F, 0}});
  write_file(path, bytes);
  expect_rejected(path, {"give --spacing"});
  const Geometry given = geometry_of(path, with_spacing(1, 1, 3));
  EXPECT_EQ(given.spacing_mm, (Point3{1, 1, 3}));
  expect_near(given.direction, {1, 0, 0, 0, 1, 0, 0, 0, 1});
  // Of two dimensions: the third has no spacing to miss.
  bytes.replace(40, 8, bytes_of<std::int16_t>({2, 4, 6, 1}));
  write_file(path, bytes);
  EXPECT_EQ(geometry_of(path).spacing_mm, (Point3{0.5, 0.5, 1}));
  EXPECT_EQ(geometry_of(path, with_spacing(1, 1, 3)).spacing_mm, (Point3{1, 1, 3}));
}

TEST(SourceAxes, OfASformInTwoDimensionsGetTheNormalOfTheirPlane) {
  const TempFolder folder;
  const std::string path = folder.file("a.nii");
  NiftiSample sample;
  std::string bytes = nifti_header(sample) + std::string(48, '\1');
  bytes.replace(252, 2, std::string(2, '\0'));
  bytes.replace(280, 48, bytes_of<float>({0, 2, 0, 5, 3, 0, 0, 6, 0, 0, 0, 7}));
  write_file(path, bytes);
  expect_rejected(path, {"axis z no length", "repair the header"});
  bytes.replace(40, 8, bytes_of<std::int16_t>({2, 4, 6, 1}));
  write_file(path, bytes);
  const Geometry g = geometry_of(path);
  EXPECT_EQ(g.spacing_mm, (Point3{3, 2, 1}));
  expect_near(g.direction, {0, -1, 0, -1, 0, 0, 0, 0, -1});
}

}  // namespace
}  // namespace octavo::testing
