#include "octavo/mesh/formats/mesh_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <sstream>

#include "octavo/core/error.h"
#include "support/stopping_progress.h"
#include "unit/mesh/formats/written_mesh.h"

namespace octavo {
namespace {

using testing::kWritten;
using testing::Parts;
using testing::written;

std::string written(MeshFormat format, MeshSpace space) {
  const std::vector<std::string> comments = {"made of nothing"};
  return written(format, {.mesh = kWritten, .comments = comments, .space = space});
}

MeshPoint point_in(const std::string& bytes, std::size_t at) {
  MeshPoint point;
  std::memcpy(&point, bytes.data() + at, sizeof point);
  return point;
}

TEST(MeshFile, StlHoldsNormalsAndCornersOfEveryTriangle) {
  const std::string bytes = written(MeshFormat::stl, MeshSpace::lps);
  ASSERT_EQ(bytes.size(), 84 + 2 * 50u);
  EXPECT_NE(bytes.find("SPACE=LPS"), std::string::npos);
  EXPECT_FALSE(bytes.starts_with("solid"));
  EXPECT_EQ(bytes[80], 2);
  EXPECT_EQ(point_in(bytes, 84 + 12), kWritten.points[0]);
  EXPECT_EQ(point_in(bytes, 84 + 24), kWritten.points[2]);
  EXPECT_EQ(point_in(bytes, 84 + 50 + 36), kWritten.points[3]);
  const MeshPoint normal = point_in(bytes, 84);
  EXPECT_NEAR(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2], 1, 1e-6);
}

TEST(MeshFile, RasTurnsTwoAxesRound) {
  const std::string bytes = written(MeshFormat::stl, MeshSpace::ras);
  EXPECT_NE(bytes.find("SPACE=RAS"), std::string::npos);
  EXPECT_EQ(point_in(bytes, 84 + 12), (MeshPoint{-0.5f, 2, 3}));
}

TEST(MeshFile, PlyHoldsPointsAndNumbers) {
  const std::string bytes = written(MeshFormat::ply, MeshSpace::lps);
  EXPECT_NE(bytes.find("comment made of nothing\n"), std::string::npos);
  EXPECT_NE(bytes.find("element vertex 4\n"), std::string::npos);
  EXPECT_NE(bytes.find("element face 2\n"), std::string::npos);
  const std::string end = "end_header\n";
  const std::size_t data = bytes.find(end) + end.size();
  ASSERT_EQ(bytes.size(), data + 4 * 12 + 2 * 13u);
  EXPECT_EQ(point_in(bytes, data + 12), kWritten.points[1]);
  EXPECT_EQ(bytes[data + 48], 3);
  MeshTriangle last;
  std::memcpy(&last, bytes.data() + data + 48 + 14, sizeof last);
  EXPECT_EQ(last, kWritten.triangles[1]);
}

TEST(MeshFile, ObjCountsFromOneAndKeepsAllDigits) {
  const std::string text = written(MeshFormat::obj, MeshSpace::lps);
  EXPECT_NE(text.find("# made of nothing\n"), std::string::npos);
  EXPECT_NE(text.find("v 0.5 -2 3\nv 1 0 0.1\nv 0 1e-07 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n"),
            std::string::npos);
}

TEST(MeshFile, ObjTurnedRoundHasNoNegativeZero) {
  const std::string text = written(MeshFormat::obj, MeshSpace::ras);
  EXPECT_NE(text.find("v -0.5 2 3\nv -1 0 0.1\nv 0 -1e-07 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n"),
            std::string::npos);
}

TEST(MeshFile, PlyHoldsNormalsAndTheLabelOfEveryTriangle) {
  const Parts with;
  const std::string bytes =
      written(MeshFormat::ply, {.mesh = kWritten, .normals = with.normals, .parts = with.parts});
  EXPECT_NE(bytes.find("comment label 7 left lung \"<&\xc3\xa4>\"\n"), std::string::npos);
  const std::string end = "end_header\n";
  const std::size_t data = bytes.find(end) + end.size();
  ASSERT_EQ(bytes.size(), data + 4 * 24 + 2 * 17u);
  EXPECT_EQ(point_in(bytes, data + 3 * 24 + 12), with.normals[3]);
  std::int32_t label = 0;
  std::memcpy(&label, bytes.data() + bytes.size() - 4, 4);
  EXPECT_EQ(label, 300);
}

TEST(MeshFile, PlyHoldsPairsOfLabelsInPlaceOfParts) {
  const Parts with;
  const std::string bytes =
      written(MeshFormat::ply, {.mesh = kWritten, .pairs = with.pairs, .parts = with.parts});
  EXPECT_NE(bytes.find("property int inside\nproperty int outside\n"), std::string::npos);
  EXPECT_EQ(bytes.find("property int label\n"), std::string::npos);
  std::array<std::int32_t, 2> pair{};
  std::memcpy(&pair, bytes.data() + bytes.size() - 8, 8);
  EXPECT_EQ(pair, (std::array<std::int32_t, 2>{300, 0}));
}

TEST(MeshFile, PlyHoldsLabelsOf32BitsAndRejectsOthers) {
  constexpr std::int64_t kFirst = std::numeric_limits<std::int32_t>::min();
  std::vector<MeshPart> parts = {{"", kFirst, {}, 0, 2}};
  const std::string bytes = written(MeshFormat::ply, {.mesh = kWritten, .parts = parts});
  EXPECT_EQ(testing::number_in<std::int32_t>(bytes, bytes.size() - 4), kFirst);
  for (const std::int64_t label : {kFirst - 1, -kFirst, std::int64_t{1} << 40}) {
    parts[0].label = label;
    EXPECT_THROW(written(MeshFormat::ply, {.mesh = kWritten, .parts = parts}), Error) << label;
  }
}

TEST(MeshFile, ObjJoinsNoLinesThatEndWithABackslash) {
  const std::vector<MeshPart> parts = {{"left\\", 7, {}, 0, 2}};
  const std::vector<std::string> comments = {"of m\\"};
  const std::string text =
      written(MeshFormat::obj, {.mesh = kWritten, .parts = parts, .comments = comments});
  EXPECT_NE(text.find("o left_\ng left_\nf "), std::string::npos);
  EXPECT_NE(text.find("# of m_\n"), std::string::npos);
  EXPECT_EQ(text.find('\\'), std::string::npos);
}

TEST(MeshFile, ObjNamesThatAreAlikeGetTheNumbersOfTheirLabels) {
  const TriangleMesh mesh = {kWritten.points, std::vector<MeshTriangle>(6, MeshTriangle{0, 2, 1})};
  const std::vector<MeshPart> parts = {{"Liver", 1, {}, 0, 1}, {"a#b", 2, {}, 1, 2},
                                       {"a b", 3, {}, 2, 3},   {"Liver", 4, {}, 3, 4},
                                       {"a_b_2", 5, {}, 4, 5}, {"Liver", 1, {}, 5, 6}};
  const std::string text = written(MeshFormat::obj, {.mesh = mesh, .parts = parts});
  for (const std::string name :
       {"Liver_1_1", "a_b_2_2", "a_b_3", "Liver_4", "a_b_2_5", "Liver_1_6"}) {
    EXPECT_NE(text.find("o " + name + "\ng " + name + "\nf 1 3 2\n"), std::string::npos) << name;
  }
}

TEST(MeshFile, CoordinatesAreWithinAMillionthOfTheirFloatsForReadersInDouble) {
  const TriangleMesh mesh = {
      {{1000001.375f, -100.1f, 16}, {15.9f, 1e-7f, 123456.789f}, {3e38f, 1e20f, -16.000002f}}, {}};
  std::istringstream lines(written(MeshFormat::obj, {.mesh = mesh}));
  std::string line;
  std::getline(lines, line);
  for (const MeshPoint& point : mesh.points) {
    std::getline(lines, line);
    std::istringstream words(line.substr(2));
    for (const float value : point) {
      std::string word;
      words >> word;
      EXPECT_NEAR(std::stod(word), value, 1e-6) << word;
      EXPECT_EQ(std::stof(word), value) << word;
    }
  }
  EXPECT_NE(written(MeshFormat::obj, {.mesh = mesh}).find("v 1000001.375 -100.099998 16\n"),
            std::string::npos);
}

TEST(MeshFile, ObjHasAnObjectOfOneWordForEachPartAndAGroupForEachPair) {
  const Parts with;
  const std::string parts =
      written(MeshFormat::obj, {.mesh = kWritten, .normals = with.normals, .parts = with.parts});
  EXPECT_NE(parts.find("vn 0 -1 0\no left_lung_\"<&\xc3\xa4>\"\ng left_lung_\"<&\xc3\xa4>\"\n"
                       "f 1//1 3//3 2//2\n"
                       "o label_300\ng label_300\nf 1//1 2//2 4//4\n"),
            std::string::npos);
  const std::string pairs = written(MeshFormat::obj, {.mesh = kWritten, .pairs = with.pairs});
  EXPECT_NE(pairs.find("g label_7_to_300\nf 1 3 2\ng label_300_to_0\nf 1 2 4\n"),
            std::string::npos);
}

TEST(MeshFile, CommentsAndReportsAreOneLine) {
  const std::vector<std::string> comments = {"a\nelement vertex 9"};
  const MeshDescription described{
      .mesh = kWritten, .comments = comments, .report = "{\"closed\":true}"};
  EXPECT_NE(written(MeshFormat::ply, described)
                .find("comment a element vertex 9\ncomment report {\"closed\":true}\n"),
            std::string::npos);
  EXPECT_NE(written(MeshFormat::obj, described)
                .find("# a element vertex 9\n# report {\"closed\":true}\n"),
            std::string::npos);
}

// MeshLab rejects headers of PLY with lines of 512 bytes.
TEST(MeshFile, HeadersOfPlyHaveShortLines) {
  std::string report = "{\"name\":\"";
  for (int i = 0; i < 400; ++i) report += "\xc3\xa4,";
  report += "\"}";
  MeshPart part{.name = std::string(700, 'n'), .label = 7, .begin = 0, .end = 2};
  const std::vector<std::string> comments = {std::string(600, 'c')};
  const std::string file = written(MeshFormat::ply, {.mesh = kWritten,
                                                     .parts = {&part, 1},
                                                     .comments = comments,
                                                     .report = report});
  std::istringstream lines(file.substr(0, file.find("end_header")));
  const std::string start = "comment report ";
  std::string joined;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 250u);
    EXPECT_NE(static_cast<unsigned char>(line.back()), 0xc3);
    if (line.starts_with(start)) joined += line.substr(start.size());
  }
  EXPECT_EQ(joined, report);
}

