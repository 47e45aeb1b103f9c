#include "octavo/mesh/hexahedra/hex_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/mesh/cancellation.h"

namespace octavo {

namespace {

double determinant(const Point3& a, const Point3& b, const Point3& c) {
  return dot(cross(a, b), c);
}

/// The determinant of three sides made as long as 1, and of those as they are.
struct CornerJacobian {
  double scaled = 0;
  double volume = 0;
};

CornerJacobian corner_jacobian(const Point3& a, const Point3& b, const Point3& c) {
  const double volume = determinant(a, b, c);
  return {volume / std::sqrt(dot(a, a) * dot(b, b) * dot(c, c)), volume};
}

/// Of a pyramid the smallest of the four corners of its base, of a tetrahedron that of all four,
/// times the root of 2: 1 for those whose sides are all alike.
double scaled_jacobian(HexShape shape, const std::array<Point3, 5>& p) {
  double smallest = 1;
  const auto add = [&](std::size_t at, std::size_t a, std::size_t b, std::size_t c) {
    const double scaled = corner_jacobian(difference(p[a], p[at]), difference(p[b], p[at]),
                                          difference(p[c], p[at]))
                              .scaled;
    smallest = std::min(smallest, std::sqrt(2.0) * scaled);
  };
  if (shape == HexShape::pyramid) {
    for (std::size_t i = 0; i < 4; ++i) add(i, (i + 1) % 4, (i + 3) % 4, 4);
    return smallest;
  }
  add(0, 1, 2, 3);
  add(1, 2, 0, 3);
  add(2, 0, 1, 3);
  add(3, 0, 2, 1);
  return smallest;
}

double element_volume(HexShape shape, const std::array<Point3, 5>& p) {
  const std::size_t top = shape == HexShape::pyramid ? 4 : 3;
  const double first =
      determinant(difference(p[1], p[0]), difference(p[2], p[0]), difference(p[top], p[0]));
  if (shape == HexShape::tetrahedron) return first / 6;
  return (first + determinant(difference(p[2], p[0]), difference(p[3], p[0]),
                              difference(p[top], p[0]))) /
         6;
}

}  // namespace

double HexQuality::percentile(double percent) const {
  std::uint64_t all = 0;
  for (const auto& [value, count] : scaled_jacobians) all += count;
  const double wanted = percent / 100 * static_cast<double>(all);
  std::uint64_t below = 0;
  for (const auto& [value, count] : scaled_jacobians) {
    below += count;
    if (static_cast<double>(below) > wanted) return value;
  }
  return scaled_jacobians.empty() ? 0 : scaled_jacobians.back().first;
}

HexMesh::HexMesh(const Geometry& geometry, HexMethod method, std::vector<std::int64_t> labels,
                 std::vector<HexCell> cells, std::vector<HexGroup> groups, CellValues values,
                 const Progress& watcher)
    : geometry_(geometry),
      method_(method),
      labels_(std::move(labels)),
      cells_(std::move(cells)),
      groups_(std::move(groups)),
      values_(std::move(values)),
      nodes_(cells_, watcher) {
  const auto& d = geometry.direction;
  is_mirrored_ = determinant({d[0], d[3], d[6]}, {d[1], d[4], d[7]}, {d[2], d[5], d[8]}) < 0;
  bounds_[0].fill(HexNodes::kNone);
  for (const HexCell& cell : cells_) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds_[0][axis] = std::min(bounds_[0][axis], cell.corner[axis]);
      bounds_[1][axis] = std::max(bounds_[1][axis], cell.corner[axis] + cell.side());
    }
  }
  find_fans(watcher);
  if (node_count() <= kMostHexNodes && element_count_ <= kMostHexNodes) return;
  throw Error(ErrorKind::limit_exceeded,
              "the mesh has " + std::to_string(node_count()) + " nodes and " +
                  std::to_string(element_count_) + " elements; solvers number 2147483647")
      .with_field("level");
}

