#include "octavo/mesh/layered_decimation/decimation_window.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/mesh/mesh_room.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/point_triangles.h"
#include "octavo/mesh/quiet_progress.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

namespace {

constexpr std::uint32_t kNoTriangle = TriangleTree::kNone;
constexpr std::uint32_t kNoPoint = 0xffffffff;

/// Whether a triangle has the side from one point to another.
bool has_side(const TriangleMesh& mesh, const PointTriangles& fans, std::uint32_t from,
              std::uint32_t to) {
  const auto fan = fans.of(from);
  return std::any_of(fan.begin(), fan.end(), [&](std::uint32_t triangle) {
    const MeshTriangle& t = mesh.triangles[triangle];
    return (t[0] == from && t[1] == to) || (t[1] == from && t[2] == to) ||
           (t[2] == from && t[0] == to);
  });
}

/// Whether some of a triangle may lie within a distance of a triangle of the tree.
bool is_near(const TriangleTree& tree, const TrianglePlaces& t, double distance) {
  const Point3 middle = scaled(sum(sum(t[0], t[1]), t[2]), 1.0 / 3);
  double squared = 0;
  for (const Point3& corner : t) {
    const Point3 from = difference(corner, middle);
    squared = std::max(squared, dot(from, from));
  }
  return tree.nearest(middle, distance + std::sqrt(squared)).triangle != kNoTriangle;
}

/// Of each triangle of the full surface whether the triangles that prove it are all fixed.
template <class IsFixed>
std::vector<std::uint8_t> proven_by_fixed(const DecimationProof& proof, IsFixed&& is_fixed) {
  std::vector<std::uint8_t> is_proven = proof.is_by_attached;
  for (std::size_t i = 0; i < proof.searched.proven.size(); ++i) {
    const std::span<const std::uint32_t> by = proof.searched.of(i);
    is_proven[proof.searched.proven[i]] = std::all_of(by.begin(), by.end(), is_fixed) ? 1 : 0;
  }
  return is_proven;
}

}  // namespace

DecimationWindow::DecimationWindow(const DecimationOptions& options) : options_(options) {
  const Geometry& geometry = options.geometry;
  plane_of_origin_ = geometry.to_index({0, 0, 0})[2];
  double squared = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Point3 unit = {0, 0, 0};
    unit[axis] = 1;
    plane_factors_[axis] = geometry.to_index(unit)[2] - plane_of_origin_;
    squared += plane_factors_[axis] * plane_factors_[axis];
  }
  planes_near_ = options.max_deviation_mm * std::sqrt(squared);
}

double DecimationWindow::plane_of(const MeshPoint& point) const {
  return dot(plane_factors_, place_of_point(point)) + plane_of_origin_;
}

void DecimationWindow::add_points(std::span<const MeshPoint> points) {
  const std::size_t count = full_.points.size() + points.size();
  if (count >= kNoPoint) {
    throw Error(ErrorKind::limit_exceeded,
                "a part of the surface has " + std::to_string(count) + " points, more than " +
                    std::to_string(kNoPoint - 1))
        .with_field("level");
  }
  make_room(numbers_, points.size());
  for (std::size_t number = full_.points.size(); number < count; ++number) {
    numbers_.push_back(static_cast<std::uint32_t>(number));
  }
  make_room(full_.points, points.size());
  full_.points.insert(full_.points.end(), points.begin(), points.end());
}

void DecimationWindow::add_triangles(std::span<const MeshTriangle> triangles) {
  make_room(full_.triangles, triangles.size());
  for (const MeshTriangle& t : triangles) {
    full_.triangles.push_back({numbers_[t[0] - first_number_], numbers_[t[1] - first_number_],
                               numbers_[t[2] - first_number_]});
  }
}

void DecimationWindow::finish_layer() {
  numbers_.erase(numbers_.begin(),
                 numbers_.begin() + static_cast<std::ptrdiff_t>(layer_number_ - first_number_));
  first_number_ = layer_number_;
  layer_number_ = first_number_ + numbers_.size();
}

TriangleMesh DecimationWindow::take_full() { return std::exchange(full_, {}); }

void DecimationWindow::reduce_to(double border_plane, FixedSurface& fixed,
                                 const Progress& progress) {
  reduce({border_plane, false}, fixed, progress);
}

void DecimationWindow::reduce_all(FixedSurface& fixed, const Progress& progress) {
  reduce({std::numeric_limits<double>::infinity(), true}, fixed, progress);
}

