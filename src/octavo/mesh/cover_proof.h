// Proofs that a triangle lies near another surface, by what of that covers it.
//
// The surface is seen along the triangle's normal, from its front:
//
//     the surface   ___/\____/\__        each place of the triangle has one of the surface above
//     the triangle   -----------         or below it, no farther than the surface is high there
//
// From a triangle of the surface all those are visited that hang together where they lie above or
// below. What was visited has no border there, so each place is covered as often as any other,
// counted with signs; one place is counted, and nothing is proven where that gives none. Each
// triangle visited is cut off at the sides and its highest corner taken. Small distances beside
// which rounding is nothing keep every answer safe: near a side a triangle counts as inside.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/point_triangles.h"
#include "octavo/mesh/triangle_crossing.h"

namespace octavo {

/// One at a time; the mesh and its fans must outlive it and stay as they are.
class CoverProof {
 public:
  CoverProof(const TriangleMesh& surface, const PointTriangles& fans, double distance)
      : surface_(surface), fans_(fans), distance_(distance) {}

  /// True only where all of a triangle lies within the distance of the surface. `near` is a point
  /// of the surface from which that is visited.
  bool proves(const TrianglePlaces& triangle, std::uint32_t near);

 private:
  /// A place by the triangle: along its first side, across it, and above it.
  struct Seen {
    double along = 0;
    double across = 0;
    double height = 0;
    std::array<double, 3> inside{};  ///< how far from each side
  };
  using SeenTriangle = std::array<Seen, 3>;

  bool set_up(const TrianglePlaces& triangle);
  Seen seen(std::uint32_t point) const;
  bool visit(std::uint32_t triangle);
  bool is_low(const SeenTriangle& t) const;
  bool count(const SeenTriangle& t);
  bool visit_beside(std::uint32_t from, std::uint32_t to);
  void add(std::uint32_t triangle);

  const TriangleMesh& surface_;
  const PointTriangles& fans_;
  double distance_;
  // Of the triangle that is proven.
  Point3 origin_{};
  Point3 along_{};
  Point3 across_{};
  Point3 normal_{};
  std::array<std::array<double, 3>, 3> sides_{};  ///< factors of along and across, and a number
  std::array<double, 2> counted_{};               ///< the place that is counted
  double longest_ = 0;  ///< side
  double margin_ = 0;
  int covers_ = 0;
  std::vector<std::uint32_t> waiting_;
  std::vector<std::uint32_t> met_;   ///< by hash: triangles that were or will be visited
  std::vector<std::uint32_t> slots_;  ///< of met_ that are taken
};

}  // namespace octavo
