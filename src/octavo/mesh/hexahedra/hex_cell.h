// A cube of voxels as an element of a mesh: what solvers call a hexahedron.
#pragma once

#include <array>
#include <cstdint>

#include "octavo/core/box.h"
#include "octavo/octree/o_code.h"

namespace octavo {

/// A point of the grid of voxel corners: (0, 0, 0) is the lowest corner of the first voxel.
using GridPoint = std::array<std::uint32_t, 3>;

struct HexCell {
  GridPoint corner{};       ///< with the lowest coordinates, a multiple of the side
  std::uint8_t level = 0;   ///< the side is 2^level voxels
  bool is_fan = false;      ///< divided into pyramids and tetrahedra around its center
  std::uint32_t label = 0;  ///< a place in a list of labels

  bool operator==(const HexCell&) const = default;
  std::uint32_t side() const noexcept { return std::uint32_t{1} << level; }
};

inline HexCell cell_of(const OCode& cube) noexcept {
  const Index3 corner = corner_of(cube);
  return {{static_cast<std::uint32_t>(corner.x), static_cast<std::uint32_t>(corner.y),
           static_cast<std::uint32_t>(corner.z)},
          static_cast<std::uint8_t>(cube.level),
          false,
          0};
}

/// The corners of a cube in the order that VTK, Abaqus, Gmsh and MFEM have for hexahedra: around
/// the lower face, then around the upper one.
inline constexpr std::array<std::array<std::uint32_t, 3>, 8> kHexCorners = {
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};

}  // namespace octavo
