// Axes that headers give: their lengths, their angles, and where the body's left is.
#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

using Matrix3 = std::array<double, 9>;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Geometry geometry_of(const std::string& path, const SourceOptions& options = {}) {
  return open_source({path}, options)->description().geometry;
}

SourceOptions with_spacing(double x, double y, double z) {
  SourceOptions options;
  options.spacing_mm = Point3{x, y, z};
  return options;
}

void expect_refused(const std::string& path, const std::vector<std::string>& words,
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
  expect_refused(path, {"TransformMatrix", "axis x has length 2, 1 expected", "--spacing"});
  const Geometry given = geometry_of(path, with_spacing(3, 4, 5));
  EXPECT_EQ(given.direction, Geometry{}.direction);
  EXPECT_EQ(given.spacing_mm, (Point3{3, 4, 5}));
  write_meta(path, "Rotation = 1 0 0 0 1 0 0 0 0");
  expect_refused(path, {"Rotation", "axis z has length 0", "repair"}, with_spacing(1, 1, 1));
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

}  // namespace
}  // namespace octavo::testing
