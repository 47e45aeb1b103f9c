#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "octavo/core/vectors.h"
#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/formats/mesh_formats.h"
#include "octavo/mesh/point_distance.h"

namespace octavo {

namespace {

constexpr std::size_t kStlHeaderBytes = 80;
constexpr std::size_t kStlRecordBytes = 50;

MeshPoint normal_of(const MeshPoint& a, const MeshPoint& b, const MeshPoint& c) {
  const Point3 normal = cross(difference(place_of_point(b), place_of_point(a)),
                              difference(place_of_point(c), place_of_point(a)));
  const double length = std::sqrt(dot(normal, normal));
  if (!(length > 0)) return {0, 0, 0};
  return {static_cast<float>(normal[0] / length), static_cast<float>(normal[1] / length),
          static_cast<float>(normal[2] / length)};
}

}  // namespace

void write_stl(const MeshDescription& described, const Progress& watcher, PendingFile& file) {
  const TriangleMesh& mesh = described.mesh;
  require_countable(mesh.triangles.size(), std::numeric_limits<std::uint32_t>::max(), "triangles",
                    file);
  MeshBytes out(file, watcher);
  // A header that begins with "solid" would be taken for text.
  std::string header = "octavo binary STL " + space_words(described.space);
  header.resize(kStlHeaderBytes, ' ');
  out.text(header);
  out.number(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const MeshTriangle& t : mesh.triangles) {
    const MeshPoint a = in_space(mesh.points[t[0]], described.space);
    const MeshPoint b = in_space(mesh.points[t[1]], described.space);
    const MeshPoint c = in_space(mesh.points[t[2]], described.space);
    const std::array<MeshPoint, 4> vectors = {normal_of(a, b, c), a, b, c};
    std::uint8_t* const record = out.room(kStlRecordBytes);
    std::memcpy(record, vectors.data(), sizeof vectors);
    std::memset(record + sizeof vectors, 0, kStlRecordBytes - sizeof vectors);  // attributes
  }
  out.flush();
}

}  // namespace octavo
