#include "octavo/mesh/decimation_rounds.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/collapse.h"
#include "octavo/mesh/mesh_parts.h"
#include "octavo/mesh/part_space.h"
#include "octavo/mesh/point_triangles.h"
#include "octavo/mesh/triangle_tree.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

constexpr std::uint32_t kNone = TriangleTree::kNone;
constexpr double kToleranceShare = 0.5;      // of the deviation, for attached points
constexpr double kTightened = 0.4;           // of the tolerance where a proof failed
constexpr int kLockingRound = 2;             // from which points are locked instead

/// The surface as it is while it gets fewer triangles. Points keep their numbers.
struct ReducedSurface {
  TriangleMesh mesh;
  std::vector<Quadric> quadrics;       // of points, about the origin
  std::vector<std::uint32_t> nearest;  // of each point of the full surface: its triangle
};

/// What becomes of a part.
struct ReducedPart {
  std::vector<MeshTriangle> triangles;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> attached;  // point, place in triangles
  std::size_t full_count = 0;  // of triangles that it had
};

/// What was proven of the reduced surface of a round.
struct ProvenRound {
  ReducedSurface surface;
  PointTriangles fans;                  // of it
  std::vector<std::uint8_t> is_far;     // its triangles that are not proven
  std::vector<std::uint8_t> is_crossing;

  /// The number here of a triangle of a later surface; kNone where it is another one.
  std::uint32_t number_of(const TriangleMesh& later, const MeshTriangle& triangle) const {
    for (const std::uint32_t number : fans.of(triangle[0])) {
      if (surface.mesh.triangles[number] != triangle) continue;
      const bool is_same =
          std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t point) {
            return surface.mesh.points[point] == later.points[point];
          });
      return is_same ? number : kNone;
    }
    return kNone;
  }
};

class DecimationRounds {
 public:
  DecimationRounds(const TriangleMesh& full, const DecimationOptions& options,
                   const DecimationFrame& frame, const DecimationStart* start, Progress& progress)
      : full_(full),
        start_(start),
        start_mesh_(start != nullptr ? start->surface.mesh : full),
        geometry_(options.geometry),
        part_side_(options.part_side),
        progress_(progress),
        frame_(frame),
        tolerances_(full.points.size(), 1),
        is_frozen_(full.points.size()),
        fans_(full) {
    tolerance_ = kToleranceShare * options.max_deviation_mm;
    for (const std::uint32_t point : options.locked) is_frozen_[point] = true;
    if (start != nullptr) take_start();
  }

  DecimationProof run() {
    const TriangleTree full_tree(full_);
    for (int round = 0;; ++round) {
      // Two passes, what of the full surface is near, what of the reduced one is
      const ProgressScope scope(progress_, "fewer triangles, round " + std::to_string(round + 1),
                                4, "steps");
      reduce_first();
      if (tighten(reduce_second(), full_tree, round)) continue;
      return {{std::move(proven_->surface.mesh), std::move(proven_->surface.nearest)},
              round + 1,
              is_proven_,
              crossing_count_,
              std::move(is_full_proven_),
              std::move(searched_)};
    }
  }

 private:
  Point3 place(const MeshPoint& point) const { return frame_.place(point); }

  /// What the start says is proven as a round before would say it.
  void take_start() {
    const AttachedSurface& surface = start_->surface;
    const std::size_t count = surface.mesh.triangles.size();
    proven_ = ProvenRound{{surface.mesh, {}, surface.nearest}, PointTriangles(surface.mesh),
                          std::vector<std::uint8_t>(count), std::vector<std::uint8_t>(count)};
    std::vector<std::uint8_t> is_taken(full_.points.size());
    for (std::size_t i = 0; i < start_->reduced_count; ++i) {
      for (const std::uint32_t point : surface.mesh.triangles[i]) {
        if (std::exchange(is_taken[point], 1) == 0) reduced_before_.push_back(point);
      }
    }
  }

  /// Calls visit(corner, normal, place, weight) with the plane of a triangle of the start for each
  /// of its corners, where it has an area.
  template <class Visit>
  void visit_planes(const MeshTriangle& t, Visit&& visit) const {
    const Point3 a = place(start_mesh_.points[t[0]]);
    const Point3 normal = cross(difference(place(start_mesh_.points[t[1]]), a),
                                difference(place(start_mesh_.points[t[2]]), a));
    const double length = std::sqrt(dot(normal, normal));
    if (!(length > 0)) return;
    for (std::size_t k = 0; k < 3; ++k) visit(k, scaled(normal, 1 / length), a, length);
  }

