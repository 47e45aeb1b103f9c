#include "octavo/mesh/octree_decimation/octree_decimation.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/mesh/certificate.h"
#include "octavo/mesh/mesh_pieces.h"
#include "octavo/mesh/octree_decimation/cell_merging.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/point_triangles.h"
#include "octavo/mesh/triangle_tree.h"
#include "octavo/octree/o_code.h"

namespace octavo {

namespace {

constexpr double kCellToleranceShare = 0.8;  // of the deviation, for attached points
constexpr int kCellLockingRound = 2;         // from which nothing in a failing cell merges
constexpr double kCellMargin = 1e-5;         // voxels, taken off the deviation that is proven

class CellDecimation {
 public:
  CellDecimation(const TriangleMesh& full, const DecimationOptions& options, Progress& progress)
      : full_(full),
        locked_(options.locked.begin(), options.locked.end()),
        progress_(progress),
        origin_(place_of_point(full.points.front())),
        fans_(full),
        tree_(full),
        pieces_(mesh_pieces(full)),
        is_held_(pieces_.count) {
    const auto& [x, y, z] = options.geometry.spacing_mm;
    deviation_ = options.max_deviation_mm - kCellMargin * std::min({x, y, z});
    set_rules(options);
    set_surface();
    volumes_ = piece_volumes(full);
  }

  Decimated run() {
    for (int round = 0;; ++round) {
      const ProgressScope scope(progress_, "fewer triangles, round " + std::to_string(round + 1),
                                2, "steps");
      stop_if_cancelled();
      CellSurface merged = start_;
      merge_cells(merged, rules_);
      progress_.advance(1);
      take(merged);
      const bool is_proven = prove();
      progress_.advance(1);
      if (failing_.empty()) return compacted(round + 1);
      if (keep_cells(merged, round)) continue;
      if (is_proven) return compacted(round + 1);
      return {full_, round + 1, crossing_triangles(tree_, progress_).size(), locked_};
    }
  }

 private:
  Point3 place(const MeshPoint& point) const {
    return difference(place_of_point(point), origin_);
  }

  void stop_if_cancelled() const {
    if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
  }

  void set_rules(const DecimationOptions& options) {
    const std::size_t count = full_.points.size();
    rules_.tolerance = kCellToleranceShare * options.max_deviation_mm;
    rules_.full_places.resize(count);
    rules_.codes.resize(count);
    rules_.is_locked.resize(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      rules_.full_places[i] = place(full_.points[i]);
      const Point3 index = options.geometry.to_index(place_of_point(full_.points[i]));
      const auto cell = [&](std::size_t axis) {
        // Surfaces begin a voxel before the first one.
        return std::max(std::int64_t{0}, static_cast<std::int64_t>(std::floor(index[axis])) + 2);
      };
      rules_.codes[i] = interleave({cell(0), cell(1), cell(2)});
    });
    for (const std::uint32_t point : locked_) {
      rules_.is_locked[point] = 1;
      if (pieces_.of_point[point] != MeshPieces::kNone) is_held_[pieces_.of_point[point]] = true;
    }
  }

  void set_surface() {
    const std::size_t count = full_.points.size();
    start_.places = rules_.full_places;
    start_.owners.resize(count);
    std::iota(start_.owners.begin(), start_.owners.end(), 0u);
    start_.levels.assign(count, -1);
    start_.fans.assign(count, CellSurface::kNone);
    start_.quadrics.resize(count);
    start_.triangles = full_.triangles;
    start_.is_left.assign(full_.triangles.size(), 1);
    for (std::uint32_t i = 0; i < full_.triangles.size(); ++i) {
      const MeshTriangle& t = full_.triangles[i];
      const Point3 a = rules_.full_places[t[0]];
      const Point3 normal = cross(difference(rules_.full_places[t[1]], a),
                                  difference(rules_.full_places[t[2]], a));
      const double length = std::sqrt(dot(normal, normal));
      for (const std::uint32_t point : t) {
        start_.fans[point] = i;
        if (length > 0) start_.quadrics[point].add_plane(scaled(normal, 1 / length), a, length);
      }
    }
    start_.first.assign(full_.triangles.size(), CellSurface::kNone);
    start_.next.assign(count, CellSurface::kNone);
    for (std::uint32_t point = 0; point < count; ++point) {
      if (start_.fans[point] == CellSurface::kNone) continue;
      std::uint32_t& first = start_.first[start_.fans[point]];
      start_.next[point] = std::exchange(first, point);
    }
    set_across();
  }

