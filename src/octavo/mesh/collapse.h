// Part of a surface with fewer triangles: edges are collapsed while the surface stays within a
// tolerance of the points it had.
//
// Every point of the full surface is attached to a triangle, near which it lies. A collapse is made
// only when
//   the surface keeps its topology: the two ends have just two neighbors in common,
//   no normal turns by more than about 78 degrees and no triangle becomes a sliver,
//   all points attached around the edge lie within their tolerance of a new triangle,
// and then they are attached to that one. Collapses are made in the order of their costs, sums of
// squared distances to planes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/mesh/cost_heap.h"
#include "octavo/mesh/quadric.h"
#include "octavo/mesh/triangle_crossing.h"

namespace octavo {

struct CollapseVertex {
  Point3 place{};
  Quadric quadric;
  bool is_locked = false;  ///< stays where it is
};

/// A point of the full surface.
struct AttachedPoint {
  Point3 place{};
  double squared_tolerance = 0;
  int next = -1;  ///< attached to the same triangle
};

struct CollapseTriangle {
  std::array<int, 3> corners{};
  int first_point = -1;  ///< attached to it
  bool is_left = true;   ///< not collapsed
};

/// One part; `run` changes it in place. The result depends on nothing else.
class CollapsePart {
 public:
  std::vector<CollapseVertex> vertices;
  std::vector<CollapseTriangle> triangles;
  std::vector<AttachedPoint> points;

  /// Empties the part, keeping its memory.
  void clear();

  /// tolerance  the largest root mean square distance to the planes of a vertex
  /// progress   is asked whether to stop, and told nothing
  /// Throws     Error{cancelled}
  void run(double tolerance, const Progress& progress);

 private:
  /// An edge to collapse, as its ends were when its cost was computed.
  struct Candidate {
    int a = 0;
    int b = 0;
    std::uint32_t a_stamp = 0;
    std::uint32_t b_stamp = 0;
  };
  /// The triangles around a vertex: a run of around_.
  struct Fan {
    std::size_t first = 0;
    std::uint32_t count = 0;
    std::uint32_t stamp = 0;  ///< grows when the vertex changes
  };
  /// A triangle as it would be, and its unit normal.
  struct NewTriangle {
    TrianglePlaces places;
    Point3 normal;
  };

  void find_fans();
  bool find_place(int a, int b, Point3& place, double& cost) const;
  void push(int a, int b);
  bool collapse(int a, int b);
  void find_star(int keep, int gone);
  bool keeps_topology(int keep, int gone);
  bool keeps_shapes(int keep, int gone, const Point3& place);
  bool keeps_points();
  bool take_point(int point, int own);
  void commit(int keep, int gone, const Point3& place);
  int opposite(int triangle, int a, int b) const;

  double squared_tolerance_ = 0;
  std::vector<Fan> fans_;
  std::vector<int> around_;
  std::vector<Candidate> candidates_;  // in the order in which they were found
  CostHeap heap_;                      // of candidates_
  std::vector<int> marks_;
  int mark_ = 0;
  // Of the collapse that is tried.
  std::vector<int> star_;             // triangles that stay
  std::vector<int> lost_;             // the two at the edge
  std::array<int, 2> sides_{};        // the vertices opposite to the edge
  std::vector<NewTriangle> renewed_;  // of star_
  std::vector<std::array<int, 2>> moved_;  // point, and its place in star_
};

}  // namespace octavo