void DecimationWindow::reduce(const Reach& reach, FixedSurface& fixed, const Progress& progress) {
  if (full_.triangles.empty() && reduced_.empty()) return;
  require_numbered(full_.triangles.size() + reduced_.size());
  DecimationProof proof;
  std::vector<bool> is_waiting(full_.points.size(), true);
  {
    DecimationStart begun = start();
    for (const auto* triangles : {&full_.triangles, &begun.surface.mesh.triangles}) {
      for (const MeshTriangle& t : *triangles) {
        for (const std::uint32_t point : t) is_waiting[point] = false;
      }
    }
    if (!full_.triangles.empty()) proof = proven(begun, reach, progress);
    if (!proof.is_proven) {
      proof.surface = std::move(begun.surface);
      proof.is_by_attached.assign(full_.triangles.size(), 0);
      proof.searched = {};
    }
  }
  fix_points(proof, reach);
  settle(proof, reach);
  places_ = std::move(proof.surface.mesh.points);
  hand_out(proof, reach, fixed);
  forget_points(is_waiting, fixed);
  kept_count_ = full_.triangles.size();
}

/// The surface as it is: triangles that are fewer already, then new ones of the full surface.
DecimationStart DecimationWindow::start() {
  const std::size_t count = full_.points.size();
  DecimationStart begun;
  begun.reduced_count = reduced_.size();
  TriangleMesh& mesh = begun.surface.mesh;
  mesh.points = std::exchange(places_, {});
  mesh.points.insert(mesh.points.end(),
                     full_.points.begin() + static_cast<std::ptrdiff_t>(mesh.points.size()),
                     full_.points.end());
  mesh.triangles = std::exchange(reduced_, {});
  mesh.triangles.insert(mesh.triangles.end(),
                        full_.triangles.begin() + static_cast<std::ptrdiff_t>(kept_count_),
                        full_.triangles.end());
  nearest_.resize(count, kNoTriangle);
  is_fixed_.resize(count);
  fixed_numbers_.resize(count, kNoPoint);
  volumes_.resize(count);
  begun.surface.nearest = std::exchange(nearest_, {});
  for (std::size_t i = begun.reduced_count; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t point : mesh.triangles[i]) {
      std::uint32_t& nearest = begun.surface.nearest[point];
      if (nearest == kNoTriangle || nearest >= begun.reduced_count) {
        nearest = static_cast<std::uint32_t>(i);
      }
    }
  }
  return begun;
}

/// Points of the full surface at sides beside which it has no triangle any more, or not yet.
std::vector<std::uint32_t> DecimationWindow::border_points() const {
  const PointTriangles fans(full_);
  std::vector<std::uint32_t> points;
  for (const MeshTriangle& t : full_.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = t[k];
      const std::uint32_t to = t[(k + 1) % 3];
      if (has_side(full_, fans, to, from)) continue;
      points.push_back(from);
      points.push_back(to);
    }
  }
  return points;
}

DecimationProof DecimationWindow::proven(const DecimationStart& start, const Reach& reach,
                                         const Progress& progress) const {
  const std::vector<std::uint32_t> border = border_points();
  std::vector<std::uint32_t> locked;
  // What moves comes no nearer to the border than half a plane: it crosses nothing beyond.
  constexpr double kStill = 1.5;  // planes
  for (std::uint32_t point = 0; point < is_fixed_.size(); ++point) {
    const bool is_still = plane_of(full_.points[point]) > reach.border - kStill;
    if (is_fixed_[point] != 0 || is_still) locked.push_back(point);
  }
  DecimationOptions options = options_;
  options.locked = locked;
  DecimationFrame frame(full_, options);
  frame.hold(border);
  QuietProgress quiet(progress);
  return decimate_in_rounds(full_, options, frame, &start, quiet);
}

/// Fixes points that the second pass has taken as far as it does.
void DecimationWindow::fix_points(const DecimationProof& proof, const Reach& reach) {
  const TriangleMesh& mesh = proof.surface.mesh;
  const double last = reach.border - options_.part_side / 2;
  for (const MeshTriangle& t : mesh.triangles) {
    for (const std::uint32_t point : t) {
      if (plane_of(mesh.points[point]) < last) is_fixed_[point] = 1;
    }
  }
}

bool DecimationWindow::is_fixed(const MeshTriangle& t) const {
  return is_fixed_[t[0]] != 0 && is_fixed_[t[1]] != 0 && is_fixed_[t[2]] != 0;
}

/// The triangles that are not fixed, whose points are all of their points.
TriangleMesh DecimationWindow::open_triangles(const TriangleMesh& mesh) const {
  TriangleMesh open;
  for (const MeshTriangle& t : mesh.triangles) {
    if (is_fixed(t)) continue;
    const auto first = static_cast<std::uint32_t>(open.points.size());
    for (const std::uint32_t point : t) open.points.push_back(mesh.points[point]);
    open.triangles.push_back({first, first + 1, first + 2});
  }
  return open;
}

