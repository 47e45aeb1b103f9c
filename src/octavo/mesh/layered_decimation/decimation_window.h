// The part of a long surface that is reduced at a time: what layers of blocks added last, and what
// of the layers before may still change.
//
//     planes along z -->
//     done              | kept: fewer already | new: all triangles    | to come
//     fixed for good    | (fixed) | may change again                  |
//     ------------------+---------+-----------+-----------+-----------+
//                                 ^ the last fixed plane  ^ the next  ^ the border: points stay
//
// A window ends at whole parts of the first pass. Parts of the second pass lie across the border,
// so what is nearer to it than half a part is reduced again with the next window. All else is
// fixed. A triangle of the full surface is forgotten when only fixed triangles prove that it is
// near the reduced surface; fixed triangles are handed out when no triangle that comes later, which
// lies near a full one that is kept, can cross them. So windows prove together what decimate proves
// of the whole.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/decimation.h"
#include "octavo/mesh/decimation_rounds.h"

namespace octavo {

/// Triangles that are fixed, in the order in which they were handed out.
struct FixedSurface {
  TriangleMesh mesh;
  /// Of points: a share of the volume that the full surface encloses, mm3. Shares of the points of
  /// a piece make the volume of that piece.
  std::vector<double> volumes;
};

class DecimationWindow {
 public:
  /// options  without locked points; a deviation of at most half the shortest side of a voxel and
  ///          more than a margin; must outlive this
  explicit DecimationWindow(const DecimationOptions& options);

  /// The next points of the full surface, numbered through.
  /// Throws  Error{limit_exceeded} where the window has 2^32 - 1 points or more
  void add_points(std::span<const MeshPoint> points);
  /// The next triangles, of points of the last two layers.
  void add_triangles(std::span<const MeshTriangle> triangles);
  /// Points that come now are of another layer.
  void finish_layer();

  std::uint64_t point_count() const { return full_.points.size(); }
  /// Triangles that were added since the last reduction.
  std::uint64_t new_triangles() const { return full_.triangles.size() - kept_count_; }

  /// Reduces what is there up to a plane, in voxels, behind which other layers may come, and hands
  /// out what is fixed. Uses the threads of the calling task arena.
  /// Throws  Error{cancelled}, as require_numbered
  void reduce_to(double border_plane, FixedSurface& fixed, const Progress& progress);
  /// Reduces the rest, and hands out all of it.
  void reduce_all(FixedSurface& fixed, const Progress& progress);

  /// The full surface, where nothing was reduced. Leaves the window empty.
  TriangleMesh take_full();

 private:
  /// Where surfaces of windows differ: what is behind the border.
  struct Reach {
    double border = 0;  // planes
    bool is_last = false;
  };

  double plane_of(const MeshPoint& point) const;
  void reduce(const Reach& reach, FixedSurface& fixed, const Progress& progress);
  DecimationStart start();
  std::vector<std::uint32_t> border_points() const;
  DecimationProof proven(const DecimationStart& start, const Reach& reach,
                         const Progress& progress) const;
  void fix_points(const DecimationProof& proof, const Reach& reach);
  bool is_fixed(const MeshTriangle& t) const;
  TriangleMesh open_triangles(const TriangleMesh& mesh) const;
  void settle(const DecimationProof& proof, const Reach& reach);
  void hand_out(const DecimationProof& proof, const Reach& reach, FixedSurface& fixed);
  void forget_points(const std::vector<bool>& is_waiting, FixedSurface& fixed);

  const DecimationOptions& options_;
  Point3 plane_factors_{};  // of coordinates, for the plane of a place
  double plane_of_origin_ = 0;
  double planes_near_ = 0;  // how many planes the deviation spans

  // Points have the numbers of the full surface that is left.
  TriangleMesh full_;
  std::size_t kept_count_ = 0;               // of its triangles, the first, that were reduced
  std::vector<MeshPoint> places_;            // of points in the reduced surface
  std::vector<std::uint32_t> nearest_;       // of points: one of reduced_, or none
  std::vector<std::uint8_t> is_fixed_;       // points
  std::vector<std::uint32_t> fixed_numbers_;  // of points among those handed out, or none
  std::vector<double> volumes_;              // of points
  std::vector<MeshTriangle> reduced_;

  // Numbers of the points of the last two layers by those that they came with.
  std::vector<std::uint32_t> numbers_;
  std::uint64_t first_number_ = 0;  // that numbers_ begins with
  std::uint64_t layer_number_ = 0;  // that the last layer begins with
};

}  // namespace octavo
