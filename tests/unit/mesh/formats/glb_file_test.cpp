#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "unit/mesh/formats/written_mesh.h"

namespace octavo {
namespace {

using nlohmann::json;
using testing::kWritten;
using testing::number_in;
using testing::Parts;
using testing::written;

/// A GLB file, read by the words of the specification of glTF and of EXT_meshopt_compression.
class ReadGlb {
 public:
  explicit ReadGlb(const std::string& file) {
    EXPECT_EQ(file.substr(0, 4), "glTF");
    EXPECT_EQ(number_in<std::uint32_t>(file, 4), 2u);
    EXPECT_EQ(number_in<std::uint32_t>(file, 8), file.size());
    const auto json_bytes = number_in<std::uint32_t>(file, 12);
    EXPECT_EQ(file.substr(16, 4), "JSON");
    description = json::parse(file.substr(20, json_bytes));
    const std::size_t at = 20 + json_bytes;
    EXPECT_EQ(at % 4, 0u);
    if (at == file.size()) return;
    EXPECT_EQ(file.substr(at + 4, 4), std::string("BIN\0", 4));
    bytes_ = file.substr(at + 8);
    EXPECT_EQ(number_in<std::uint32_t>(file, at), bytes_.size());
  }

  /// The bytes of an accessor, with the stride of its view.
  std::string array(std::size_t accessor) const {
    const auto place = description["accessors"][accessor]["bufferView"].get<std::size_t>();
    const json& view = description["bufferViews"][place];
    if (!view.contains("extensions")) {
      return bytes_.substr(view["byteOffset"], view["byteLength"]);
    }
    const json& meshopt = view["extensions"]["EXT_meshopt_compression"];
    const std::string packed = bytes_.substr(meshopt["byteOffset"], meshopt["byteLength"]);
    const auto* data = reinterpret_cast<const unsigned char*>(packed.data());
    const std::size_t count = meshopt["count"];
    const std::size_t stride = meshopt["byteStride"];
    std::string array(count * stride, '\0');
    if (meshopt["mode"] == "TRIANGLES") {
      EXPECT_EQ(meshopt_decodeIndexBuffer(array.data(), count, stride, data, packed.size()), 0);
      return array;
    }
    EXPECT_EQ(meshopt_decodeVertexBuffer(array.data(), count, stride, data, packed.size()), 0);
    if (meshopt.value("filter", "") == "OCTAHEDRAL") {
      meshopt_decodeFilterOct(array.data(), count, stride);
    }
    return array;
  }

  std::size_t accessor(std::size_t mesh, const std::string& attribute) const {
    const json& primitive = description["meshes"][mesh]["primitives"][0];
    return attribute == "indices" ? primitive["indices"] : primitive["attributes"][attribute];
  }

  /// The corners of a triangle of a mesh, in the coordinates of its node's parent, the one with the
  /// smallest x first.
  std::array<std::array<double, 3>, 3> corners(std::size_t mesh, std::size_t triangle) const {
    const std::string numbers = array(accessor(mesh, "indices"));
    const std::size_t positions = accessor(mesh, "POSITION");
    const std::string places = array(positions);
    const bool is_short = description["accessors"][positions]["componentType"] == 5123;
    const json& node = description["nodes"][1 + mesh];
    std::array<std::array<double, 3>, 3> found;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t point = number_in<std::uint16_t>(numbers, 2 * (3 * triangle + k));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        found[k][axis] = is_short ? node["translation"][axis].get<double>() +
                                        node["scale"][axis].get<double>() *
                                            number_in<std::uint16_t>(places, 8 * point + 2 * axis)
                                  : number_in<float>(places, 12 * point + 4 * axis);
      }
    }
    std::rotate(found.begin(), std::min_element(found.begin(), found.end()), found.end());
    return found;
  }

  json description;

 private:
  std::string bytes_;
};

void expect_corners(const ReadGlb& glb, std::size_t mesh, std::vector<std::uint32_t> points,
                    double tolerance) {
  const auto corners = glb.corners(mesh, 0);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(corners[k][axis], kWritten.points[points[k]][axis], tolerance);
    }
  }
}

