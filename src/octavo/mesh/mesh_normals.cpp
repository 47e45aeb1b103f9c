#include "octavo/mesh/mesh_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "octavo/core/vectors.h"
#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/parallel_sort.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

/// The vector at a length of 1; up where it has no direction.
MeshPoint unit_or_up(const Point3& vector) {
  const double length = std::sqrt(dot(vector, vector));
  MeshPoint result = {0, 0, 1};
  if (!(length > 0) || !std::isfinite(length)) return result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result[axis] = static_cast<float>(vector[axis] / length);
  }
  return result;
}

/// The voxels around some points, and values between them.
template <class T>
class NormalSamples {
 public:
  /// Reads a box.
  void read(const FileReader& reader, int level, const Box& box) {
    box_ = box;
    const Size3 size = box.size();
    row_ = size.x;
    plane_ = size.x * size.y;
    values_.resize(static_cast<std::size_t>(size.voxel_count()));
    reader.read(box, level, values_.data());
  }

  /// Requires that the eight voxels around `at` lie in the box.
  double value_at(const Point3& at) const {
    const Index3 first = {before(at[0], 0), before(at[1], 1), before(at[2], 2)};
    const double x = at[0] - static_cast<double>(first.x);
    const double y = at[1] - static_cast<double>(first.y);
    const double z = at[2] - static_cast<double>(first.z);
    const T* const corner = values_.data() + (first.z - box_.lo.z) * plane_ +
                            (first.y - box_.lo.y) * row_ + (first.x - box_.lo.x);
    const auto between = [](double a, double b, double share) { return a + (b - a) * share; };
    const auto along_x = [&](const T* row) {
      const std::int64_t next = first.x + 1 < box_.hi.x ? 1 : 0;
      return between(static_cast<double>(row[0]), static_cast<double>(row[next]), x);
    };
    const auto along_y = [&](const T* plane) {
      const std::int64_t next = first.y + 1 < box_.hi.y ? row_ : 0;
      return between(along_x(plane), along_x(plane + next), y);
    };
    const std::int64_t next = first.z + 1 < box_.hi.z ? plane_ : 0;
    return between(along_y(corner), along_y(corner + next), z);
  }

 private:
  std::int64_t before(double at, int axis) const {
    return std::clamp(static_cast<std::int64_t>(std::floor(at)), box_.lo[axis],
                      box_.hi[axis] - 1);
  }

  Box box_;
  std::int64_t row_ = 0;
  std::int64_t plane_ = 0;
  std::vector<T> values_;
};

/// The points of a mesh, sorted by the block of 64^3 voxels that they lie in.
class PointsByBlock {
 public:
  static constexpr std::int64_t kSide = 64;

  PointsByBlock(const TriangleMesh& mesh, const Geometry& geometry, const Size3& size)
      : size_(size),
        grid_{size.x / kSide + 1, size.y / kSide + 1, size.z / kSide + 1},
        places_(mesh.points.size()) {
    std::vector<std::uint64_t> block(mesh.points.size());
    parallel_for(std::size_t{0}, mesh.points.size(), [&](std::size_t i) {
      places_[i] = geometry.to_index(place_of_point(mesh.points[i]));
      block[i] = block_of(places_[i]);
    });
    order_.reserve(mesh.points.size());
    for (std::uint32_t i = 0; i < mesh.points.size(); ++i) {
      if (is_between_voxels(places_[i])) order_.push_back(i);
    }
    parallel_sort(order_, [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(block[a], a) < std::pair(block[b], b);
    });
    for (std::size_t i = 0; i < order_.size(); ++i) {
      if (i == 0 || block[order_[i]] != block[order_[i - 1]]) starts_.push_back(i);
    }
    starts_.push_back(order_.size());
  }

  std::size_t block_count() const { return starts_.size() - 1; }
  std::span<const std::uint32_t> block(std::size_t number) const {
    return {order_.data() + starts_[number], starts_[number + 1] - starts_[number]};
  }
  /// In voxels.
  const Point3& place(std::uint32_t point) const { return places_[point]; }

