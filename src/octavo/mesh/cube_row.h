// Joins the points of a surface in rows of cubes, 64 cubes at a time.
//
// Cubes are visited by the bits of a word: only those that the surface goes through. An edge that
// the surface cuts is one of such a cube, so numbers of points are counted from cube to cube:
//
//     row y, z      . . 1 1 1 . . 1 .      is a voxel inside?
//     edges x       . . ^ . . ^ . ^ ^      cut: bit x differs from bit x - 1
//     numbers       . . 0 . . 1 . 2 3
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/cube_cases.h"
#include "octavo/mesh/mesh_room.h"

namespace octavo {

/// The bits of 64 voxels of the four rows that a row of cubes lies between: (y-1, z-1), (y, z-1),
/// (y-1, z), (y, z). Bit x of `upper` stands for voxel x, bit x of `lower` for voxel x - 1.
struct CubeWords {
  std::array<std::uint64_t, 4> upper{};
  std::array<std::uint64_t, 4> lower{};

  /// Cubes that the surface goes through; bit x stands for the one whose last voxel is x.
  std::uint64_t cut_cubes() const {
    std::uint64_t any = 0;
    std::uint64_t all = ~std::uint64_t{0};
    for (std::size_t k = 0; k < 4; ++k) {
      any |= upper[k] | lower[k];
      all &= upper[k] & lower[k];
    }
    return any & ~all;
  }
};

/// The next number of a point on edges along x of the four rows; and along y and z of those rows
/// that own them, with the number before, which is that of the edge at voxel x - 1.
struct CubeNumbers {
  std::array<std::uint32_t, 4> x{};
  std::array<std::uint32_t, 2> y{};  ///< of the rows (y, z-1) and (y, z)
  std::array<std::uint32_t, 2> z{};  ///< of the rows (y-1, z) and (y, z)
  std::array<std::uint32_t, 2> y_before{};
  std::array<std::uint32_t, 2> z_before{};
};

/// What the cubes of one word have at most.
inline constexpr std::size_t kMostTrianglesOfWord = 64 * CubeCases::kMostTriangles;

/// Joins the points of a word of cubes, and counts their numbers on.
/// cut  of words.cut_cubes()
template <bool kIsMirrored>
void join_cubes(const CubeCases& cases, const CubeWords& words, std::uint64_t cut,
                CubeNumbers& next, MeshRoom<MeshTriangle>& room) {
  const auto& u = words.upper;
  const auto& l = words.lower;
  MeshTriangle* out = room.next(kMostTrianglesOfWord);
  for (; cut != 0; cut &= cut - 1) {
    const int x = std::countr_zero(cut);
    std::array<std::uint32_t, 4> low;
    std::array<std::uint32_t, 4> high;
    for (std::size_t k = 0; k < 4; ++k) {
      low[k] = static_cast<std::uint32_t>(l[k] >> x) & 1;
      high[k] = static_cast<std::uint32_t>(u[k] >> x) & 1;
    }
    const std::uint32_t inside = low[0] | high[0] << 1 | low[1] << 2 | high[1] << 3 |
                                 low[2] << 4 | high[2] << 5 | low[3] << 6 | high[3] << 7;
    // The points on the 12 edges, as in cube_cases.h; those of edges that are not cut are unset.
    const std::array<std::uint32_t, 12> numbers = {
        next.x[0],        next.x[1], next.x[2],        next.x[3],
        next.y_before[0], next.y[0], next.y_before[1], next.y[1],
        next.z_before[0], next.z[0], next.z_before[1], next.z[1]};
    for (const CubeTriangle& t : cases.triangles(static_cast<std::uint8_t>(inside))) {
      *out++ = {numbers[t[0]], numbers[t[kIsMirrored ? 2 : 1]], numbers[t[kIsMirrored ? 1 : 2]]};
    }
    // Count on
    for (std::size_t k = 0; k < 4; ++k) next.x[k] += low[k] ^ high[k];
    for (std::size_t k = 0; k < 2; ++k) {
      const std::uint32_t along_y = high[2 * k] ^ high[2 * k + 1];
      const std::uint32_t along_z = high[k] ^ high[k + 2];
      next.y_before[k] = next.y[k];
      next.z_before[k] = next.z[k];
      next.y[k] += along_y;
      next.z[k] += along_z;
    }
  }
  room.finish(out);
}

}  // namespace octavo