void HexMesh::find_fans(const Progress& watcher) {
  HexNodes::Near near;
  for (HexGroup& group : groups_) {
    group.first_fan = fans_.size();
    group.element_counts = {};
    for (std::uint64_t i = group.first_cell; i < group.end_cell; ++i) {
      constexpr std::uint64_t kCellsBetween = 1 << 16;
      if (i % kCellsBetween == 0) stop_if_cancelled(watcher);
      HexCell& cell = cells_[i];
      cell.is_fan = false;
      if (method_ == HexMethod::conforming && cell.level > 0) {
        const std::uint32_t points = nodes_.points_of(cell, near);
        cell.is_fan = points != HexNodes::kCornerPoints;
        if (cell.is_fan) {
          fans_.push_back(points);
          if (!shapes_.contains(points)) shapes_.emplace(points, fan_of(points));
        }
      }
      if (!cell.is_fan) {
        ++group.element_counts[0];
        continue;
      }
      for (const FanElement& element : fan(fans_.size() - 1)) {
        ++group.element_counts[static_cast<std::size_t>(element.shape)];
      }
    }
    element_count_ += group.element_count();
  }
}

std::array<std::uint32_t, 27> HexMesh::fan_nodes(const HexCell& cell, std::uint64_t number) const {
  std::array<std::uint32_t, 27> nodes{};
  const std::uint32_t half = cell.side() / 2;
  for (std::uint32_t i = 0; i < 27; ++i) {
    if ((fans_[number] >> i & 1) == 0) continue;
    nodes[i] = nodes_.number_at({cell.corner[0] + i % 3 * half, cell.corner[1] + i / 3 % 3 * half,
                                 cell.corner[2] + i / 9 * half});
  }
  nodes[kFanCenter] = static_cast<std::uint32_t>(nodes_.count() + number);
  return nodes;
}

bool HexMesh::is_on_side(const HexCell& cell, int face) const {
  const auto axis = static_cast<std::size_t>(face / 2);
  if (face % 2 == 0) return cell.corner[axis] == bounds_[0][axis];
  return cell.corner[axis] + cell.side() == bounds_[1][axis];
}

Point3 HexMesh::place_of(const std::array<double, 3>& point) const {
  return geometry_.to_world({point[0] - 0.5, point[1] - 0.5, point[2] - 0.5});
}

HexQuality HexMesh::quality() const {
  const Point3 origin = place_of({0, 0, 0});
  const auto at = [&](std::uint32_t i) {
    const Point3 place = difference(
        place_of({0.5 * (i % 3), 0.5 * (i / 3 % 3), 0.5 * (i / 9)}), origin);
    return place;
  };
  const CornerJacobian cube = corner_jacobian(at(2), at(6), at(18));
  const double voxel_mm3 = std::abs(cube.volume);

  // Shapes repeat: each is measured once, as if its cell had the side of a voxel.
  struct Measured {
    double scaled = 0;
    double volume = 0;
  };
  std::unordered_map<std::uint32_t, std::vector<Measured>> measured;
  for (const auto& [points, elements] : shapes_) {
    for (const FanElement& element : elements) {
      std::array<Point3, 5> places{};
      const auto count = static_cast<std::size_t>(point_count(element.shape));
      for (std::size_t i = 0; i < count; ++i) places[i] = at(element.points[i]);
      if (is_mirrored_) std::reverse(places.begin(), places.begin() + (count - 1));
      measured[points].push_back(
          {scaled_jacobian(element.shape, places), element_volume(element.shape, places)});
    }
  }

  HexQuality quality;
  std::map<double, std::uint64_t> counts;
  const auto add = [&](const Measured& one, double scale) {
    ++counts[one.scaled];
    const double volume = one.volume * scale;
    if (quality.total_volume_mm3 == 0) quality.min_volume_mm3 = volume;
    quality.min_volume_mm3 = std::min(quality.min_volume_mm3, volume);
    quality.max_volume_mm3 = std::max(quality.max_volume_mm3, volume);
    quality.total_volume_mm3 += volume;
  };
  std::uint64_t number = 0;
  for (const HexCell& cell : cells_) {
    const auto scale = static_cast<double>(cube_volume(cell.level));
    if (!cell.is_fan) {
      add({std::abs(cube.scaled), voxel_mm3}, scale);
      continue;
    }
    for (const Measured& one : measured.at(fans_[number])) add(one, scale);
    ++number;
  }
  quality.scaled_jacobians.assign(counts.begin(), counts.end());
  return quality;
}

std::uint64_t HexMesh::memory_bytes() const noexcept {
  const CellValues& v = values_;
  return cells_.capacity() * sizeof(HexCell) + nodes_.memory_bytes() +
         fans_.capacity() * sizeof(std::uint32_t) +
         (v.mean.capacity() + v.density_g_cm3.capacity() + v.modulus_mpa.capacity()) *
             sizeof(float);
}

}  // namespace octavo
