// Fewer triangles of a surface while it is extracted, so that the full surface is never in memory
// as a whole.
//
// Layers of blocks are taken together until they have as many triangles as a window should;
// decimation_window.h reduces these and keeps what the next window needs of them. A surface that
// fits into one window stays full: it is for decimate. What comes of the others depends on the
// surface alone, not on threads or memory.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/decimation.h"
#include "octavo/mesh/extraction.h"
#include "octavo/mesh/layered_decimation/decimation_window.h"

namespace octavo {

struct LayeredOptions {
  double max_deviation_mm = 0;   ///< at most half the shortest side of a voxel; 0: none
  Geometry geometry;             ///< of the level
  std::int64_t plane_count = 0;  ///< of the level
  std::uint64_t window_triangles = 1 << 19;  ///< that a window has at least, above 0
  std::uint64_t max_bytes = 0;   ///< of memory; 0: no limit
};

struct LayeredSurface {
  TriangleMesh mesh;
  bool is_reduced = false;  ///< else it is the full surface
  std::uint64_t full_triangle_count = 0;
  std::uint64_t crossing_triangles = 0;  ///< of what is reduced
  /// Whether a piece that several windows have encloses nothing any more, or is turned inside out:
  /// only of pieces thinner than the deviation. Such a surface must not be used.
  bool is_turned = false;
};

class LayeredDecimation final : public SurfaceSink {
 public:
  /// progress  is asked whether to stop, and told nothing; must outlive this
  LayeredDecimation(const LayeredOptions& options, const Progress& progress);
  LayeredDecimation(const LayeredDecimation&) = delete;
  LayeredDecimation& operator=(const LayeredDecimation&) = delete;

  void add_points(std::span<const MeshPoint> points) override { window_.add_points(points); }
  void add_triangles(std::span<const MeshTriangle> triangles) override;
  /// Reduces a window that is full. Uses the threads of the calling task arena.
  /// Throws  Error{cancelled}, Error{limit_exceeded} beyond max_bytes
  /// Memory  450 to 600 bytes per point of a window, which is the full surface in as many layers of
  ///         64 planes as have the triangles of a window, and in half a layer before these
  void finish_layer() override;

  /// What has come, at the end. Uses the threads of the calling task arena; throws as finish_layer.
  LayeredSurface take();

 private:
  void require_memory(std::uint64_t bytes_per_point) const;
  bool is_turned() const;

  LayeredOptions options_;
  DecimationOptions decimation_;
  const Progress& progress_;
  DecimationWindow window_;
  FixedSurface fixed_;
  std::int64_t finished_layers_ = 0;
  bool is_reduced_ = false;
  std::uint64_t triangle_count_ = 0;
};

}  // namespace octavo
