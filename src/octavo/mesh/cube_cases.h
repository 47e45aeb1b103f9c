// The triangles of marching cubes: for each of the 256 ways in which corners of a cube can lie
// inside, how the points on its edges are joined.
//
//          6-------7         corner  x + 2 y + 4 z
//         /|      /|         edges    0..3   along x, of the row  y + 2 z
//        4-------5 |                  4..7   along y, of the row  x + 2 z
//        | 2-----|-3                  8..11  along z, of the row  x + 2 y
//        |/      |/
//        0-------1
//
// The table is computed, by three rules:
//   Inside corners that lie across a face stay separate: what is inside is connected by faces,
//   what is outside by faces and edges.
//   No triangle has a side in a face of the cube that is not one of its loop.
//   Of the triangulations left the first is taken whose triangles cross for no places of the points
//   on their edges: of 16 tries half have random places, half extreme ones.
// Consequences: cubes side by side fit together, so the surface is closed; each of its edges has
// two triangles and each point one fan; it does not cross itself.
//
// Source  thesis 4.1; Lorensen and Cline, Marching cubes, 1987
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace octavo {

/// Edges of a cube whose points are joined, counterclockwise as seen from outside.
using CubeTriangle = std::array<std::uint8_t, 3>;

class CubeCases {
 public:
  static constexpr std::size_t kMostTriangles = 6;

  /// Takes a few milliseconds.
  CubeCases();

  /// The one table of the program, made when it is first asked for. Thread-safe.
  static const CubeCases& shared();

  /// inside  bit c is set when corner c lies inside
  std::span<const CubeTriangle> triangles(std::uint8_t inside) const noexcept {
    return {triangles_[inside].data(), counts_[inside]};
  }

 private:
  std::array<std::array<CubeTriangle, kMostTriangles>, 256> triangles_{};
  std::array<std::uint8_t, 256> counts_{};
};

}  // namespace octavo
