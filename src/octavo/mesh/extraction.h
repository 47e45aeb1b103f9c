// The surface of what lies inside, out of the bricks of a file, a layer of blocks at a time.
//
// Marching cubes with the rules of cube_cases.h. What is outside the volume lies outside, so the
// surface is closed at its border. Bricks whose minimum and maximum decide are not decoded, unless
// the surface passes beside them.
//
// Source  thesis 4.1
#pragma once

#include <cstdint>
#include <span>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/file/reader.h"
#include "octavo/mesh/surface_field.h"

namespace octavo {

/// Takes a surface as it is made, on one thread.
class SurfaceSink {
 public:
  virtual ~SurfaceSink() = default;
  /// The next points; they are numbered from 0 in the order in which they come.
  virtual void add_points(std::span<const MeshPoint> points) = 0;
  /// The next triangles. The points that they join have come before, at most two layers ago.
  virtual void add_triangles(std::span<const MeshTriangle> triangles) = 0;
  /// Called behind each layer of blocks.
  virtual void finish_layer() {}
};

/// A sink that keeps all of it.
class MeshCollector final : public SurfaceSink {
 public:
  /// max_bytes  of the mesh; 0: no limit, otherwise Error{limit_exceeded} when it grows beyond it
  explicit MeshCollector(std::uint64_t max_bytes = 0) : max_bytes_(max_bytes) {}
  void add_points(std::span<const MeshPoint> points) override;
  void add_triangles(std::span<const MeshTriangle> triangles) override;
  void finish_layer() override;
  TriangleMesh take() { return std::move(mesh_); }

 private:
  TriangleMesh mesh_;
  std::uint64_t max_bytes_;
};

/// Gives the surface of a level to `sink`: points in world space, triangles outward. The order of
/// both depends on the volume alone. Uses the threads of the calling task arena.
/// Throws  what reader and sink throw, Error{cancelled}; Error{limit_exceeded} for 2^32 points or
///         more; Error{invalid_argument} for a level that is not there
/// Memory  that of the surface in two layers of 64 planes, 150 kB for each block of 64^3 voxels
///         there that it cuts, and 3 MB per thread; besides the reader's cache
void extract_surface(const FileReader& reader, int level, const SurfaceField& field,
                     SurfaceSink& sink, Progress& progress);

}  // namespace octavo
