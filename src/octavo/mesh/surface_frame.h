// Where the voxels of a grid lie, for points of a surface.
#pragma once

#include <array>
#include <cmath>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"

namespace octavo {

class SurfaceFrame {
 public:
  SurfaceFrame(const Geometry& geometry, const Size3& size) : size_(size) {
    origin_ = geometry.origin_mm;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t row = 0; row < 3; ++row) {
        steps_[axis][row] = geometry.direction[3 * row + axis] * geometry.spacing_mm[axis];
      }
    }
  }

  const Size3& size() const { return size_; }

  /// Whether the grid turns the other way round than space: its index axes are left-handed.
  bool is_mirrored() const { return signed_volume() < 0; }

  /// Of a voxel, mm3.
  double voxel_volume() const { return std::abs(signed_volume()); }

  /// The world position of a voxel; it may lie outside.
  Point3 place_of(const Index3& voxel) const {
    Point3 place;
    for (std::size_t row = 0; row < 3; ++row) {
      place[row] = origin_[row] + steps_[0][row] * static_cast<double>(voxel.x) +
                   steps_[1][row] * static_cast<double>(voxel.y) +
                   steps_[2][row] * static_cast<double>(voxel.z);
    }
    return place;
  }

  /// The world position of a fractional index, rounded to floats.
  MeshPoint point_at(double x, double y, double z) const {
    MeshPoint point;
    for (std::size_t row = 0; row < 3; ++row) {
      point[row] = static_cast<float>(origin_[row] + steps_[0][row] * x + steps_[1][row] * y +
                                      steps_[2][row] * z);
    }
    return point;
  }

  /// From a voxel to the next along an axis.
  const Point3& step(int axis) const { return steps_[static_cast<std::size_t>(axis)]; }

 private:
  double signed_volume() const {
    const auto& [x, y, z] = steps_;
    return x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) +
           x[2] * (y[0] * z[1] - y[1] * z[0]);
  }

  Size3 size_;
  Point3 origin_{};
  std::array<Point3, 3> steps_{};
};

}  // namespace octavo