TEST(MeshFile, AllFormatsButStlHaveNormals) {
  EXPECT_FALSE(has_normals(MeshFormat::stl));
  EXPECT_TRUE(has_normals(MeshFormat::ply));
  EXPECT_TRUE(has_normals(MeshFormat::obj));
}

TEST(MeshFile, FormatsAreKnownByTheirEndings) {
  EXPECT_EQ(mesh_format_of("a.b.stl"), MeshFormat::stl);
  EXPECT_EQ(mesh_format_of("a.ply"), MeshFormat::ply);
  EXPECT_EQ(mesh_format_of("A.Ply"), MeshFormat::ply);
  EXPECT_EQ(mesh_format_of("a.obj"), MeshFormat::obj);
  EXPECT_EQ(mesh_format_of("a.VTP"), MeshFormat::vtp);
  EXPECT_EQ(mesh_format_of("a.glb"), MeshFormat::glb);
  EXPECT_EQ(mesh_format_of("a.3mf"), MeshFormat::three_mf);
  EXPECT_EQ(mesh_format_of("a.off"), std::nullopt);
}

TEST(MeshFile, AFailureLeavesNothing) {
  for (const MeshFormat format :
       {MeshFormat::stl, MeshFormat::ply, MeshFormat::obj, MeshFormat::glb, MeshFormat::vtp,
        MeshFormat::three_mf}) {
    const auto write = [format](testing::MemoryStorage& storage) {
      PendingFile file(storage, "mesh");
      write_mesh({.mesh = kWritten}, format, NoProgress(), file);
      file.seal();
      file.publish(false);
    };
    testing::MemoryStorage counted;
    write(counted);
    for (std::size_t call = 1; call <= counted.calls.size(); ++call) {
      testing::MemoryStorage storage;
      storage.fail_at = call;
      try {
        write(storage);
      } catch (const Error&) {
        EXPECT_TRUE(storage.files.empty()) << "call " << call;
      }
    }
  }
}

TEST(MeshFile, WritingEndsWhenAskedTo) {
  for (const MeshFormat format :
       {MeshFormat::stl, MeshFormat::ply, MeshFormat::obj, MeshFormat::glb, MeshFormat::vtp,
        MeshFormat::three_mf}) {
    testing::MemoryStorage storage;
    try {
      PendingFile file(storage, "mesh");
      write_mesh({.mesh = kWritten}, format, testing::StoppingProgress(), file);
      ADD_FAILURE() << "written";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled);
    }
    EXPECT_TRUE(storage.files.empty());
  }
}

TEST(MeshFile, NoTrianglesAreAFile) {
  const TriangleMesh empty;
  EXPECT_EQ(written(MeshFormat::stl, {.mesh = empty}).size(), 84u);
  EXPECT_NE(written(MeshFormat::ply, {.mesh = empty}).find("element face 0\n"), std::string::npos);
  EXPECT_EQ(written(MeshFormat::obj, {.mesh = empty}), "# SPACE=LPS UNIT=mm\n");
  EXPECT_NE(written(MeshFormat::vtp, {.mesh = empty}).find("NumberOfPolys=\"0\""),
            std::string::npos);
}

}  // namespace
}  // namespace octavo
