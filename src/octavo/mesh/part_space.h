// A part of a mesh while its edges are collapsed, and the numbers that its points have in the mesh.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "octavo/mesh/collapse.h"

namespace octavo {

/// What a thread works with.
struct PartSpace {
  static constexpr std::uint32_t kNoPoint = 0xffffffff;

  CollapsePart part;
  std::vector<std::uint32_t> points;    // of the mesh, by vertex of the part
  std::vector<std::uint32_t> attached;  // points of the full surface, by point of the part
  std::vector<std::pair<std::uint32_t, int>> table;  // points and their vertices, by hash

  /// Empties the space for some triangles, keeping its memory.
  void clear(std::size_t triangle_count) {
    part.clear();
    points.clear();
    attached.clear();
    table.assign(std::bit_ceil(4 * triangle_count), {kNoPoint, -1});
  }

  /// The vertex of a point, -1 before it has one.
  int& vertex_of(std::uint32_t point) {
    const std::size_t mask = table.size() - 1;
    std::size_t at = (point * 0x9e3779b1u) & mask;
    while (table[at].first != point && table[at].first != kNoPoint) at = (at + 1) & mask;
    table[at].first = point;
    return table[at].second;
  }
};

}  // namespace octavo
