#include "octavo/mesh/octree_decimation/octree_decimation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/vectors.h"
#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/certificate.h"
#include "octavo/mesh/decimation_frame.h"
#include "octavo/mesh/octree_decimation/cell_merging.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/point_triangles.h"
#include "octavo/mesh/triangle_tree.h"
#include "octavo/octree/o_code.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr double kCellToleranceShare = 0.8;  // of the deviation, for attached points
constexpr int kCellLockingRound = 2;         // from which nothing in a failing cell merges

class CellDecimation {
 public:
  CellDecimation(const TriangleMesh& full, const DecimationOptions& options, Progress& progress)
      : full_(full),
        progress_(progress),
        frame_(full, options),
        fans_(full),
        tree_(full) {
    set_rules(options);
    set_surface();
  }

  Decimated run() {
    for (int round = 0;; ++round) {
      const ProgressScope scope(progress_, "fewer triangles, round " + std::to_string(round + 1),
                                2, "steps");
      stop_if_cancelled(progress_);
      CellSurface merged = start_;
      merge_cells(merged, rules_);
      progress_.advance(1);
      take(merged);
      const bool is_proven = prove();
      progress_.advance(1);
      if (failing_.empty()) return frame_.compacted(mesh_, round + 1, crossing_count_);
      if (keep_cells(merged, round)) continue;
      if (is_proven) return frame_.compacted(mesh_, round + 1, crossing_count_);
      return frame_.undecimated(round + 1, tree_, progress_);
    }
  }

 private:
  void set_rules(const DecimationOptions& options) {
    const std::size_t count = full_.points.size();
    rules_.tolerance = kCellToleranceShare * options.max_deviation_mm;
    rules_.full_places.resize(count);
    rules_.codes.resize(count);
    rules_.is_locked.resize(count);
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      rules_.full_places[i] = frame_.place(full_.points[i]);
      const Point3 index = options.geometry.to_index(place_of_point(full_.points[i]));
      const auto cell = [&](std::size_t axis) {
        // Surfaces begin a voxel before the first one.
        return std::max(std::int64_t{0}, static_cast<std::int64_t>(std::floor(index[axis])) + 2);
      };
      rules_.codes[i] = interleave({cell(0), cell(1), cell(2)});
    });
    for (const std::uint32_t point : options.locked) rules_.is_locked[point] = 1;
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
    parallel_for(std::size_t{0}, full_.triangles.size(), [&](std::size_t i) {
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

  /// The merged surface as a mesh whose points have the numbers of full ones.
  void take(const CellSurface& merged) {
    mesh_.points = full_.points;
    mesh_.triangles.clear();
    attached_.first.clear();
    attached_.next = merged.next;
    nearest_.assign(full_.points.size(), CellSurface::kNone);
    for (std::size_t point = 0; point < merged.places.size(); ++point) {
      if (merged.levels[point] < 0 || merged.owners[point] != point) continue;
      mesh_.points[point] = frame_.point_at(merged.places[point]);
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
        unproven_triangles(full_, tree, frame_.deviation(), progress_, nearest_);
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
        mesh_, all, tree_, frame_.deviation(), {attached_, fans, fans_}, progress_);
    for (const std::uint32_t triangle : far) fail(mesh_.triangles[triangle]);
    const std::vector<std::uint32_t> turned = frame_.turned_triangles(mesh_);
    for (const std::uint32_t triangle : turned) fail(mesh_.triangles[triangle]);
    const std::vector<std::uint32_t> crossing = crossing_triangles(tree, progress_);
    crossing_count_ = crossing.size();
    for (const std::uint32_t triangle : crossing) fail(mesh_.triangles[triangle]);
    return full_far.empty() && far.empty() && turned.empty();
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

  const TriangleMesh& full_;
  Progress& progress_;
  DecimationFrame frame_;
  PointTriangles fans_;            // of the full surface
  TriangleTree tree_;              // of the full surface
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
  if (auto full_surface = undecimated(full, options, progress)) return *std::move(full_surface);
  return CellDecimation(full, options, progress).run();
}

}  // namespace octavo