/// Forgets triangles of the full surface that nothing but fixed ones prove, and that prove nothing
/// of what may change; their volumes go to points of fixed ones.
void DecimationWindow::settle(const DecimationProof& proof, const Reach& reach) {
  const AttachedSurface& surface = proof.surface;
  const auto is_fixed_triangle = [&](std::uint32_t triangle) {
    return triangle != kNoTriangle && is_fixed(surface.mesh.triangles[triangle]);
  };
  const std::vector<std::uint8_t> is_proven = proven_by_fixed(proof, is_fixed_triangle);
  const TriangleMesh open = open_triangles(surface.mesh);
  const TriangleTree open_tree(open);
  std::vector<MeshTriangle> kept;
  for (std::size_t i = 0; i < full_.triangles.size(); ++i) {
    const MeshTriangle& t = full_.triangles[i];
    const bool is_settled =
        reach.is_last ||
        (is_proven[i] != 0 && std::all_of(t.begin(), t.end(), [&](std::uint32_t point) {
           return is_fixed_triangle(surface.nearest[point]);
         }) && !is_near(open_tree, places_of(full_, t), options_.max_deviation_mm));
    if (!is_settled) {
      kept.push_back(t);
      continue;
    }
    const TrianglePlaces places = places_of(full_, t);
    std::uint32_t nearest = kNoTriangle;
    for (const std::uint32_t point : t) {
      if (nearest == kNoTriangle) nearest = surface.nearest[point];
    }
    if (nearest == kNoTriangle) continue;
    volumes_[surface.mesh.triangles[nearest][0]] +=
        dot(places[0], cross(places[1], places[2])) / 6;
  }
  full_.triangles = std::move(kept);
}

/// Hands out fixed triangles that nothing which may come can cross; keeps the others.
void DecimationWindow::hand_out(const DecimationProof& proof, const Reach& reach,
                                FixedSurface& fixed) {
  constexpr double kRounding = 1e-3;  // planes
  double first_plane = std::numeric_limits<double>::infinity();
  for (const MeshTriangle& t : full_.triangles) {
    for (const std::uint32_t point : t) {
      first_plane = std::min(first_plane, plane_of(full_.points[point]));
    }
  }
  first_plane -= planes_near_ + kRounding;
  const std::vector<MeshTriangle>& triangles = proof.surface.mesh.triangles;
  std::vector<std::uint32_t> numbers(triangles.size(), kNoTriangle);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const MeshTriangle& t = triangles[i];
    const bool is_near = std::any_of(t.begin(), t.end(), [&](std::uint32_t point) {
      return plane_of(places_[point]) >= first_plane;
    });
    if (!reach.is_last && (is_near || !is_fixed(t))) {
      numbers[i] = static_cast<std::uint32_t>(reduced_.size());
      reduced_.push_back(t);
      continue;
    }
    MeshTriangle& out = fixed.mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& number = fixed_numbers_[t[k]];
      if (number == kNoPoint) {
        number = static_cast<std::uint32_t>(fixed.mesh.points.size());
        fixed.mesh.points.push_back(places_[t[k]]);
        fixed.volumes.push_back(0);
      }
      out[k] = number;
    }
  }
  nearest_ = proof.surface.nearest;
  for (std::uint32_t& nearest : nearest_) {
    if (nearest != kNoTriangle) nearest = numbers[nearest];
  }
}

/// Forgets points that no triangle has and none will have.
void DecimationWindow::forget_points(const std::vector<bool>& is_waiting, FixedSurface& fixed) {
  std::vector<bool> is_kept = is_waiting;
  for (const auto* triangles : {&full_.triangles, &reduced_}) {
    for (const MeshTriangle& t : *triangles) {
      for (const std::uint32_t point : t) is_kept[point] = true;
    }
  }
  std::vector<std::uint32_t> numbers(full_.points.size(), kNoPoint);
  std::vector<MeshPoint> points;
  std::size_t count = 0;
  for (std::size_t point = 0; point < numbers.size(); ++point) {
    if (!is_kept[point]) {
      if (fixed_numbers_[point] != kNoPoint) {
        fixed.volumes[fixed_numbers_[point]] += volumes_[point];
      }
      continue;
    }
    numbers[point] = static_cast<std::uint32_t>(count);
    points.push_back(full_.points[point]);
    places_[count] = places_[point];
    nearest_[count] = nearest_[point];
    is_fixed_[count] = is_fixed_[point];
    fixed_numbers_[count] = fixed_numbers_[point];
    volumes_[count] = volumes_[point];
    ++count;
  }
  full_.points = std::move(points);
  places_.resize(count);
  nearest_.resize(count);
  is_fixed_.resize(count);
  fixed_numbers_.resize(count);
  volumes_.resize(count);
  for (auto* triangles : {&full_.triangles, &reduced_}) {
    for (MeshTriangle& t : *triangles) {
      for (std::uint32_t& point : t) point = numbers[point];
    }
  }
  for (std::uint32_t& number : numbers_) {
    if (number != kNoPoint) number = numbers[number];
  }
}

}  // namespace octavo