  /// Quadrics of points on seams of the first pass, which it keeps.
  void set_seam_quadrics() {
    first_.quadrics.resize(full_.points.size());
    for (const MeshTriangle& t : start_mesh_.triangles) {
      const auto is_seam = [&](std::uint32_t point) { return first_parts_.is_seam[point] != 0; };
      if (std::none_of(t.begin(), t.end(), is_seam)) continue;
      visit_planes(t, [&](std::size_t k, const Point3& normal, const Point3& at, double weight) {
        if (is_seam(t[k])) first_.quadrics[t[k]].add_plane(normal, at, weight);
      });
    }
  }

  /// Quadrics of the other points of a part of the first pass, whose triangles are all there.
  void set_own_quadrics(std::size_t number, PartSpace& space) {
    CollapsePart& part = space.part;
    const auto is_seam = [&](std::size_t vertex) {
      return first_parts_.is_seam[space.points[vertex]] != 0;
    };
    for (std::size_t i = 0; i < part.vertices.size(); ++i) {
      if (!is_seam(i)) part.vertices[i].quadric = {};
    }
    const std::span<const std::uint32_t> triangles = first_parts_.of(number);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      visit_planes(start_mesh_.triangles[triangles[i]],
                   [&](std::size_t k, const Point3& normal, const Point3& at, double weight) {
        const auto vertex = static_cast<std::size_t>(part.triangles[i].corners[k]);
        if (!is_seam(vertex)) part.vertices[vertex].quadric.add_plane(normal, at, weight);
      });
    }
    for (std::size_t i = 0; i < part.vertices.size(); ++i) {
      if (!is_seam(i)) first_.quadrics[space.points[i]] = part.vertices[i].quadric;
    }
  }

  /// The first pass, over the parts whose tolerances have changed.
  void reduce_first() {
    stop_if_cancelled(progress_);
    if (first_parts_.ends.empty()) prepare_first();
    for (std::size_t i = 0; i < is_stale_.size(); ++i) {
      if (is_stale_[i] != 0) touch(i);
    }
    parallel_for(std::size_t{0}, first_parts_.ends.size(), [&](std::size_t i) {
      if (is_stale_[i] == 0 || progress_.is_cancelled()) return;
      is_stale_[i] = 0;
      PartSpace& space = spaces_.local();
      load(start_mesh_, first_.quadrics, first_parts_, i, start_attached_, space);
      set_own_quadrics(i, space);
      space.part.run(tolerance_, progress_);
      store(first_parts_, space, first_, first_reduced_[i]);
    });
    stop_if_cancelled(progress_);
    join(first_reduced_, first_);
    progress_.advance(1);
  }

  /// Remembers the points of a part that is reduced again.
  void touch(std::size_t part) {
    for (const std::uint32_t triangle : first_parts_.of(part)) {
      for (const std::uint32_t point : start_mesh_.triangles[triangle]) is_touched_[point] = 1;
    }
  }

  void prepare_first() {
    first_.mesh.points = start_mesh_.points;
    if (start_ != nullptr) first_.nearest = start_->surface.nearest;
    else attach_to_own();
    start_attached_ = attached_points(first_.nearest, start_mesh_.triangles.size());
    first_parts_ = cut_in_parts(start_mesh_, geometry_, part_side_, 0);
    set_seam_quadrics();
    const std::size_t count = first_parts_.ends.size();
    first_reduced_.resize(count);
    is_stale_.assign(count, 1);
    is_touched_.resize(full_.points.size());
    part_of_.assign(full_.points.size(), 0);
    part_of_vertex_.resize(reduced_before_.empty() ? 0 : full_.points.size());
    for (std::size_t part = 0; part < count; ++part) {
      for (const std::uint32_t triangle : first_parts_.of(part)) {
        for (std::uint32_t point = start_attached_.first[triangle]; point != kNone;
             point = start_attached_.next[point]) {
          part_of_[point] = static_cast<std::uint32_t>(part);
        }
        if (part_of_vertex_.empty()) continue;
        for (const std::uint32_t point : start_mesh_.triangles[triangle]) {
          part_of_vertex_[point] = static_cast<std::uint32_t>(part);
        }
      }
    }
  }

  /// Attaches each point of the full surface to a triangle that has it.
  void attach_to_own() {
    first_.nearest.resize(full_.points.size());
    for (std::size_t i = 0; i < full_.triangles.size(); ++i) {
      for (const std::uint32_t point : full_.triangles[i]) {
        first_.nearest[point] = static_cast<std::uint32_t>(i);
      }
    }
  }

  /// The second pass, its cubes shifted by half their side, over the parts that are others than in
  /// the round before.
  ReducedSurface reduce_second() {
    stop_if_cancelled(progress_);
    PartTriangles parts = cut_in_parts(first_.mesh, geometry_, part_side_, 0.5);
    const AttachedPoints attached = attached_points(first_.nearest, first_.mesh.triangles.size());
    std::vector<ReducedPart> reduced(parts.ends.size());
    ReducedSurface surface;
    surface.mesh.points = first_.mesh.points;
    surface.nearest.assign(first_.nearest.size(), kNone);
    parallel_for(std::size_t{0}, parts.ends.size(), [&](std::size_t i) {
      if (progress_.is_cancelled()) return;
      if (take_unchanged(parts, i, surface.mesh, reduced[i])) return;
      PartSpace& space = spaces_.local();
      load(first_.mesh, first_.quadrics, parts, i, attached, space);
      space.part.run(tolerance_, progress_);
      store(parts, space, surface, reduced[i]);
      reduced[i].full_count = parts.of(i).size();
    });
    stop_if_cancelled(progress_);
    join(reduced, surface);
    second_reduced_ = std::move(reduced);
    second_places_ = std::move(parts.places);
    is_touched_.assign(is_touched_.size(), 0);
    progress_.advance(1);
    return surface;
  }

  /// Takes what became of a part of the second pass in the round before, where it has the triangles
  /// that it had then, none with a point of a part that was reduced again. False for other parts.
  bool take_unchanged(const PartTriangles& parts, std::size_t number, TriangleMesh& mesh,
                      ReducedPart& reduced) {
    const auto before =
        std::lower_bound(second_places_.begin(), second_places_.end(), parts.places[number]);
    if (before == second_places_.end() || *before != parts.places[number]) return false;
    ReducedPart& earlier =
        second_reduced_[static_cast<std::size_t>(before - second_places_.begin())];
    const std::span<const std::uint32_t> triangles = parts.of(number);
    if (earlier.full_count != triangles.size()) return false;
    for (const std::uint32_t triangle : triangles) {
      for (const std::uint32_t point : first_.mesh.triangles[triangle]) {
        if (is_touched_[point] != 0) return false;
      }
    }
    reduced = std::move(earlier);
    for (const MeshTriangle& t : reduced.triangles) {
      for (const std::uint32_t point : t) {
        // Points on seams are where they were, and other parts may have them.
        if (parts.is_seam[point] == 0) mesh.points[point] = proven_->surface.mesh.points[point];
      }
    }
    return true;
  }

  static AttachedPoints attached_points(std::span<const std::uint32_t> nearest,
                                        std::size_t triangle_count) {
    AttachedPoints lists{std::vector<std::uint32_t>(triangle_count, kNone),
                         std::vector<std::uint32_t>(nearest.size(), kNone)};
    for (std::size_t point = nearest.size(); point-- > 0;) {
      if (nearest[point] == kNone) continue;
      std::uint32_t& first = lists.first[nearest[point]];
      lists.next[point] = std::exchange(first, static_cast<std::uint32_t>(point));
    }
    return lists;
  }

  void load(const TriangleMesh& mesh, std::span<const Quadric> quadrics,
            const PartTriangles& parts, std::size_t number, const AttachedPoints& attached,
            PartSpace& space) const {
    CollapsePart& part = space.part;
    space.clear(parts.of(number).size());
    for (const std::uint32_t triangle : parts.of(number)) {
      CollapseTriangle& t = part.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t point = mesh.triangles[triangle][k];
        int& vertex = space.vertex_of(point);
        if (vertex < 0) {
          vertex = static_cast<int>(part.vertices.size());
          part.vertices.push_back({place(mesh.points[point]), quadrics[point],
                                   parts.is_seam[point] != 0 || is_frozen_[point]});
          space.points.push_back(point);
        }
        t.corners[k] = vertex;
      }
      for (std::uint32_t point = attached.first[triangle]; point != kNone;
           point = attached.next[point]) {
        const double tolerance = tolerance_ * static_cast<double>(tolerances_[point]);
        const auto added = static_cast<int>(part.points.size());
        part.points.push_back({place(full_.points[point]), tolerance * tolerance,
                               std::exchange(t.first_point, added)});
        space.attached.push_back(point);
      }
    }
  }

  /// Writes what became of a part. Points that are not on a seam belong to one part
  /// alone.
  void store(const PartTriangles& parts, const PartSpace& space, ReducedSurface& to,
             ReducedPart& reduced) const {
    const CollapsePart& part = space.part;
    for (std::size_t i = 0; i < part.vertices.size(); ++i) {
      const std::uint32_t point = space.points[i];
      if (parts.is_seam[point] != 0) continue;
      to.mesh.points[point] = frame_.point_at(part.vertices[i].place);
      if (to.quadrics.empty() || is_frozen_[point]) continue;
      to.quadrics[point] = part.vertices[i].quadric;
    }
    reduced.triangles.clear();
    reduced.attached.clear();
    for (const CollapseTriangle& t : part.triangles) {
      if (!t.is_left) continue;
      const auto own = static_cast<std::uint32_t>(reduced.triangles.size());
      MeshTriangle& numbers = reduced.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        numbers[k] = space.points[static_cast<std::size_t>(t.corners[k])];
      }
      for (int p = t.first_point; p >= 0; p = part.points[static_cast<std::size_t>(p)].next) {
        reduced.attached.emplace_back(space.attached[static_cast<std::size_t>(p)], own);
      }
    }
  }

  static void join(const std::vector<ReducedPart>& parts, ReducedSurface& surface) {
    surface.mesh.triangles.clear();
    for (const ReducedPart& part : parts) {
      const auto first = static_cast<std::uint32_t>(surface.mesh.triangles.size());
      surface.mesh.triangles.insert(surface.mesh.triangles.end(), part.triangles.begin(),
                                    part.triangles.end());
      for (const auto& [point, triangle] : part.attached) {
        surface.nearest[point] = first + triangle;
      }
    }
  }

  /// What is not proven of a reduced surface.
  struct Failures {
    std::vector<std::uint32_t> full;      // triangles of the full surface
    std::vector<std::uint32_t> far;       // of the reduced one
    std::vector<std::uint32_t> crossing;
  };

  /// Proves both directions and looks for crossing triangles, as far as triangles are others than
  /// in the round before.
  Failures prove(ReducedSurface reduced, const TriangleTree& full_tree) {
    const TriangleMesh& mesh = reduced.mesh;
    const TriangleTree tree(mesh);
    const std::vector<std::uint32_t> earlier = numbers_before(mesh);
    Failures failures;

    // What of the full surface is near
    if (is_full_proven_.empty()) is_full_proven_.resize(full_.triangles.size());
    else forget_moved(reduced, earlier);
    SearchedProofs searched = still_searched(earlier);
    for (const std::uint32_t triangle : searched.proven) is_full_proven_[triangle] = 1;
    const std::size_t known_count = searched.proven.size();
    failures.full = unproven_triangles(full_, tree, frame_.deviation(), progress_,
                                       reduced.nearest, is_full_proven_, &searched);
    for (std::size_t i = 0; i < known_count; ++i) is_full_proven_[searched.proven[i]] = 0;
    searched_ = std::move(searched);
    progress_.advance(1);

    // What of the reduced surface is near, and what crosses
    std::vector<std::uint32_t> far;
    std::vector<std::uint32_t> crossing;
    for (std::uint32_t i = 0; i < earlier.size(); ++i) {
      const bool is_new = earlier[i] == kNone;
      if (is_new || proven_->is_far[earlier[i]] != 0) far.push_back(i);
      if (is_new || proven_->is_crossing[earlier[i]] != 0) crossing.push_back(i);
    }
    PointTriangles fans(mesh);
    const AttachedPoints attached = attached_points(reduced.nearest, mesh.triangles.size());
    failures.far = unproven_triangles(mesh, far, full_tree, frame_.deviation(),
                                      {attached, fans, fans_}, progress_);
    failures.crossing = crossing_triangles(tree, crossing, progress_);
    progress_.advance(1);

    std::vector<std::uint8_t> is_far(earlier.size());
    std::vector<std::uint8_t> is_crossing(earlier.size());
    for (const std::uint32_t triangle : failures.far) is_far[triangle] = 1;
    for (const std::uint32_t triangle : failures.crossing) is_crossing[triangle] = 1;
    proven_ = ProvenRound{std::move(reduced), std::move(fans), std::move(is_far),
                          std::move(is_crossing)};
    return failures;
  }

  /// Of each triangle: its number in the round before.
  std::vector<std::uint32_t> numbers_before(const TriangleMesh& mesh) const {
    std::vector<std::uint32_t> numbers(mesh.triangles.size(), kNone);
    if (!proven_) return numbers;
    parallel_for(std::size_t{0}, numbers.size(), [&](std::size_t i) {
      numbers[i] = proven_->number_of(mesh, mesh.triangles[i]);
    });
    return numbers;
  }

  /// What was proven by a search in the round before and is by the same triangles now.
  SearchedProofs still_searched(const std::vector<std::uint32_t>& earlier) const {
    SearchedProofs still;
    if (!proven_) return still;
    std::vector<std::uint32_t> later(proven_->surface.mesh.triangles.size(), kNone);
    for (std::uint32_t i = 0; i < earlier.size(); ++i) {
      if (earlier[i] != kNone) later[earlier[i]] = i;
    }
    for (std::size_t i = 0; i < searched_.proven.size(); ++i) {
      const std::span<const std::uint32_t> by = searched_.of(i);
      const bool is_same = std::all_of(by.begin(), by.end(), [&](std::uint32_t triangle) {
        return later[triangle] != kNone;
      });
      if (!is_same) continue;
      still.proven.push_back(searched_.proven[i]);
      for (const std::uint32_t triangle : by) still.by.push_back(later[triangle]);
      still.ends.push_back(still.by.size());
    }
    return still;
  }

  /// A triangle of the full surface that its hints proved stays proven while these are the same.
  void forget_moved(const ReducedSurface& reduced, const std::vector<std::uint32_t>& earlier) {
    std::vector<std::uint8_t> is_same(reduced.nearest.size());
    for (std::size_t point = 0; point < is_same.size(); ++point) {
      const std::uint32_t nearest = reduced.nearest[point];
      is_same[point] =
          nearest != kNone && earlier[nearest] == proven_->surface.nearest[point] ? 1 : 0;
    }
    parallel_for(std::size_t{0}, full_.triangles.size(), [&](std::size_t i) {
      const MeshTriangle& t = full_.triangles[i];
      if (is_same[t[0]] == 0 || is_same[t[1]] == 0 || is_same[t[2]] == 0) is_full_proven_[i] = 0;
    });
  }

  /// Makes tolerances smaller where the reduced surface is not proven; false where all of it is, or
  /// where nothing is left that could be made smaller.
  bool tighten(ReducedSurface surface, const TriangleTree& full_tree, int round) {
    stop_if_cancelled(progress_);
    Failures failures = prove(std::move(surface), full_tree);
    const ReducedSurface& reduced = proven_->surface;
    const std::vector<std::uint32_t>& full_failed = failures.full;
    crossing_count_ = failures.crossing.size();
    const std::vector<std::uint32_t> turned = frame_.turned_triangles(reduced.mesh);
    is_proven_ = full_failed.empty() && failures.far.empty() && turned.empty();
    std::vector<std::uint32_t> failed = std::move(failures.far);
    failed.insert(failed.end(), failures.crossing.begin(), failures.crossing.end());
    failed.insert(failed.end(), turned.begin(), turned.end());
    if (full_failed.empty() && failed.empty()) return false;

    const std::vector<bool> is_failed = failed_triangles(failed, full_failed);
    const bool is_locking = round >= kLockingRound;
    bool is_changed = is_locking && freeze_before(is_failed, round - kLockingRound);
    for (std::size_t point = 0; point < tolerances_.size(); ++point) {
      const std::uint32_t nearest = reduced.nearest[point];
      if (nearest == kNone || !is_failed[nearest] || is_frozen_[point]) continue;
      tolerances_[point] *= static_cast<float>(kTightened);
      is_frozen_[point] = is_locking;
      is_stale_[part_of_[point]] = 1;
      is_changed = true;
    }
    return is_changed;
  }

  /// Triangles of the reduced surface that failed with a ring around them, and those that failing
  /// ones of the full surface are attached to.
  std::vector<bool> failed_triangles(const std::vector<std::uint32_t>& failed,
                                     const std::vector<std::uint32_t>& full_failed) const {
    const ReducedSurface& reduced = proven_->surface;
    std::vector<bool> is_near(reduced.mesh.points.size());
    for (const std::uint32_t triangle : failed) {
      for (const std::uint32_t point : reduced.mesh.triangles[triangle]) is_near[point] = true;
    }
    std::vector<bool> is_failed(reduced.mesh.triangles.size());
    for (std::size_t i = 0; i < is_failed.size(); ++i) {
      const MeshTriangle& t = reduced.mesh.triangles[i];
      is_failed[i] = is_near[t[0]] || is_near[t[1]] || is_near[t[2]];
    }
    for (const std::uint32_t triangle : full_failed) {
      for (const std::uint32_t point : full_.triangles[triangle]) {
        if (reduced.nearest[point] != kNone) is_failed[reduced.nearest[point]] = true;
      }
    }
    return is_failed;
  }

  /// Points that the start has moved are attached to nothing: those near triangles that failed stay
  /// where the start has them, with each round those twice as far. False where all of these do
  /// already.
  bool freeze_before(const std::vector<bool>& is_failed, int rounds_before) {
    if (reduced_before_.empty()) return false;
    TriangleMesh failed;
    const TriangleMesh& mesh = proven_->surface.mesh;
    for (std::size_t i = 0; i < is_failed.size(); ++i) {
      if (!is_failed[i]) continue;
      const auto first = static_cast<std::uint32_t>(failed.points.size());
      for (const std::uint32_t point : mesh.triangles[i]) {
        failed.points.push_back(mesh.points[point]);
      }
      failed.triangles.push_back({first, first + 1, first + 2});
    }
    const TriangleTree tree(failed);
    const double distance = std::ldexp(frame_.deviation(), 1 + rounds_before);
    bool is_any = false;
    for (const std::uint32_t point : reduced_before_) {
      if (is_frozen_[point]) continue;
      const Point3 at = place_of_point(start_mesh_.points[point]);
      if (tree.nearest(at, distance).triangle == kNone) continue;
      is_frozen_[point] = true;
      is_stale_[part_of_vertex_[point]] = 1;
      is_any = true;
    }
    return is_any;
  }

  const TriangleMesh& full_;
  const DecimationStart* start_;    // nullptr: the full surface
  const TriangleMesh& start_mesh_;  // what the first pass begins with
  const Geometry& geometry_;
  double part_side_ = 0;  // voxels
  Progress& progress_;
  const DecimationFrame& frame_;
  double tolerance_ = 0;
  std::uint64_t crossing_count_ = 0;
  bool is_proven_ = false;  // all but that no triangles cross
  AttachedPoints start_attached_;
  PartTriangles first_parts_;
  std::vector<ReducedPart> first_reduced_;
  std::vector<std::uint8_t> is_stale_;    // first parts that are to be reduced again
  std::vector<std::uint32_t> part_of_;    // of points: the first part they are attached to
  std::vector<std::uint32_t> reduced_before_;  // points of triangles that the start reduced
  std::vector<std::uint32_t> part_of_vertex_;  // of these: a first part that has them
  std::vector<std::uint8_t> is_touched_;  // points of parts that are reduced again in this round
  std::vector<MeshPartPlace> second_places_;     // of the round before
  std::vector<ReducedPart> second_reduced_;  // of them
  ReducedSurface first_;                  // behind the first pass
  std::optional<ProvenRound> proven_;      // the last one
  std::vector<std::uint8_t> is_full_proven_;  // triangles of the full surface, by their hints alone
  SearchedProofs searched_;                   // others of them that are proven
  PerThread<PartSpace> spaces_;
  std::vector<float> tolerances_;  // of points of the full surface, as shares
  std::vector<bool> is_frozen_;    // points that stay as they are
  PointTriangles fans_;            // of the full surface
};

}  // namespace

DecimationProof decimate_in_rounds(const TriangleMesh& full, const DecimationOptions& options,
                                   const DecimationFrame& frame, const DecimationStart* start,
                                   Progress& progress) {
  return DecimationRounds(full, options, frame, start, progress).run();
}

}  // namespace octavo
