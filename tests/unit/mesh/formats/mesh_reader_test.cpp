#include "octavo/mesh/formats/mesh_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "unit/mesh/formats/written_mesh.h"

namespace octavo {
namespace {

using testing::kWritten;
using testing::Parts;
using testing::written;

constexpr std::uint64_t kPlenty = 1 << 20;

MeshReading read_text(MeshFormat format, const std::string& text,
                      std::uint64_t most_bytes = kPlenty) {
  return read_mesh({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, format,
                   most_bytes);
}

std::string bytes_of(float value, bool is_big_endian) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (is_big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// The corners of each triangle: what formats without numbers of points keep.
std::vector<MeshPoint> corners(const TriangleMesh& mesh) {
  std::vector<MeshPoint> all;
  for (const MeshTriangle& t : mesh.triangles) {
    for (const std::uint32_t corner : t) all.push_back(mesh.points[corner]);
  }
  return all;
}

TEST(MeshReader, WhatIsWrittenReadsBack) {
  const Parts with;
  for (const MeshFormat format : {MeshFormat::stl, MeshFormat::ply, MeshFormat::obj}) {
    const std::string plain = written(format, {.mesh = kWritten});
    EXPECT_EQ(corners(read_text(format, plain).mesh), corners(kWritten));
    const std::string full = written(format, {.mesh = kWritten,
                                              .normals = with.normals,
                                              .parts = with.parts,
                                              .space = MeshSpace::ras});
    const MeshReading reading = read_text(format, full);
    EXPECT_EQ(reading.space, MeshSpace::ras);
    EXPECT_EQ(reading.mesh.points.size(), kWritten.points.size());
    EXPECT_EQ(reading.mesh.points[0][0], -kWritten.points[0][0]);
  }
  EXPECT_EQ(read_text(MeshFormat::ply, written(MeshFormat::ply, {.mesh = kWritten})).mesh,
            kWritten);
}

TEST(MeshReader, StlOfTextAndOfBytesAreAlike) {
  std::string text = "solid a vertex of a name\n";
  for (const MeshTriangle& t : kWritten.triangles) {
    text += "  facet normal 0 0 1\n    outer loop\n";
    for (const std::uint32_t corner : t) {
      const MeshPoint& p = kWritten.points[corner];
      text += "      vertex " + std::to_string(p[0]) + "\t+" + std::to_string(p[1] + 10) + " " +
              std::to_string(p[2]) + "e0\r\n";
    }
    text += "    endloop\n  endfacet\n";
  }
  const MeshReading reading = read_text(MeshFormat::stl, text + "endsolid a\n");
  EXPECT_EQ(reading.mesh.points.size(), 4u);
  EXPECT_EQ(reading.mesh.triangles.size(), 2u);
  EXPECT_EQ(reading.mesh.points[reading.mesh.triangles[0][0]], (MeshPoint{0.5f, 8, 3}));
  EXPECT_FALSE(reading.space);

  // A file of bytes that begins as one of text does.
  std::string bytes = written(MeshFormat::stl, {.mesh = kWritten});
  bytes.replace(0, 5, "solid");
  EXPECT_EQ(read_text(MeshFormat::stl, bytes).mesh.triangles.size(), 2u);
}

TEST(MeshReader, PlyIsReadInEveryForm) {
  const std::string head = " 1.0\ncomment SPACE=LPS\nelement other 1\nproperty float a\n"
                           "element vertex 4\nproperty float x\nproperty float y\n"
                           "property float z\nproperty uchar red\nelement face 1\n"
                           "property list uchar uchar vertex_index\nend_header\n";
  const float places[4][3] = {{0, 0, 0}, {1.5f, 0, 0}, {1.5f, 2, 0}, {0, 2, -4}};
  for (const bool is_big_endian : {false, true}) {
    std::string bytes = std::string("ply\nformat binary_") + (is_big_endian ? "big" : "little") +
                        "_endian" + head + bytes_of(7, is_big_endian);
    for (const auto& place : places) {
      for (const float value : place) bytes += bytes_of(value, is_big_endian);
      bytes += '\xff';
    }
    bytes += std::string("\4\0\1\2\3", 5);
    const MeshReading reading = read_text(MeshFormat::ply, bytes);
    // Four corners are a fan of two triangles.
    EXPECT_EQ(reading.mesh.triangles, (std::vector<MeshTriangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(reading.mesh.points[3], (MeshPoint{0, 2, -4}));
    EXPECT_EQ(reading.space, MeshSpace::lps);
  }
  const MeshReading text = read_text(
      MeshFormat::ply, "ply\nformat ascii" + head +
                           "7\n0 0 0 255\n1.5 0 0 255\n1.5 2 0 255\n0 2 -4 255\n4 0 1 2 3\n");
  EXPECT_EQ(text.mesh.triangles.size(), 2u);
}

TEST(MeshReader, ObjCountsCornersFromBothEnds) {
  const MeshReading reading = read_text(
      MeshFormat::obj, "# SPACE=RAS\no a\nv 0 0 0\nv 1 0 0\nvt 0 0\nv 0 1 0\nf 1/1 2//5 -1\n");
  EXPECT_EQ(reading.mesh.triangles, (std::vector<MeshTriangle>{{0, 1, 2}}));
  EXPECT_EQ(reading.space, MeshSpace::ras);
}

TEST(MeshReader, ConcavePolygonsAreFilledAsTheyAre) {
  // 400 of the square millimeters of a chevron; a fan would fill 800.
  const MeshReading obj = read_text(MeshFormat::obj,
                                    "v -20 0 -20\nv 20 0 0\nv -20 0 20\nv 0 0 0\nf 1 2 3 4\n");
  EXPECT_EQ(obj.mesh.triangles, (std::vector<MeshTriangle>{{1, 2, 3}, {3, 0, 1}}));
}

TEST(MeshReader, WhatIsNoMeshIsRejected) {
  const std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 1\n"
                          "property list uchar int vertex_indices\nend_header\n";
  const std::string points = "0 0 0 1 0 0 0 1 0 ";
  const std::string stl = written(MeshFormat::stl, {.mesh = kWritten});
  struct Case {
    MeshFormat format;
    std::string text;
    ErrorKind kind;
    std::string says;
  };
  const Case cases[] = {
      {MeshFormat::stl, "", ErrorKind::truncated, "header"},
      {MeshFormat::stl, stl.substr(0, stl.size() - 1), ErrorKind::truncated, "2 triangles"},
      {MeshFormat::stl, "solid\nvertex 1 2\n", ErrorKind::corrupt, "line 2: a number is missing"},
      {MeshFormat::stl, "solid\nvertex 1 2 3\nendloop\n", ErrorKind::corrupt, "three corners"},
      {MeshFormat::stl, "solid\nsphere\n", ErrorKind::corrupt, "sphere is no word of STL"},
      {MeshFormat::stl, "solid\nvertex 1 2 3\n", ErrorKind::truncated, "within a triangle"},
      {MeshFormat::stl, "solid\nendsolid\n", ErrorKind::source_rejected, "no triangles"},
      {MeshFormat::ply, "PLY", ErrorKind::corrupt, "does not begin"},
      {MeshFormat::ply, "ply\nformat ascii 1.0\n", ErrorKind::truncated, "header"},
      {MeshFormat::ply, "ply\nformat other 1.0\n", ErrorKind::corrupt, "no form"},
      {MeshFormat::ply, "ply\nelement vertex many\n", ErrorKind::corrupt, "without a number"},
      {MeshFormat::ply, "ply\nproperty float x\n", ErrorKind::corrupt, "no element"},
      {MeshFormat::ply, "ply\nend_header\n", ErrorKind::corrupt, "no format"},
      {MeshFormat::ply, ply + points, ErrorKind::truncated, "points and faces"},
      {MeshFormat::ply, ply + points + "3 0 1 3", ErrorKind::corrupt, "none of the 3 points"},
      {MeshFormat::ply, ply + points + "3 0 1 0.5", ErrorKind::corrupt, "none of the 3 points"},
      {MeshFormat::ply, ply + points + "-1", ErrorKind::corrupt, "no length"},
      {MeshFormat::ply, ply + points + "1e9 0 1", ErrorKind::truncated, "points and faces"},
      {MeshFormat::ply, ply + "0 0 nan 1 0 0 0 1 0 3 0 1 2", ErrorKind::source_rejected,
       "point 1"},
      {MeshFormat::ply, ply + "1e10 0 0 1 0 0 0 1 0 3 0 1 2", ErrorKind::source_rejected,
       "expected millimeters"},
      {MeshFormat::ply,
       "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\nend_header\n",
       ErrorKind::corrupt, "no property x"},
      {MeshFormat::ply,
       "ply\nformat ascii 1.0\nelement other 18446744073709551615\nend_header\n",
       ErrorKind::source_rejected, "no triangles"},
      {MeshFormat::obj, "v 0 0 0\nv 1 0 0\nf 1 2 3\n", ErrorKind::corrupt,
       "line 3: a corner at point 3 of 2"},
      {MeshFormat::obj, "v 0 0 0\nf 0 1 1\n", ErrorKind::corrupt, "point 0 of 1"},
      {MeshFormat::obj, "v 0 0 0\nf 1 1\n", ErrorKind::corrupt, "three corners"},
      {MeshFormat::obj, "v 0 x 0\n", ErrorKind::corrupt, "x is no number"},
      {MeshFormat::obj, "f 99999999999999999999 1 1\n", ErrorKind::corrupt, "no number"},
  };
  for (const Case& one : cases) {
    try {
      read_text(one.format, one.text);
      ADD_FAILURE() << one.text;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), one.kind) << one.text;
      EXPECT_NE(std::string(error.what()).find(one.says), std::string::npos) << error.what();
    }
  }
}

TEST(MeshReader, EveryTruncationIsRejectedOrAnotherMesh) {
  for (const MeshFormat format : {MeshFormat::stl, MeshFormat::ply, MeshFormat::obj}) {
    const std::string whole = written(format, {.mesh = kWritten});
    for (std::size_t size = 0; size < whole.size(); ++size) {
      try {
        const TriangleMesh mesh = read_text(format, whole.substr(0, size)).mesh;
        for (const MeshTriangle& t : mesh.triangles) {
          for (const std::uint32_t corner : t) ASSERT_LT(corner, mesh.points.size());
        }
        EXPECT_EQ(format, MeshFormat::obj);
      } catch (const Error&) {
      }
    }
  }
}

TEST(MeshReader, MemoryHasALimit) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "v 0 0 0\n";
  try {
    read_text(MeshFormat::obj, text + "f 1 2 3\n", 10'000);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
}

TEST(MeshReader, PointsNeedNoTrianglesWherePointsAreAskedFor) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  const std::string text = header + "1 2 3\n4 5 6\n";
  const auto bytes_of = [](const std::string& of) {
    return ByteSpan(reinterpret_cast<const std::uint8_t*>(of.data()), of.size());
  };
  const std::vector<MeshPoint> points = read_point_ply(bytes_of(text), 1 << 20).mesh.points;
  EXPECT_EQ(points, (std::vector<MeshPoint>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_THROW(read_mesh(bytes_of(text), MeshFormat::ply, 1 << 20), Error);
  const std::string none = "ply\nformat ascii 1.0\nend_header\n";
  EXPECT_THROW(read_point_ply(bytes_of(none), 1 << 20), Error);
}

}  // namespace
}  // namespace octavo
