// Flat surfaces, which are not closed.
#pragma once

#include <cstdint>

#include "octavo/core/triangle_mesh.h"

namespace octavo::testing {

/// A square of two triangles at height z, of side 8.
inline TriangleMesh square(float z) {
  return {{{0, 0, z}, {8, 0, z}, {8, 8, z}, {0, 8, z}}, {{0, 1, 2}, {0, 2, 3}}};
}

/// The same of 8 x 8 squares, each of two triangles.
inline TriangleMesh fine_square(float z, bool has_hole) {
  TriangleMesh mesh;
  for (int y = 0; y <= 8; ++y) {
    for (int x = 0; x <= 8; ++x) {
      mesh.points.push_back({static_cast<float>(x), static_cast<float>(y), z});
    }
  }
  for (std::uint32_t y = 0; y < 8; ++y) {
    for (std::uint32_t x = 0; x < 8; ++x) {
      if (has_hole && x > 1 && x < 6 && y > 1 && y < 6) continue;
      const std::uint32_t a = y * 9 + x;
      mesh.triangles.push_back({a, a + 1, a + 10});
      mesh.triangles.push_back({a, a + 10, a + 9});
    }
  }
  return mesh;
}

}  // namespace octavo::testing
