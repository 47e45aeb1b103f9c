#include "octavo/render/rays/mesh_shadow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr double kMostShadowCells = 2048;  // along an axis
constexpr double kCellsPerRoot = 1.5;      // of the number of triangles
constexpr double kCellMargin = 1e-3;       // cells that triangles are taken to be larger

/// Twice the area of the triangle of an edge and a place: above 0 where the place lies to the left
/// of it. Turned round the edge gives the same number times -1, bit for bit.
struct EdgeSide {
  double area = 0;
  bool is_left = false;
};

EdgeSide side_of(const MeshPoint& from, const MeshPoint& to, const Point3& place) {
  const bool is_turned = to[0] < from[0] || (to[0] == from[0] && to[1] < from[1]);
  const MeshPoint& a = is_turned ? to : from;
  const MeshPoint& b = is_turned ? from : to;
  const double area =
      (static_cast<double>(b[0]) - a[0]) * (place[1] - a[1]) -
      (static_cast<double>(b[1]) - a[1]) * (place[0] - a[0]);
  return {is_turned ? -area : area, (area >= 0) != is_turned};
}

/// How far a row of cells reaches along a triangle: [low, high], low above high where it does not.
std::array<double, 2> reach_in_row(const std::array<std::array<double, 2>, 3>& corners, double top,
                                   double bottom) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& a = corners[i];
    const auto& b = corners[(i + 1) % 3];
    const double rise = b[1] - a[1];
    double begin = 0;
    double end = 1;
    if (rise != 0) {
      const double at_top = (top - a[1]) / rise;
      const double at_bottom = (bottom - a[1]) / rise;
      begin = std::max(begin, std::min(at_top, at_bottom));
      end = std::min(end, std::max(at_top, at_bottom));
    } else if (a[1] < top || a[1] > bottom) {
      continue;
    }
    if (begin > end) continue;
    for (const double t : {begin, end}) {
      const double x = a[0] + t * (b[0] - a[0]);
      low = std::min(low, x);
      high = std::max(high, x);
    }
  }
  return {low, high};
}

}  // namespace

Point3 MeshShadow::LampRows::at(const Point3& place) const {
  return {dot(rows[0], place) + offset[0], dot(rows[1], place) + offset[1],
          dot(rows[2], place) + offset[2]};
}

MeshShadow::MeshShadow(std::vector<RayMesh> meshes, const Options& options,
                       const Progress& watcher)
    : meshes_(std::move(meshes)), nearest_mm_(options.nearest_mm) {
  std::erase_if(meshes_, [](const RayMesh& mesh) { return !(mesh.opacity > 0); });
  // Any two directions across the light.
  const Point3& toward = options.toward_light;
  const Point3 other = std::abs(toward[2]) < 0.7 ? Point3{0, 0, 1} : Point3{1, 0, 0};
  const Point3 across = unit(cross(other, toward));
  of_world_.rows = {across, cross(toward, across), toward};
  const Point3 origin = options.geometry.to_world({0, 0, 0});
  of_samples_.offset = of_world_.at(origin);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Point3 sample{};
    sample[axis] = 1;
    const Point3 step =
        of_world_.at(difference(options.geometry.to_world(sample), origin));
    for (std::size_t i = 0; i < 3; ++i) of_samples_.rows[i][axis] = step[i];
  }
  project();
  set_grid();

  // Triangles by cell.
  begins_.assign(static_cast<std::size_t>(cells_[0] * cells_[1]) + 1, 0);
  visit_cells_of(watcher, [&](std::size_t cell, std::uint32_t) { ++begins_[cell + 1]; });
  for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
  if (begins_.back() > options.memory_bytes / sizeof(std::uint32_t)) {
    throw Error(ErrorKind::limit_exceeded,
                "the shadows of the meshes lie above each other so often that lists of their "
                "triangles take more than " +
                    bytes_text(options.memory_bytes))
        .with_field("meshes.memory");
  }
  triangles_.resize(begins_.back());
  std::vector<std::uint64_t> next(begins_.begin(), begins_.end() - 1);
  visit_cells_of(watcher, [&](std::size_t cell, std::uint32_t triangle) {
    triangles_[next[cell]++] = triangle;
  });
}

double MeshShadow::passed(const Point3& world) const { return passed_to(of_world_.at(world)); }

double MeshShadow::passed_at_sample(const Point3& place) const {
  return passed_to(of_samples_.at(place));
}

void MeshShadow::project() {
  for (const RayMesh& mesh : meshes_) {
    first_triangles_.push_back(triangle_count_);
    triangle_count_ += mesh.mesh->triangles.size();
    std::vector<MeshPoint>& points = points_.emplace_back();
    points.reserve(mesh.mesh->points.size());
    for (const MeshPoint& point : mesh.mesh->points) {
      const Point3 at = of_world_.at({point[0], point[1], point[2]});
      points.push_back({static_cast<float>(at[0]), static_cast<float>(at[1]),
                        static_cast<float>(at[2])});
    }
  }
}

