// How the surface of a label runs around a corner where eight voxels meet.
//
// Voxels of the corner are numbered dx + 2 dy + 4 dz. Two that share a face have face
// 4 axis + du + 2 dv of it, u and v being the two axes behind `axis` in the order x y z x y. The
// surface of a label consists of the faces between its voxels and others. Around the corner they
// make fans, which are closed: along each of the six edges that meet there a label has no face,
// two, or four where it touches itself. Of four, the two of the same voxel belong together, so that
// voxels that touch at an edge or a corner alone do not hang together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace octavo {

/// Which of the eight voxels have a label.
using CornerMask = std::uint8_t;

/// An edge that ends at the corner.
struct CornerEdge {
  std::size_t axis = 0;
  bool is_upward = false;

  /// One of the four voxels around it; they are numbered du + 2 dv.
  std::size_t voxel(std::size_t around) const {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    return (is_upward ? std::size_t{1} << axis : 0) | (around & 1) << u | (around >> 1) << v;
  }
  /// Which of those four a voxel is.
  std::size_t around(std::size_t voxel) const {
    return (voxel >> (axis + 1) % 3 & 1) | (voxel >> (axis + 2) % 3 & 1) << 1;
  }
  std::size_t number() const { return 2 * axis + (is_upward ? 1 : 0); }
};

/// The surfaces of all labels around a corner: those of each label's mask joined.
class CornerSurfaces {
 public:
  void set_fan(std::size_t face, bool is_above, unsigned fan) {
    bits_ |= std::uint64_t{fan} << (4 * face + (is_above ? 2 : 0));
  }
  /// The label has voxels 0 and 3, or 1 and 2, around an edge, and neither of the others.
  void cross(const CornerEdge& edge, bool is_of_first) {
    bits_ |= std::uint64_t{is_of_first ? 1u : 2u} << (kEdges + 2 * edge.number());
  }
  void join(const CornerSurfaces& other) { bits_ |= other.bits_; }

  /// The fans of the surfaces of both voxels of a face, 2 bits each, the voxel below first.
  /// Requires that their labels differ.
  unsigned fans(std::size_t face) const { return static_cast<unsigned>(bits_ >> 4 * face & 15); }
  /// Whether a label touches itself along an edge: it has two voxels there that share no face, and
  /// neither of the others.
  bool is_crossed(const CornerEdge& edge) const { return crossings(edge) != 0; }
  /// Which of the surfaces of its label that meet along an edge a voxel's is, 0 or 1; 0 where its
  /// label has but one.
  unsigned edge_fan(const CornerEdge& edge, std::size_t voxel) const {
    const std::size_t around = edge.around(voxel);
    if (around < 2) return 0;
    return around == 3 ? crossings(edge) & 1 : crossings(edge) >> 1;
  }

 private:
  static constexpr std::size_t kEdges = 48;  // behind 4 bits for each of 12 faces

  unsigned crossings(const CornerEdge& edge) const {
    return static_cast<unsigned>(bits_ >> (kEdges + 2 * edge.number()) & 3);
  }

  std::uint64_t bits_ = 0;
};

class CornerFans {
 public:
  static constexpr std::size_t kFaces = 12;

  static const CornerFans& shared();

  /// The fan that a face belongs to, 0 to 3. Requires a face of the surface of the mask.
  unsigned fan(CornerMask mask, std::size_t face) const {
    return static_cast<unsigned>(fans_[mask][face]);
  }
  /// Whether there is more than one fan, or an edge with four faces.
  bool is_touching(CornerMask mask) const { return is_touching_[mask]; }
  /// Those of one label.
  const CornerSurfaces& surfaces(CornerMask mask) const { return surfaces_[mask]; }

 private:
  CornerFans();
  void find_surfaces(CornerMask mask);

  std::array<std::array<std::uint8_t, kFaces>, 256> fans_{};
  std::array<bool, 256> is_touching_{};
  std::array<CornerSurfaces, 256> surfaces_{};
};

}  // namespace octavo
