#include "octavo/mesh/layered_decimation/layered_decimation.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "octavo/core/memory_limit.h"
#include "octavo/mesh/decimation_frame.h"
#include "octavo/mesh/enclosed_volumes.h"
#include "octavo/mesh/mesh_pieces.h"
#include "octavo/mesh/surface_block.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

namespace {

// Of a window: as it is extracted, and while it is reduced and proven.
constexpr std::uint64_t kBytesPerPoint = sizeof(MeshPoint) + 2 * sizeof(MeshTriangle);
constexpr std::uint64_t kBytesPerReducedPoint = 600;

}  // namespace

LayeredDecimation::LayeredDecimation(const LayeredOptions& options, const Progress& progress)
    : options_(options),
      decimation_{options.max_deviation_mm, options.geometry},
      progress_(progress),
      window_(decimation_) {}

void LayeredDecimation::add_triangles(std::span<const MeshTriangle> triangles) {
  window_.add_triangles(triangles);
  triangle_count_ += triangles.size();
}

void LayeredDecimation::require_memory(std::uint64_t bytes_per_point) const {
  require_memory_within(bytes_per_point * window_.point_count() + fixed_.mesh.memory_bytes(),
                        options_.max_bytes, "the surface",
                        "raise the limit, or take a coarser level");
}

void LayeredDecimation::finish_layer() {
  window_.finish_layer();
  ++finished_layers_;
  require_memory(kBytesPerPoint);
  const std::int64_t end = finished_layers_ * kSurfaceSide;
  const bool is_last = end > options_.plane_count;
  if (is_last || window_.new_triangles() < options_.window_triangles) return;
  if (!can_be_proven(options_.max_deviation_mm, options_.geometry)) return;
  require_memory(kBytesPerReducedPoint);
  is_reduced_ = true;
  // Cubes of the last plane of voxels belong to the next layer.
  window_.reduce_to(static_cast<double>(end - 1), fixed_, progress_);
}

LayeredSurface LayeredDecimation::take() {
  LayeredSurface surface;
  surface.full_triangle_count = triangle_count_;
  surface.is_reduced = is_reduced_;
  if (!is_reduced_) {
    surface.mesh = window_.take_full();
    return surface;
  }
  require_memory(kBytesPerReducedPoint);
  window_.reduce_all(fixed_, progress_);
  surface.is_turned = is_turned();
  surface.mesh = std::move(fixed_.mesh);
  require_numbered(surface.mesh.triangles.size());
  surface.crossing_triangles =
      crossing_triangles(TriangleTree(surface.mesh), progress_).size();
  return surface;
}

/// Whether the volumes of a piece, as it is and as it was, do not have the same sign.
bool LayeredDecimation::is_turned() const {
  const MeshPieces pieces = mesh_pieces(fixed_.mesh);
  const auto piece_of = [&](std::size_t i) {
    return pieces.of_point[fixed_.mesh.triangles[i][0]];
  };
  const std::vector<double> volumes = volumes_of_groups(fixed_.mesh, pieces.count, piece_of);
  std::vector<double> full_volumes(pieces.count);
  for (std::size_t point = 0; point < fixed_.volumes.size(); ++point) {
    full_volumes[pieces.of_point[point]] += fixed_.volumes[point];
  }
  for (std::size_t piece = 0; piece < volumes.size(); ++piece) {
    if ((volumes[piece] > 0) != (full_volumes[piece] > 0)) return true;
  }
  return false;
}

}  // namespace octavo
