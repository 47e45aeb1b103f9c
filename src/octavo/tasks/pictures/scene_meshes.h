// Surfaces of files and marks beside a volume in a picture of rays.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/render/annotation.h"
#include "octavo/render/rays/ray_meshes.h"
#include "octavo/tasks/pictures/render.h"

namespace octavo {

/// A ball of triangles, and the normals of its points.
struct MeshBall {
  TriangleMesh mesh;
  std::vector<MeshPoint> normals;
};

MeshBall mesh_ball(const Point3& middle, double radius);

class SceneMeshes {
 public:
  /// Reads the meshes of the options, a quarter of the memory limit at most, and makes a ball of
  /// each mark.
  /// geometry, shown  of the level that is drawn: what lies beside it is warned of
  /// Throws  Error{invalid_argument} for a name without a known ending; what read_mesh and reading
  ///         throw, with the path
  SceneMeshes(const RenderOptions& options, const Geometry& geometry, const Box& shown,
              const TaskContext& context);

  bool is_empty() const { return surfaces_.empty(); }
  /// Views of this.
  std::vector<RayMesh> meshes() const;
  std::uint64_t memory_bytes() const;
  std::vector<LegendRow> legend() const;

 private:
  struct SceneSurface {
    TriangleMesh mesh;
    std::vector<MeshPoint> normals;
    Color color{};
    double opacity = 1;
    std::string name;
  };

  void add_mesh(const AskedMesh& asked, const TaskContext& context);
  void warn_beside(const Geometry& geometry, const Box& shown, const std::string& name,
                   const TaskContext& context) const;

  std::vector<SceneSurface> surfaces_;
};

}  // namespace octavo