  void set_across() {
    start_.across.resize(full_.triangles.size());
    tbb::parallel_for(std::size_t{0}, full_.triangles.size(), [&](std::size_t i) {
      const MeshTriangle& t = full_.triangles[i];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = t[k];
        const std::uint32_t to = t[(k + 1) % 3];
        start_.across[i][k] = CellSurface::kNone;
        for (const std::uint32_t other : fans_.of(from)) {
          const MeshTriangle& o = full_.triangles[other];
          for (std::size_t j = 0; j < 3; ++j) {
            if (o[j] == to && o[(j + 1) % 3] == from) start_.across[i][k] = other;
          }
        }
      }
    });
  }

  /// What each piece of the full surface encloses, times six; negative around a hollow.
  std::vector<double> piece_volumes(const TriangleMesh& mesh) const {
    std::vector<double> volumes(pieces_.count);
    for (const MeshTriangle& t : mesh.triangles) {
      volumes[pieces_.of_point[t[0]]] +=
          dot(place(mesh.points[t[0]]), cross(place(mesh.points[t[1]]), place(mesh.points[t[2]])));
    }
    return volumes;
  }

  /// The merged surface as a mesh whose points have the numbers of full ones.
  void take(const CellSurface& merged) {
    mesh_.points = full_.points;
    mesh_.triangles.clear();
    attached_.first.clear();
    attached_.next = merged.next;
    nearest_.assign(full_.points.size(), CellSurface::kNone);
    for (std::size_t point = 0; point < merged.places.size(); ++point) {
      if (merged.levels[point] < 0 || merged.owners[point] != point) continue;
      const Point3 placed = sum(merged.places[point], origin_);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        mesh_.points[point][axis] = static_cast<float>(placed[axis]);
      }
    }
    for (std::size_t i = 0; i < merged.triangles.size(); ++i) {
      if (merged.is_left[i] == 0) continue;
      const auto number = static_cast<std::uint32_t>(mesh_.triangles.size());
      mesh_.triangles.push_back(merged.triangles[i]);
      attached_.first.push_back(merged.first[i]);
      for (std::uint32_t point = merged.first[i]; point != CellSurface::kNone;
           point = merged.next[point]) {
        nearest_[point] = number;
      }
    }
  }

  /// Finds points of the merged surface that triangles fail at; true where only crossing ones do.
  bool prove() {
    failing_.clear();
    const TriangleTree tree(mesh_);
    const auto fail = [&](const MeshTriangle& t) {
      failing_.insert(failing_.end(), t.begin(), t.end());
    };

    // What of the full surface is near
    const std::vector<std::uint32_t> full_far =
        unproven_triangles(full_, tree, deviation_, progress_, nearest_);
    for (const std::uint32_t triangle : full_far) {
      for (const std::uint32_t point : full_.triangles[triangle]) {
        fail(mesh_.triangles[nearest_[point]]);
      }
    }

    // What of the merged surface is near, crosses another triangle or is turned inside out
    std::vector<std::uint32_t> all(mesh_.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    const PointTriangles fans(mesh_);
    const std::vector<std::uint32_t> far = unproven_triangles(
        mesh_, all, tree_, deviation_, {attached_, fans, fans_}, progress_);
    for (const std::uint32_t triangle : far) fail(mesh_.triangles[triangle]);
    const std::vector<double> volumes = piece_volumes(mesh_);
    bool is_turned = false;
    for (const MeshTriangle& t : mesh_.triangles) {
      const std::uint32_t piece = pieces_.of_point[t[0]];
      if (is_held_[piece] || (volumes[piece] > 0) == (volumes_[piece] > 0)) continue;
      is_turned = true;
      fail(t);
    }
    const std::vector<std::uint32_t> crossing = crossing_triangles(tree, progress_);
    crossing_count_ = crossing.size();
    for (const std::uint32_t triangle : crossing) fail(mesh_.triangles[triangle]);
    return full_far.empty() && far.empty() && !is_turned;
  }

  /// Keeps the next round from merging the cells of failing points; false where none was merged.
  bool keep_cells(const CellSurface& merged, int round) {
    std::vector<bool> is_failing(full_.points.size());
    bool is_changed = false;
    for (const std::uint32_t point : failing_) {
      if (merged.levels[point] < 0 || is_failing[point]) continue;
      is_failing[point] = true;
      is_changed = true;
      const auto level = static_cast<std::size_t>(merged.levels[point]);
      rules_.kept[level].push_back(rules_.codes[point] >> (3 * level));
    }
    for (std::vector<std::uint64_t>& kept : rules_.kept) std::sort(kept.begin(), kept.end());
    if (round < kCellLockingRound) return is_changed;
    for (std::size_t point = 0; point < merged.owners.size(); ++point) {
      std::size_t owner = point;
      while (merged.owners[owner] != owner) owner = merged.owners[owner];
      if (is_failing[owner]) rules_.is_locked[point] = 1;
    }
    return is_changed;
  }

  /// Without the points that no triangle has.
  Decimated compacted(int rounds) const {
    std::vector<std::uint32_t> numbers(mesh_.points.size(), CellSurface::kNone);
    Decimated result{{}, rounds, crossing_count_, {}};
    const auto number_of = [&](std::uint32_t point) {
      std::uint32_t& number = numbers[point];
      if (number == CellSurface::kNone) {
        number = static_cast<std::uint32_t>(result.mesh.points.size());
        result.mesh.points.push_back(mesh_.points[point]);
      }
      return number;
    };
    for (const MeshTriangle& t : mesh_.triangles) {
      result.mesh.triangles.push_back({number_of(t[0]), number_of(t[1]), number_of(t[2])});
    }
    for (const std::uint32_t point : locked_) result.locked.push_back(number_of(point));
    return result;
  }

  const TriangleMesh& full_;
  std::vector<std::uint32_t> locked_;
  Progress& progress_;
  Point3 origin_;         // near which places are computed
  PointTriangles fans_;   // of the full surface
  TriangleTree tree_;     // of the full surface
  MeshPieces pieces_;     // of the full surface
  std::vector<bool> is_held_;      // pieces with locked points
  std::vector<double> volumes_;    // of pieces
  double deviation_ = 0;           // that is proven
  CellRules rules_;
  CellSurface start_;
  TriangleMesh mesh_;              // of the round, as all below
  AttachedPoints attached_;        // full points to its triangles
  std::vector<std::uint32_t> nearest_;  // of full points: the triangle they are attached to
  std::vector<std::uint32_t> failing_;  // points
  std::uint64_t crossing_count_ = 0;
};

}  // namespace

Decimated decimate_by_cells(const TriangleMesh& full, const DecimationOptions& options,
                            Progress& progress) {
  const std::vector<std::uint32_t> locked(options.locked.begin(), options.locked.end());
  if (full.triangles.empty()) return {full, 0, 0, locked};
  require_numbered(full.triangles.size());
  const auto& [x, y, z] = options.geometry.spacing_mm;
  if (options.max_deviation_mm <= 2 * kCellMargin * std::min({x, y, z})) {
    return {full, 0, crossing_triangles(TriangleTree(full), progress).size(), locked};
  }
  return CellDecimation(full, options, progress).run();
}

}  // namespace octavo