TEST(GlbFile, HasANodeWithNameColorAndTrianglesForEachPart) {
  const Parts with;
  for (const bool is_plain : {false, true}) {
    const ReadGlb glb(written(MeshFormat::glb, {.mesh = kWritten,
                                                .normals = with.normals,
                                                .parts = with.parts,
                                                .is_plain = is_plain}));
    const json& nodes = glb.description["nodes"];
    EXPECT_EQ(nodes[1]["name"], with.parts[0].name);
    EXPECT_EQ(nodes[2]["name"], "label 300");
    EXPECT_EQ(nodes[2]["extras"]["label"], 300);
    expect_corners(glb, 0, {2, 1, 0}, 0);
    expect_corners(glb, 1, {3, 0, 1}, 0);
    const json& color =
        glb.description["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
    EXPECT_EQ(color, json::array({0.0003, 0.0006, 1.0, 1}));
    EXPECT_EQ(glb.description.contains("extensionsRequired"), !is_plain);
  }
}

TEST(GlbFile, TurnsPatientsUprightInMeters) {
  const ReadGlb glb(written(MeshFormat::glb, {.mesh = kWritten}));
  const json& root = glb.description["nodes"][0];
  const std::array<double, 16> matrix = root["matrix"];
  // Left, back and top of a patient, mm.
  const std::array<std::array<double, 3>, 3> expected = {
      {{0.001, 0, 0}, {0, 0, -0.001}, {0, 0.001, 0}}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row) {
      EXPECT_EQ(matrix[4 * axis + row], expected[axis][row]);
    }
  }
  EXPECT_EQ(root["children"], json::array({1}));
}

TEST(GlbFile, PointsOfAGridHave16Bits) {
  TriangleMesh mesh = kWritten;
  const PointGrid grid = PointGrid::around(mesh, 0.5);
  grid.snap(mesh);
  const ReadGlb glb(written(MeshFormat::glb, {.mesh = mesh, .grid = grid}));
  const json& accessor = glb.description["accessors"][glb.accessor(0, "POSITION")];
  EXPECT_EQ(accessor["componentType"], 5123);
  EXPECT_EQ(glb.description["extensionsRequired"],
            json::array({"KHR_mesh_quantization", "EXT_meshopt_compression"}));
  for (std::size_t i = 0; i < 2; ++i) {
    const auto corners = glb.corners(0, i);
    EXPECT_NEAR(corners[0][0], 0, 1e-4);
  }
}

TEST(GlbFile, NormalsAreUnitVectors) {
  const Parts with;
  const ReadGlb glb(written(MeshFormat::glb, {.mesh = kWritten, .normals = with.normals}));
  const std::string normals = glb.array(glb.accessor(0, "NORMAL"));
  ASSERT_EQ(normals.size(), 16u);
  std::vector<std::array<int, 3>> found;
  for (std::size_t i = 0; i < 4; ++i) {
    found.push_back({normals[4 * i], normals[4 * i + 1], normals[4 * i + 2]});
  }
  for (const MeshPoint& normal : with.normals) {
    const std::array<int, 3> expected = {static_cast<int>(127 * normal[0]),
                                         static_cast<int>(127 * normal[1]),
                                         static_cast<int>(127 * normal[2])};
    EXPECT_EQ(std::count(found.begin(), found.end(), expected), 1);
  }
}

TEST(GlbFile, HoldsCommentsAndTheReport) {
  const std::vector<std::string> comments = {"a \"b\"\n"};
  const ReadGlb glb(written(MeshFormat::glb, {.mesh = kWritten,
                                              .comments = comments,
                                              .report = "{\"closed\":true}"}));
  const json& extras = glb.description["asset"]["extras"];
  EXPECT_EQ(extras["comments"], json::array({"a \"b\"\n"}));
  EXPECT_EQ(extras["report"]["closed"], true);
}

TEST(GlbFile, WithoutTrianglesIsAScene) {
  const TriangleMesh empty;
  const ReadGlb glb(written(MeshFormat::glb, {.mesh = empty}));
  EXPECT_EQ(glb.description["nodes"].size(), 1u);
  EXPECT_FALSE(glb.description.contains("meshes"));
  EXPECT_FALSE(glb.description.contains("buffers"));
  EXPECT_FALSE(glb.description.contains("extensionsUsed"));
}

TEST(PointGrid, MovesPointsByNoMoreThanItSays) {
  const TriangleMesh mesh = {{{-100, 3, 1e4f}, {250.7f, 0.1f, 1e4f + 7}, {0.33f, 3.3f, 10001}}, {}};
  const PointGrid grid = PointGrid::around(mesh, 0.25);
  EXPECT_NEAR(grid.step_mm, 351.2 / 65535, 1e-6);
  TriangleMesh snapped = mesh;
  grid.snap(snapped);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double moved = double{snapped.points[i][axis]} - mesh.points[i][axis];
      squared += moved * moved;
    }
    EXPECT_LE(std::sqrt(squared), grid.largest_move_mm());
    EXPECT_EQ(grid.place_of(grid.numbers_of(snapped.points[i])), snapped.points[i]);
  }
}

TEST(PointGrid, OfOnePlaceIsNotEmpty) {
  const TriangleMesh mesh = {{{1, 2, 3}}, {}};
  EXPECT_GT(PointGrid::around(mesh, 0).step_mm, 0);
}

}  // namespace
}  // namespace octavo
