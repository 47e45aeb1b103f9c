// A mesh of hexahedra, and of the pyramids and tetrahedra between those of two sizes.
//
// Cells stand group by group: those of one label and, where materials are divided into bins, of one
// bin. Elements are numbered group by group as well, and inside a group the hexahedra first, then
// pyramids, then tetrahedra; a cell that is no fan is one hexahedron.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/mesh/hexahedra/hex_cell.h"
#include "octavo/mesh/hexahedra/hex_fan.h"
#include "octavo/mesh/hexahedra/hex_nodes.h"

namespace octavo {

enum class HexMethod : std::uint8_t {
  uniform,    ///< every voxel a cell
  octree,     ///< the leaves, balanced; nodes hang
  conforming  ///< the leaves, balanced; those at which nodes hang are fans
};

/// Isotropic linear elasticity.
struct HexMaterial {
  double modulus_mpa = 0;
  double density_g_cm3 = 0;
};

struct HexGroup {
  std::uint32_t label = 0;    ///< a place in HexMesh::labels
  std::uint64_t first_cell = 0;
  std::uint64_t end_cell = 0;
  std::uint64_t first_fan = 0;                  ///< of its fans, counted over all groups
  std::array<std::uint64_t, 3> element_counts{};  ///< by shape
  std::optional<HexMaterial> material;          ///< of its bin
  std::uint64_t element_count() const {
    return element_counts[0] + element_counts[1] + element_counts[2];
  }
};

/// What grey values say of the cells: one each, or none where it is not known.
struct CellValues {
  std::vector<float> mean;           ///< of the voxels, real units
  std::vector<float> density_g_cm3;
  std::vector<float> modulus_mpa;
};

/// How good the shapes are, and how large.
struct HexQuality {
  /// Scaled Jacobians: that many elements have that one, ascending.
  std::vector<std::pair<double, std::uint64_t>> scaled_jacobians;
  double min_volume_mm3 = 0;
  double max_volume_mm3 = 0;
  double total_volume_mm3 = 0;

  /// The scaled Jacobian that `percent` of the elements do not reach, 0: the smallest.
  double percentile(double percent) const;
};

class HexMesh {
 public:
  /// cells   group by group
  /// groups  with label, cells and material; the rest is found out
  /// Uses the threads of the calling task arena. Throws  as HexNodes
  HexMesh(const Geometry& geometry, HexMethod method, std::vector<std::int64_t> labels,
          std::vector<HexCell> cells, std::vector<HexGroup> groups, CellValues values,
          const Progress& watcher = NoProgress());

  const Geometry& geometry() const { return geometry_; }
  HexMethod method() const { return method_; }
  const std::vector<std::int64_t>& labels() const { return labels_; }
  const std::vector<HexCell>& cells() const { return cells_; }
  const std::vector<HexGroup>& groups() const { return groups_; }
  const CellValues& values() const { return values_; }
  const HexNodes& corners() const { return nodes_; }
  bool has_materials() const { return !groups_.empty() && groups_.front().material.has_value(); }

  /// Corners of cells, then the centers of fans.
  std::uint64_t node_count() const { return nodes_.count() + fans_.size(); }
  std::uint64_t element_count() const { return element_count_; }
  std::uint64_t fan_count() const { return fans_.size(); }
  /// Nodes that depend on others: none in a conforming mesh.
  std::uint64_t hanging_count() const {
    return method_ == HexMethod::octree ? nodes_.hanging_count() : 0;
  }
  /// The box around all cells.
  const std::array<GridPoint, 2>& bounds() const { return bounds_; }

  /// The place of a point between voxels, mm in LPS.
  Point3 place_of(const std::array<double, 3>& point) const;

  /// Calls visit(place in mm) for all nodes as they are numbered.
  template <class Visit>
  void visit_nodes(Visit&& visit) const;

  /// Calls visit(span of the nodes, cell) for the elements of a shape in a group. Their nodes stand
  /// in the order of VTK, with positive Jacobian also where the grid is mirrored.
  template <class Visit>
  void visit_elements(const HexGroup& group, HexShape shape, Visit&& visit) const;

  /// The same for all elements as they are numbered: visit(shape, nodes, cell).
  template <class Visit>
  void visit_all_elements(Visit&& visit) const;

  /// Calls visit(side, span of the nodes) for the faces of elements on the six sides of the box
  /// around the mesh, 2 * axis + whether it is the upper one; counterclockwise from outside.
  template <class Visit>
  void visit_side_faces(Visit&& visit) const;

  /// O(cells)
  HexQuality quality() const;

  std::uint64_t memory_bytes() const noexcept;

 private:
  void find_fans(const Progress& watcher);
  const std::vector<FanElement>& fan(std::uint64_t number) const {
    return shapes_.at(fans_[number]);
  }
  /// The nodes of the points of a fan.
  std::array<std::uint32_t, 27> fan_nodes(const HexCell& cell, std::uint64_t number) const;
  bool is_on_side(const HexCell& cell, int face) const;
  template <class Visit>
  void visit_cells(const HexGroup& group, Visit&& visit) const;

