// Label maps as arrays, and the trees and cells that they are.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "octavo/mesh/hexahedra/cell_values.h"
#include "octavo/mesh/hexahedra/hex_cells.h"
#include "octavo/mesh/hexahedra/hex_mesh.h"
#include "support/dense_labels.h"

namespace octavo::testing {

inline constexpr std::int32_t kHexLabels[] = {1, 5};

/// A map of large blocks and grains of two labels, up to 32 voxels a side.
inline DenseLabels hex_labels(std::mt19937& random) {
  const auto side = [&] { return std::int64_t{1} + static_cast<std::int64_t>(random() % 32); };
  return random_labels({side(), side(), side()}, kHexLabels, random);
}

inline std::vector<HexCell> cells_of_tree(const LabelTree& tree, HexMethod method) {
  return hex_cells(tree, {method, nullptr, false}, [](std::uint64_t) {});
}

inline HexMesh hex_mesh_of(const DenseLabels& labels, HexMethod method,
                           const Geometry& geometry = {}) {
  const LabelTree tree = tree_of(labels);
  std::vector<HexCell> cells = cells_of_tree(tree, method);
  CellValues values;
  std::vector<HexGroup> groups = group_by_label(cells, values);
  return HexMesh(geometry, method, {tree.labels().begin(), tree.labels().end()}, std::move(cells),
                 std::move(groups), std::move(values));
}

}  // namespace octavo::testing
