// A cube divided into pyramids and tetrahedra around its center, so that the corners of smaller
// neighbors on its border are corners of elements.
//
// Points of a cube are numbered x + 3 y + 9 z with coordinates 0, 1, 2: corners, middles of edges
// and faces, and the center, 13. A face is divided by what lies on it alone, so that two cubes that
// share it divide it alike:
//
//     o-----o     o--o--o     o--o--o      no middles: one square
//     |     |     | / \ |     |  |  |      some, but not that of the face: triangles around one of
//     |     |     |/   \|     o--o--o        them, the one with the smallest number on the face
//     o-----o     o-----o     |  |  |      that of the face too: squares of half the side where the
//                             o--o--o        middles of both edges are there, else triangles
//
// Consequences
//   All elements have volume, and that of all is the cube's.
//   A square lies on one cell of the same size on each side; triangles lie on triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace octavo {

enum class HexShape : std::uint8_t { hexahedron, pyramid, tetrahedron };

constexpr int point_count(HexShape shape) noexcept {
  return shape == HexShape::hexahedron ? 8 : shape == HexShape::pyramid ? 5 : 4;
}

inline constexpr std::uint8_t kFanCenter = 13;

/// An element whose base lies on a face of the cube and whose last point is the center; seen from
/// there its base runs counterclockwise.
struct FanElement {
  HexShape shape = HexShape::pyramid;
  std::uint8_t face = 0;  ///< 2 * axis + whether it is the upper one
  std::array<std::uint8_t, 5> points{};
};

/// The four corners of a face, counterclockwise seen from inside the cube.
std::array<std::uint8_t, 4> face_corners(int face) noexcept;

/// The elements of a cube.
/// points  a bit for each point that is there; corners are
std::vector<FanElement> fan_of(std::uint32_t points);

/// Whether no two middles of opposite edges lie on a face in whose middle a point lies: a face on
/// which a single smaller cube lies.
bool has_lone_quarter(std::uint32_t points) noexcept;

}  // namespace octavo