  /// The voxels that values a voxel to either side of the points of a block lie between.
  Box box_around(std::size_t number) const {
    Point3 lowest = places_[block(number).front()];
    Point3 highest = lowest;
    for (const std::uint32_t point : block(number)) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lowest[axis] = std::min(lowest[axis], places_[point][axis]);
        highest[axis] = std::max(highest[axis], places_[point][axis]);
      }
    }
    const auto floored = [](double at) { return static_cast<std::int64_t>(std::floor(at)); };
    return intersection(
        {{floored(lowest[0]) - 1, floored(lowest[1]) - 1, floored(lowest[2]) - 1},
         {floored(highest[0]) + 3, floored(highest[1]) + 3, floored(highest[2]) + 3}},
        box_of(size_));
  }

 private:
  bool is_between_voxels(const Point3& place) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto last = static_cast<double>(size_[static_cast<int>(axis)] - 1);
      if (!(place[axis] >= 0 && place[axis] <= last)) return false;
    }
    return true;
  }

  std::uint64_t block_of(const Point3& place) const {
    const auto at = [&](std::size_t axis) {
      const std::int64_t last = size_[static_cast<int>(axis)] - 1;
      const auto inside = std::clamp(place[axis], 0.0, static_cast<double>(last));
      return static_cast<std::int64_t>(inside) / kSide;
    };
    return static_cast<std::uint64_t>((at(2) * grid_.y + at(1)) * grid_.x + at(0));
  }

  Size3 size_;
  Size3 grid_;  // of blocks
  std::vector<Point3> places_;
  std::vector<std::uint32_t> order_;
  std::vector<std::size_t> starts_;
};

/// Index gradients to world vectors.
class GradientFrame {
 public:
  GradientFrame(const Geometry& geometry, const Size3& size) : size_(size) {
    Geometry around = geometry;
    around.origin_mm = {0, 0, 0};
    // Column of the inverse by column: how each index grows along a world axis.
    for (std::size_t row = 0; row < 3; ++row) {
      Point3 step{};
      step[row] = 1;
      growth_[row] = around.to_index(step);
    }
  }

  template <class T>
  Point3 at(const NormalSamples<T>& samples, const Point3& place) const {
    Point3 by_index;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto last = static_cast<double>(size_[static_cast<int>(axis)] - 1);
      Point3 below = place;
      Point3 above = place;
      below[axis] = std::max(place[axis] - 1, 0.0);
      above[axis] = std::min(place[axis] + 1, last);
      const double length = above[axis] - below[axis];
      by_index[axis] =
          length > 0 ? (samples.value_at(above) - samples.value_at(below)) / length : 0;
    }
    return {dot(growth_[0], by_index), dot(growth_[1], by_index), dot(growth_[2], by_index)};
  }

 private:
  Size3 size_;
  std::array<Point3, 3> growth_{};
};

}  // namespace

std::vector<MeshPoint> area_normals(const TriangleMesh& mesh) {
  std::vector<Point3> sums(mesh.points.size());
  for (const MeshTriangle& t : mesh.triangles) {
    const TrianglePlaces places = places_of(mesh, t);
    const Point3 normal = cross(difference(places[1], places[0]), difference(places[2], places[0]));
    for (const std::uint32_t point : t) sums[point] = sum(sums[point], normal);
  }
  std::vector<MeshPoint> normals(mesh.points.size());
  std::transform(sums.begin(), sums.end(), normals.begin(), unit_or_up);
  return normals;
}

std::vector<MeshPoint> gradient_normals(const TriangleMesh& mesh, const FileReader& reader,
                                        int level, const SurfaceField& field, Progress& progress) {
  std::vector<MeshPoint> normals = area_normals(mesh);
  if (!field.isovalue) return normals;
  const Geometry geometry = reader.levels().geometry(reader.description().geometry, level);
  const Size3 size = reader.levels().size(level);
  const PointsByBlock points(mesh, geometry, size);
  const GradientFrame frame(geometry, size);
  const double outward = std::isinf(field.inside.front().highest) ? -1 : 1;

  with_voxel_type(reader.description().type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    PerThread<NormalSamples<T>> spaces;
    parallel_for(std::size_t{0}, points.block_count(), [&](std::size_t i) {
      stop_if_cancelled(progress);
      NormalSamples<T>& samples = spaces.local();
      samples.read(reader, level, points.box_around(i));
      for (const std::uint32_t point : points.block(i)) {
        const Point3 gradient = frame.at(samples, points.place(point));
        const double length = std::sqrt(dot(gradient, gradient));
        // Not to the side that the triangles call inside; nor where there is no gradient.
        const double along = outward * dot(gradient, place_of_point(normals[point]));
        if (along > 0 && std::isfinite(length)) {
          normals[point] = unit_or_up(scaled(gradient, outward));
        }
      }
    });
  });
  return normals;
}

}  // namespace octavo
