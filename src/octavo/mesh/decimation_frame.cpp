#include "octavo/mesh/decimation_frame.h"

#include <algorithm>
#include <cstddef>

#include "octavo/mesh/enclosed_volumes.h"

namespace octavo {

namespace {

constexpr double kRoundingMargin = 1e-5;  // voxels, taken off the deviation that is proven

}  // namespace

double shortest_side(const Geometry& geometry) {
  const auto& [x, y, z] = geometry.spacing_mm;
  return std::min({x, y, z});
}

bool can_be_proven(double max_deviation_mm, const Geometry& geometry) {
  return max_deviation_mm > 2 * kRoundingMargin * shortest_side(geometry);
}

std::optional<Decimated> undecimated(const TriangleMesh& full, const DecimationOptions& options,
                                     const Progress& progress) {
  const std::vector<std::uint32_t> locked(options.locked.begin(), options.locked.end());
  if (full.triangles.empty()) return Decimated{full, 0, 0, locked};
  require_numbered(full.triangles.size());
  if (!can_be_proven(options.max_deviation_mm, options.geometry)) {
    return Decimated{full, 0, crossing_triangles(TriangleTree(full), progress).size(), locked};
  }
  return std::nullopt;
}

DecimationFrame::DecimationFrame(const TriangleMesh& full, const DecimationOptions& options)
    : full_(full),
      locked_(options.locked),
      origin_(place_of_point(full.points.front())),
      deviation_(options.max_deviation_mm - kRoundingMargin * shortest_side(options.geometry)),
      pieces_(mesh_pieces(full)),
      is_held_(pieces_.count + 1),
      volumes_(piece_volumes(full)) {
  is_held_.back() = true;
  hold(locked_);
}

void DecimationFrame::hold(std::span<const std::uint32_t> points) {
  for (const std::uint32_t point : points) is_held_[piece_of(point)] = true;
}

/// What each piece of the full surface encloses; negative around a hollow.
std::vector<double> DecimationFrame::piece_volumes(const TriangleMesh& mesh) const {
  return volumes_of_groups(mesh, pieces_.count + 1,
                           [&](std::size_t i) { return piece_of(mesh.triangles[i][0]); });
}

std::vector<std::uint32_t> DecimationFrame::turned_triangles(const TriangleMesh& mesh) const {
  const std::vector<double> volumes = piece_volumes(mesh);
  std::vector<std::uint32_t> turned;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::size_t piece = piece_of(mesh.triangles[i][0]);
    if (!is_held_[piece] && (volumes[piece] > 0) != (volumes_[piece] > 0)) {
      turned.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return turned;
}

Decimated DecimationFrame::undecimated(int rounds, const TriangleTree& full_tree,
                                       const Progress& progress) const {
  return {full_, rounds, crossing_triangles(full_tree, progress).size(),
          {locked_.begin(), locked_.end()}};
}

Decimated DecimationFrame::compacted(const TriangleMesh& mesh, int rounds,
                                     std::uint64_t crossing_count) const {
  constexpr std::uint32_t kNoNumber = TriangleTree::kNone;
  std::vector<std::uint32_t> numbers(mesh.points.size(), kNoNumber);
  Decimated result{{}, rounds, crossing_count, {}};
  const auto number_of = [&](std::uint32_t point) {
    std::uint32_t& number = numbers[point];
    if (number == kNoNumber) {
      number = static_cast<std::uint32_t>(result.mesh.points.size());
      result.mesh.points.push_back(mesh.points[point]);
    }
    return number;
  };
  result.mesh.triangles.reserve(mesh.triangles.size());
  for (const MeshTriangle& t : mesh.triangles) {
    result.mesh.triangles.push_back({number_of(t[0]), number_of(t[1]), number_of(t[2])});
  }
  for (const std::uint32_t point : locked_) result.locked.push_back(number_of(point));
  return result;
}

}  // namespace octavo
