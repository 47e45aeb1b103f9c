// Meshes of strangers: the first byte says the format. Corners are points, points are finite, and
// a mesh that is written as PLY reads the same.
#include <cmath>
#include <string>

#include "fuzz/fuzz_target.h"
#include "octavo/mesh/formats/mesh_reader.h"

namespace {

using namespace octavo;
using fuzz::require;

constexpr std::uint64_t kMostBytes = 1 << 24;

template <class T>
void append(std::string& text, const T& value) {
  text.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string ply_of(const TriangleMesh& mesh) {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                     std::to_string(mesh.points.size()) +
                     "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                     std::to_string(mesh.triangles.size()) +
                     "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (const MeshPoint& point : mesh.points) append(text, point);
  for (const MeshTriangle& triangle : mesh.triangles) {
    text += '\3';
    append(text, triangle);
  }
  return text;
}

void check_mesh(const TriangleMesh& mesh) {
  require(!mesh.triangles.empty(), "a mesh without triangles");
  for (const MeshPoint& point : mesh.points) {
    for (const float part : point) {
      require(std::abs(part) <= kFarthestPointMm, "a point that is not finite");
    }
  }
  for (const MeshTriangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      require(corner < mesh.points.size(), "a corner that is no point");
    }
  }
  const std::string text = ply_of(mesh);
  const MeshReading again = read_mesh(
      {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, MeshFormat::ply,
      4 * kMostBytes);
  require(again.mesh == mesh, "another mesh");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  constexpr MeshFormat kFormats[] = {MeshFormat::stl, MeshFormat::ply, MeshFormat::obj};
  const MeshFormat format = kFormats[input.take<std::uint8_t>() % 3];
  const std::vector<std::uint8_t> bytes = input.take_bytes(input.left());
  fuzz::expect_error_or_success([&] { check_mesh(read_mesh(bytes, format, kMostBytes).mesh); });
  return 0;
}
