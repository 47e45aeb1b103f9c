// Surfaces of triangles in a picture of rays: which rays meet them, and where.
//
//     triangles -> by tile -> places of pixels covered -> layers of each ray, in order
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/render/picture.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_layers.h"
#include "octavo/render/view.h"

namespace octavo {

/// A surface, as it is seen. Views, which must outlive it.
struct RayMesh {
  const TriangleMesh* mesh = nullptr;    ///< world space
  std::span<const MeshPoint> normals{};  ///< one of length 1 per point
  Color color{};
  double opacity = 1;  ///< 0 .. 1
};

/// Where a surface turns by more than the angle of this cosine it has an edge, and no smooth light.
inline constexpr double kSharpCosine = 0.7;

/// Where a place in world space is seen, in pixels from the middle of the picture; nothing where it
/// lies behind the eye.
/// geometry  of the grid whose samples rays cross
std::optional<std::array<double, 2>> place_in_picture(const Geometry& geometry,
                                                      const RayFrame& frame, const Point3& world);

/// Every count-th of the tiles of a picture, the first of them being tile `first`.
struct TileShare {
  std::size_t first = 0;
  std::size_t count = 1;

  bool has(std::size_t tile) const { return tile % count == first; }
};

/// The surfaces of a picture.
class RayMeshes {
 public:
  struct Options {
    Geometry geometry;  ///< of the grid whose samples rays cross
    View view;
    std::uint64_t memory_bytes = std::uint64_t{1} << 30;  ///< for lists of triangles and layers
    /// Which share of the lamp's light comes to a place in world space; none: all.
    std::function<double(const Point3& world)> lamp_share{};
  };

  RayMeshes(std::vector<RayMesh> meshes, const Options& options);

  /// The layers of all rays of a picture, tile by tile as in RayField.
  /// frame  with camera and light
  /// share  of the tiles; the others have no layers
  /// Uses the threads of the caller's arena; the result does not depend on them.
  /// Throws Error{limit_exceeded} where lists take more than the memory, Error{cancelled}
  std::vector<TileLayers> layers(const RayFrame& frame, std::int64_t width, std::int64_t height,
                                 const Progress& watcher, const TileShare& share = {}) const;

 private:
  std::vector<RayMesh> meshes_;
  Options options_;
};

}  // namespace octavo
