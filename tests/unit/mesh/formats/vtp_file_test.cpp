#include <gtest/gtest.h>

#include "unit/mesh/formats/written_mesh.h"

namespace octavo {
namespace {

using testing::kWritten;
using testing::number_in;
using testing::Parts;
using testing::written;

/// Where the array of this name begins, behind its size; its size is checked.
std::size_t array_at(const std::string& file, const std::string& name, std::uint64_t bytes) {
  const std::string element = "Name=\"" + name + "\"";
  const std::size_t found = file.find(element);
  EXPECT_NE(found, std::string::npos) << name;
  const std::string offset = "offset=\"";
  const std::size_t digits = file.find(offset, found) + offset.size();
  const std::string begin = "encoding=\"raw\">\n_";
  const std::size_t at =
      file.find(begin) + begin.size() + static_cast<std::size_t>(std::stoul(file.substr(digits)));
  EXPECT_EQ(number_in<std::uint64_t>(file, at), bytes) << name;
  return at + 8;
}

TEST(VtpFile, HoldsPointsNormalsAndTriangles) {
  const Parts with;
  const std::string file =
      written(MeshFormat::vtp, {.mesh = kWritten, .normals = with.normals, .parts = with.parts});
  EXPECT_EQ(number_in<MeshPoint>(file, array_at(file, "points", 48) + 12), kWritten.points[1]);
  EXPECT_EQ(number_in<MeshPoint>(file, array_at(file, "normals", 48) + 36), with.normals[3]);
  EXPECT_EQ(number_in<MeshTriangle>(file, array_at(file, "connectivity", 24) + 12),
            kWritten.triangles[1]);
  EXPECT_EQ(number_in<std::int32_t>(file, array_at(file, "offsets", 8) + 4), 6);
  EXPECT_EQ(number_in<std::int64_t>(file, array_at(file, "label", 16) + 8), 300);
  EXPECT_TRUE(file.ends_with("\n</AppendedData>\n</VTKFile>\n"));
}

TEST(VtpFile, HoldsPairsOfLabels) {
  const Parts with;
  const std::string file = written(MeshFormat::vtp, {.mesh = kWritten, .pairs = with.pairs});
  EXPECT_EQ(number_in<LabelPair>(file, array_at(file, "inside_outside", 32) + 16), with.pairs[1]);
}

TEST(VtpFile, TextsAreCharacterCodes) {
  const std::vector<std::string> comments = {"a<"};
  const std::string file = written(MeshFormat::vtp, {.mesh = kWritten, .comments = comments});
  EXPECT_NE(file.find("Name=\"comments\" NumberOfTuples=\"2\" format=\"ascii\">\n97 60 0\n"),
            std::string::npos);
}

}  // namespace
}  // namespace octavo