  Geometry geometry_;
  HexMethod method_;
  std::vector<std::int64_t> labels_;
  std::vector<HexCell> cells_;
  std::vector<HexGroup> groups_;
  CellValues values_;
  HexNodes nodes_;
  bool is_mirrored_ = false;
  std::array<GridPoint, 2> bounds_{};
  std::vector<std::uint32_t> fans_;  ///< the points of each
  std::unordered_map<std::uint32_t, std::vector<FanElement>> shapes_;
  std::uint64_t element_count_ = 0;
};

// ---- implementation of the templates

template <class Visit>
void HexMesh::visit_nodes(Visit&& visit) const {
  nodes_.visit([&](const GridPoint& point, std::uint32_t) {
    visit(place_of({static_cast<double>(point[0]), static_cast<double>(point[1]),
                    static_cast<double>(point[2])}));
  });
  for (const HexCell& cell : cells_) {
    if (!cell.is_fan) continue;
    const double half = 0.5 * cell.side();
    visit(place_of({cell.corner[0] + half, cell.corner[1] + half, cell.corner[2] + half}));
  }
}

template <class Visit>
void HexMesh::visit_cells(const HexGroup& group, Visit&& visit) const {
  std::uint64_t number = group.first_fan;
  for (std::uint64_t i = group.first_cell; i < group.end_cell; ++i) {
    visit(i, number);
    if (cells_[i].is_fan) ++number;
  }
}

template <class Visit>
void HexMesh::visit_elements(const HexGroup& group, HexShape shape, Visit&& visit) const {
  HexNodes::Near near;
  const auto count = static_cast<std::size_t>(point_count(shape));
  visit_cells(group, [&](std::uint64_t cell, std::uint64_t number) {
    if (cells_[cell].is_fan == (shape == HexShape::hexahedron)) return;
    if (shape == HexShape::hexahedron) {
      std::array<std::uint32_t, 8> nodes = nodes_.corners_of(cells_[cell], near);
      if (is_mirrored_) std::rotate(nodes.begin(), nodes.begin() + 4, nodes.end());
      visit(std::span<const std::uint32_t>(nodes), cell);
      return;
    }
    const auto points = fan_nodes(cells_[cell], number);
    for (const FanElement& element : fan(number)) {
      if (element.shape != shape) continue;
      std::array<std::uint32_t, 5> nodes{};
      for (std::size_t i = 0; i < count; ++i) nodes[i] = points[element.points[i]];
      if (is_mirrored_) std::reverse(nodes.begin(), nodes.begin() + (count - 1));
      visit(std::span<const std::uint32_t>(nodes.data(), count), cell);
    }
  });
}

template <class Visit>
void HexMesh::visit_all_elements(Visit&& visit) const {
  for (const HexGroup& group : groups_) {
    for (const HexShape shape :
         {HexShape::hexahedron, HexShape::pyramid, HexShape::tetrahedron}) {
      if (group.element_counts[static_cast<std::size_t>(shape)] == 0) continue;
      visit_elements(group, shape, [&](std::span<const std::uint32_t> nodes, std::uint64_t cell) {
        visit(shape, nodes, cell);
      });
    }
  }
}

template <class Visit>
void HexMesh::visit_side_faces(Visit&& visit) const {
  std::array<std::uint32_t, 4> nodes{};
  const auto outward = [&](std::size_t count) {
    if (!is_mirrored_) std::reverse(nodes.begin(), nodes.begin() + count);
    return std::span<const std::uint32_t>(nodes.data(), count);
  };
  for (const HexGroup& group : groups_) {
    visit_cells(group, [&](std::uint64_t i, std::uint64_t number) {
      const HexCell& cell = cells_[i];
      for (int face = 0; face < 6; ++face) {
        if (!is_on_side(cell, face)) continue;
        if (!cell.is_fan) {
          const auto corners = face_corners(face);
          for (std::size_t k = 0; k < 4; ++k) {
            const std::uint32_t half = cell.side();
            nodes[k] = nodes_.number_at({cell.corner[0] + corners[k] % 3 / 2 * half,
                                         cell.corner[1] + corners[k] / 3 % 3 / 2 * half,
                                         cell.corner[2] + corners[k] / 9 / 2 * half});
          }
          visit(face, outward(4));
          continue;
        }
        const auto points = fan_nodes(cell, number);
        for (const FanElement& element : fan(number)) {
          if (element.face != face) continue;
          const auto count = static_cast<std::size_t>(point_count(element.shape) - 1);
          for (std::size_t k = 0; k < count; ++k) nodes[k] = points[element.points[k]];
          visit(face, outward(count));
        }
      }
    });
  }
}

}  // namespace octavo
