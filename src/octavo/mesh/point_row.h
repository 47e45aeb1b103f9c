// Places the points of a surface on the edges of a row of voxels.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/surface_field.h"
#include "octavo/mesh/surface_frame.h"

namespace octavo {

/// Edges along one axis that end at voxels of a row.
template <class T>
struct RowEdges {
  int axis = 0;
  Index3 first;                ///< the voxel that bit 0 stands for
  const T* values = nullptr;   ///< of it; those outside the volume are not read
  std::ptrdiff_t back = 0;     ///< to the voxel where such an edge begins, in values
};

template <class T>
class PointRow {
 public:
  PointRow(const SurfaceField& field, const SurfaceFrame& frame)
      : crossing_(field), border_(crossing_at_border(field)), frame_(frame) {}

  /// Writes the points of the edges that `cut` has bits of, and returns the place behind them.
  MeshPoint* place(const RowEdges<T>& edges, std::uint64_t cut, MeshPoint* out) const {
    Index3 begin = edges.first;
    --begin[edges.axis];
    const Point3 start = frame_.place_of(begin);
    const Point3& step = frame_.step(0);
    const Point3& along = frame_.step(edges.axis);
    for (; cut != 0; cut &= cut - 1) {
      const int x = std::countr_zero(cut);
      const double share = share_at(edges, x);
      const auto steps = static_cast<double>(x);
      for (std::size_t row = 0; row < 3; ++row) {
        (*out)[row] =
            static_cast<float>(start[row] + step[row] * steps + along[row] * share);
      }
      ++out;
    }
    return out;
  }

 private:
  /// How far along the edge that ends at a voxel the surface cuts it.
  double share_at(const RowEdges<T>& edges, int x) const {
    const std::int64_t end = edges.first[edges.axis] + (edges.axis == 0 ? x : 0);
    if (end == 0) return 1 - border_;
    if (end == frame_.size()[edges.axis]) return border_;
    const T* const to = edges.values + x;
    return crossing_.between(to[-edges.back], *to);
  }

  CrossingFinder<T> crossing_;
  double border_;
  const SurfaceFrame& frame_;
};

}  // namespace octavo
