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

 private:
  CornerFans();

  std::array<std::array<std::uint8_t, kFaces>, 256> fans_{};
  std::array<bool, 256> is_touching_{};
};

/// Classes of the voxels of a corner, 3 bits each: equal where their labels are equal.
using CornerClasses = std::uint32_t;

/// The voxels of the class that a voxel has.
inline CornerMask class_mask(CornerClasses classes, std::size_t voxel) {
  constexpr std::uint32_t kOnes = 011111111;  // one bit of each class
  // Those that differ from the voxel's in any bit
  const std::uint32_t others = classes ^ (classes >> 3 * voxel & 7) * kOnes;
  std::uint32_t mask = ~(others | others >> 1 | others >> 2) & kOnes;
  // Every third bit joined
  mask = (mask | mask >> 2) & 0x0c30c3u;
  mask = (mask | mask >> 4) & 0x00f00fu;
  return static_cast<CornerMask>(mask | mask >> 8);
}

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
};

/// Whether a label touches itself along an edge: it has two voxels there that share no face, and
/// neither of the others.
bool is_crossed(CornerClasses classes, const CornerEdge& edge);

/// Which of the surfaces of its label that meet along an edge a voxel's is, 0 or 1; 0 where its
/// label has but one.
unsigned edge_fan(CornerClasses classes, const CornerEdge& edge, std::size_t voxel);

}  // namespace octavo
