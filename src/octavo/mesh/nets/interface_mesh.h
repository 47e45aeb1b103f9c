// The surfaces between labels as triangles, and the closed surface of each label out of them.
//
// Neighbors share their triangles, so what is cut out for each label fits exactly. A side of quads
// along which a label touches itself has a point in its middle: otherwise two sides of that label
// could join the same two points.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "octavo/mesh/nets/net_smoothing.h"
#include "octavo/mesh/nets/surface_net.h"
#include "octavo/mesh/surface_frame.h"

namespace octavo {

struct InterfaceMesh {
  TriangleMesh mesh;  ///< triangles counterclockwise where they are seen from the outside label
  std::vector<std::uint32_t> pair_of;  ///< of each triangle: the number of its pair
  /// Of each triangle, 4 bits for each corner, as fan_at takes them: which fan of its label it
  /// belongs to there, since a label may touch itself at a point.
  std::vector<std::uint16_t> fans;
  std::vector<LabelPair> pairs;  ///< inside, outside

  std::uint32_t fan_at(std::size_t triangle, std::size_t corner, std::size_t side) const {
    return static_cast<std::uint32_t>(fans[triangle]) >> (4 * corner + 2 * side) & 3;
  }
  std::uint64_t memory_bytes() const noexcept {
    return mesh.memory_bytes() + pair_of.capacity() * sizeof(std::uint32_t) +
           fans.capacity() * sizeof(std::uint16_t);
  }
};

/// The triangles of a net; points keep their numbers, those in the middles of sides come behind.
/// offsets  of the points from their corners; empty: they have not moved
InterfaceMesh interface_mesh(const SurfaceNet& net, std::span<const NetOffset> offsets,
                             const SurfaceFrame& frame);

/// Cuts out the surfaces of labels, one at a time.
class LabelParts {
 public:
  /// The mesh outlives this.
  /// Memory  8 bytes per triangle, 4 per point
  explicit LabelParts(const InterfaceMesh& interfaces);

  /// All but 0, ascending.
  const std::vector<std::int64_t>& labels() const { return labels_; }

  /// The surface of a label: closed and manifold, triangles outward. Where the label touches itself
  /// points stand at one place. Requires a label that is there.
  TriangleMesh cut(std::int64_t label);

  /// The points of the part cut last that stand at one place with others of it, ascending.
  const std::vector<std::uint32_t>& touching() const { return touching_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  const InterfaceMesh& interfaces_;
  std::vector<std::int64_t> labels_;
  std::vector<std::size_t> ends_;         // behind the triangles of each label
  std::vector<std::uint32_t> triangles_;  // label after label
  std::vector<std::uint32_t> numbers_;    // of points in the part, of their first fans
  std::vector<std::uint32_t> touching_;   // of the part cut last
};

/// How many voxels have each label but 0, counted by the quads around them.
/// is_mirrored  as of the frame
std::map<std::int64_t, std::int64_t> voxel_counts(const SurfaceNet& net, bool is_mirrored);

}  // namespace octavo
