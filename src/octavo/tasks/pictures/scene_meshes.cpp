#include "octavo/tasks/pictures/scene_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/mesh/formats/mesh_reader.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/mesh_normals.h"
#include "octavo/render/label_color.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMostMeshBytes = std::uint64_t{4} << 30;
constexpr double kMarkRadiusShare = 0.008;  // of the diagonal of what is shown
constexpr Color kMarkColor = {255, 210, 60};

constexpr int kBallRings = 12;
constexpr int kBallColumns = 24;

Bytes mesh_bytes(const std::string& path, std::uint64_t most_bytes) {
  const std::shared_ptr<const ByteSource> file = open_byte_source(local_storage(), path);
  if (file->size() > most_bytes) {
    throw Error(ErrorKind::limit_exceeded, "the mesh takes more than " + bytes_text(most_bytes))
        .with_field("meshes.memory");
  }
  Bytes bytes(static_cast<std::size_t>(file->size()));
  file->read(0, bytes);
  return bytes;
}

MeshReading read_scene_mesh(const std::string& path, std::uint64_t most_bytes) {
  const auto format = mesh_format_of(path);
  if (!format || !is_mesh_readable(*format)) {
    throw Error(ErrorKind::invalid_argument,
                std::string("a mesh that is drawn is one of ") + readable_mesh_endings(), path)
        .with_field("meshes.format");
  }
  try {
    return read_mesh(mesh_bytes(path, most_bytes), *format, most_bytes);
  } catch (const Error& error) {
    throw error.with_path(path);
  }
}

}  // namespace

MeshBall mesh_ball(const Point3& middle, double radius) {
  // One point at each pole, rings of points between them.
  MeshBall ball;
  for (int ring = 0; ring <= kBallRings; ++ring) {
    const double polar = std::numbers::pi * ring / kBallRings;
    const bool is_pole = ring == 0 || ring == kBallRings;
    for (int column = 0; column < (is_pole ? 1 : kBallColumns); ++column) {
      const double around = 2 * std::numbers::pi * column / kBallColumns;
      const Point3 normal{std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                          std::cos(polar)};
      MeshPoint point;
      MeshPoint outward;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        outward[axis] = static_cast<float>(normal[axis]);
        point[axis] = static_cast<float>(middle[axis] + radius * normal[axis]);
      }
      ball.mesh.points.push_back(point);
      ball.normals.push_back(outward);
    }
  }
  const auto number = [](int ring, int column) {
    if (ring == 0) return std::uint32_t{0};
    const int in_ring = ring == kBallRings ? 0 : column % kBallColumns;
    return static_cast<std::uint32_t>(1 + (ring - 1) * kBallColumns + in_ring);
  };
  for (int ring = 0; ring < kBallRings; ++ring) {
    for (int column = 0; column < kBallColumns; ++column) {
      const std::uint32_t a = number(ring, column);
      const std::uint32_t b = number(ring, column + 1);
      const std::uint32_t c = number(ring + 1, column);
      const std::uint32_t d = number(ring + 1, column + 1);
      if (ring > 0) ball.mesh.triangles.push_back({a, c, b});
      if (ring + 1 < kBallRings) ball.mesh.triangles.push_back({b, c, d});
    }
  }
  return ball;
}

SceneMeshes::SceneMeshes(const RenderOptions& options, const Geometry& geometry, const Box& shown,
                         const TaskContext& context) {
  for (const AskedMesh& asked : options.meshes) {
    add_mesh(asked, context);
    warn_beside(geometry, shown, asked.path, context);
  }
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double side = geometry.spacing_mm[static_cast<std::size_t>(axis)] *
                        static_cast<double>(shown.size()[axis]);
    squared += side * side;
  }
  for (const AskedMark& mark : options.marks) {
    MeshBall ball = mesh_ball(mark.at_mm, kMarkRadiusShare * std::sqrt(squared));
    surfaces_.push_back({std::move(ball.mesh), std::move(ball.normals),
                         mark.color.value_or(kMarkColor), 1, ""});
    warn_beside(geometry, shown, mark.text.empty() ? "a mark" : "the mark " + escaped(mark.text),
                context);
  }
}

std::vector<RayMesh> SceneMeshes::meshes() const {
  std::vector<RayMesh> meshes;
  for (const SceneSurface& surface : surfaces_) {
    meshes.push_back({&surface.mesh, surface.normals, surface.color, surface.opacity});
  }
  return meshes;
}

std::uint64_t SceneMeshes::memory_bytes() const {
  std::uint64_t bytes = 0;
  for (const SceneSurface& surface : surfaces_) {
    bytes += surface.mesh.memory_bytes() + surface.normals.capacity() * sizeof(MeshPoint);
  }
  return bytes;
}

std::vector<LegendRow> SceneMeshes::legend() const {
  std::vector<LegendRow> rows;
  for (const SceneSurface& surface : surfaces_) {
    if (!surface.name.empty()) rows.push_back({surface.color, surface.name});
  }
  return rows;
}

void SceneMeshes::add_mesh(const AskedMesh& asked, const TaskContext& context) {
  std::uint64_t most = kMostMeshBytes;
  if (context.max_memory_bytes != 0) most = std::min(most, context.max_memory_bytes / 4);
  MeshReading reading = read_scene_mesh(asked.path, most - std::min(most, memory_bytes()));
  turn_to_lps(reading);
  SceneSurface surface;
  context.on_threads([&] {
    surface.normals = area_normals(reading.mesh);
    const std::uint64_t open = check_mesh(reading.mesh).open_sides;
    if (open > 0) {
      context.note(fmt::format("{}: is open at {} sides of triangles; both of its sides are drawn",
                               asked.path, count_text(static_cast<std::int64_t>(open))));
    }
  });
  surface.mesh = std::move(reading.mesh);
  surface.color =
      asked.color.value_or(label_color(static_cast<std::int64_t>(surfaces_.size()) + 1));
  surface.opacity = asked.opacity;
  surface.name = base_name_of(asked.path);
  surfaces_.push_back(std::move(surface));
}

/// Warns where the last surface has no point in what is shown.
void SceneMeshes::warn_beside(const Geometry& geometry, const Box& shown, const std::string& name,
                              const TaskContext& context) const {
  Point3 low;
  Point3 high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const MeshPoint& point : surfaces_.back().mesh.points) {
    const Point3 at = geometry.to_index({point[0], point[1], point[2]});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], at[axis]);
      high[axis] = std::max(high[axis], at[axis]);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const bool is_beside = high[i] < static_cast<double>(shown.lo[axis]) - 0.5 ||
                           low[i] > static_cast<double>(shown.hi[axis]) - 0.5;
    if (!is_beside) continue;
    context.warn(fmt::format("{}: lies beside the volume: along its {} axis from {} to {}, which "
                             "runs from {} to {}",
                             name, "xyz"[axis], number_text(std::round(low[i])),
                             number_text(std::round(high[i])), shown.lo[axis],
                             shown.hi[axis] - 1));
    return;
  }
}

}  // namespace octavo
