// How much of the lamp's light comes past surfaces of triangles to a place: hard shadows.
//
//          lamp                    triangles are sorted into the cells of a grid across the light;
//         | | | |                  a place asks those of its cell which of them lie before it
//       --+-+-+-+--  triangles
//         | | x |    a place
//
// Invariants
//   A place on an edge lies in one of the two triangles that share it.
// Consequences
//   A shadow ends where its triangle ends, however large the cells; a surface has no seams of
//   light.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_meshes.h"

namespace octavo {

class MeshShadow {
 public:
  struct Options {
    Geometry geometry;      ///< of the grid whose samples rays cross
    Point3 toward_light{};  ///< a unit vector in world space
    double nearest_mm = 0;  ///< nearer to a place nothing throws a shadow on it
    std::uint64_t memory_bytes = std::uint64_t{1} << 30;  ///< for lists of triangles
  };

  /// meshes  must outlive it
  /// Throws  Error{limit_exceeded} where lists take more than the memory, Error{cancelled}
  /// Memory  12 bytes per point, 4 per triangle and cell that it lies in
  MeshShadow(std::vector<RayMesh> meshes, const Options& options, const Progress& watcher);

  /// The share of the lamp's light that comes to a place in world space, 0 .. 1.
  double passed(const Point3& world) const;
  /// The same of a place in samples.
  double passed_at_sample(const Point3& place) const;

 private:
  struct LampRows {  // to places across the light and towards it
    std::array<Point3, 3> rows{};
    Point3 offset{};

    Point3 at(const Point3& place) const;
  };

  void project();
  void set_grid();
  template <class Visit>
  void visit_cells_of(const Progress& watcher, Visit&& visit) const;
  double passed_to(const Point3& lamp_place) const;
  const RayMesh& mesh_of(std::uint64_t triangle, std::size_t& mesh) const;

  std::vector<RayMesh> meshes_;
  double nearest_mm_;
  LampRows of_world_;
  LampRows of_samples_;
  std::vector<std::vector<MeshPoint>> points_;  // by mesh: across, across, towards the light
  std::vector<std::uint64_t> first_triangles_;  // by mesh
  std::uint64_t triangle_count_ = 0;
  std::array<double, 2> low_{};
  double cells_per_mm_ = 0;
  std::array<std::int64_t, 2> cells_{};
  std::vector<std::uint64_t> begins_;     // by cell
  std::vector<std::uint32_t> triangles_;  // of all meshes one after the other
};

/// What is left of the lamp's share of light at a place in samples behind the meshes of a table.
float direct_behind_meshes(const ShadeTable& table, const float* place, float direct);

}  // namespace octavo