void MeshShadow::set_grid() {
  std::array<double, 2> high;
  low_.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const std::vector<MeshPoint>& points : points_) {
    for (const MeshPoint& point : points) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        low_[axis] = std::min(low_[axis], static_cast<double>(point[axis]));
        high[axis] = std::max(high[axis], static_cast<double>(point[axis]));
      }
    }
  }
  const double longest = std::max(high[0] - low_[0], high[1] - low_[1]);
  cells_ = {0, 0};
  if (!(longest > 0) || !std::isfinite(longest)) return;
  const double along = std::clamp(
      std::ceil(kCellsPerRoot * std::sqrt(static_cast<double>(triangle_count_))), 1.0,
      kMostShadowCells);
  cells_per_mm_ = along / longest;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    cells_[axis] = static_cast<std::int64_t>((high[axis] - low_[axis]) * cells_per_mm_) + 1;
  }
}

/// Calls visit(cell, triangle) for each triangle and each cell that it lies in.
template <class Visit>
void MeshShadow::visit_cells_of(const Progress& watcher, Visit&& visit) const {
  if (cells_[0] == 0) return;
  std::uint32_t number = 0;
  const auto cell_of = [](double place, std::int64_t count) {
    return std::clamp(static_cast<std::int64_t>(std::floor(place)), std::int64_t{0}, count - 1);
  };
  for (std::size_t mesh = 0; mesh < meshes_.size(); ++mesh) {
    for (const MeshTriangle& triangle : meshes_[mesh].mesh->triangles) {
      constexpr std::uint32_t kTrianglesBetween = 1 << 16;
      if (number % kTrianglesBetween == 0 && watcher.is_cancelled()) {
        throw Error(ErrorKind::cancelled, "stopped");
      }
      std::array<std::array<double, 2>, 3> corners{};
      for (std::size_t i = 0; i < 3; ++i) {
        const MeshPoint& point = points_[mesh][triangle[i]];
        for (std::size_t axis = 0; axis < 2; ++axis) {
          corners[i][axis] = (point[axis] - low_[axis]) * cells_per_mm_;
        }
      }
      const auto [top, bottom] = std::minmax({corners[0][1], corners[1][1], corners[2][1]});
      const std::int64_t last = cell_of(bottom + kCellMargin, cells_[1]);
      for (std::int64_t row = cell_of(top - kCellMargin, cells_[1]); row <= last; ++row) {
        const auto [low, high] =
            reach_in_row(corners, static_cast<double>(row) - kCellMargin,
                         static_cast<double>(row + 1) + kCellMargin);
        if (low > high) continue;
        const std::int64_t end = cell_of(high + kCellMargin, cells_[0]);
        for (std::int64_t i = cell_of(low - kCellMargin, cells_[0]); i <= end; ++i) {
          visit(static_cast<std::size_t>(row * cells_[0] + i), number);
        }
      }
      ++number;
    }
  }
}

double MeshShadow::passed_to(const Point3& lamp_place) const {
  std::array<std::int64_t, 2> cell{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double at = (lamp_place[axis] - low_[axis]) * cells_per_mm_;
    if (!(at >= 0 && at < static_cast<double>(cells_[axis]))) return 1;
    cell[axis] = static_cast<std::int64_t>(at);
  }
  const auto number = static_cast<std::size_t>(cell[1] * cells_[0] + cell[0]);
  double passed = 1;
  for (std::uint64_t i = begins_[number]; i < begins_[number + 1]; ++i) {
    const std::uint64_t triangle = triangles_[i];
    std::size_t mesh = 0;
    const RayMesh& of = mesh_of(triangle, mesh);
    const MeshTriangle& corners = of.mesh->triangles[triangle - first_triangles_[mesh]];
    const MeshPoint& a = points_[mesh][corners[0]];
    const MeshPoint& b = points_[mesh][corners[1]];
    const MeshPoint& c = points_[mesh][corners[2]];
    const EdgeSide beside_a = side_of(b, c, lamp_place);
    const EdgeSide beside_b = side_of(c, a, lamp_place);
    const EdgeSide beside_c = side_of(a, b, lamp_place);
    if (beside_a.is_left != beside_b.is_left || beside_b.is_left != beside_c.is_left) continue;
    const double area = beside_a.area + beside_b.area + beside_c.area;
    if (area == 0) continue;
    const double toward =
        (beside_a.area * a[2] + beside_b.area * b[2] + beside_c.area * c[2]) / area;
    if (toward - lamp_place[2] <= nearest_mm_) continue;
    passed *= 1 - of.opacity;
    if (passed < kNoLight) return 0;
  }
  return passed;
}

const RayMesh& MeshShadow::mesh_of(std::uint64_t triangle, std::size_t& mesh) const {
  const auto after = std::upper_bound(first_triangles_.begin(), first_triangles_.end(), triangle);
  mesh = static_cast<std::size_t>(after - first_triangles_.begin()) - 1;
  return meshes_[mesh];
}

float direct_behind_meshes(const ShadeTable& table, const float* place, float direct) {
  if (table.meshes == nullptr) return direct;
  const auto passed =
      static_cast<float>(table.meshes->passed_at_sample({place[0], place[1], place[2]}));
  return kDeepestShadow + std::max(direct - kDeepestShadow, 0.0f) * passed;
}

}  // namespace octavo
