#include "octavo/mesh/hexahedra/hex_cells.h"

#include <algorithm>
#include <cstddef>

#include "octavo/core/error.h"
#include "octavo/mesh/hexahedra/hex_fan.h"
#include "octavo/mesh/hexahedra/hex_nodes.h"
#include "octavo/mesh/hexahedra/leaf_balance.h"

namespace octavo {

namespace {

/// Calls visit(leaf, place of its label) for the leaves that count.
template <class Visit>
void visit_leaves(const LabelTree& tree, const MaskTree* within, Visit&& visit) {
  for_each_leaf(tree, [&](const OCode& leaf, std::uint32_t label) {
    if (within == nullptr || within->contains(corner_of(leaf))) visit(leaf, label);
  });
}

std::vector<HexCell> voxel_cells(const LabelTree& tree, const MaskTree* within,
                                 const RequireBytes& require) {
  std::uint64_t count = 0;
  visit_leaves(tree, within, [&](const OCode& leaf, auto) { count += cube_volume(leaf.level); });
  if (count > kMostHexNodes) {
    throw Error(ErrorKind::limit_exceeded,
                "the mesh has " + std::to_string(count) + " voxels; solvers number 2147483647")
        .with_field("level");
  }
  require(count * sizeof(HexCell));
  std::vector<HexCell> cells;
  cells.reserve(count);
  visit_leaves(tree, within, [&](const OCode& leaf, std::uint32_t label) {
    const std::uint64_t first = leaf.code << 3 * leaf.level;
    for (std::uint64_t i = 0; i < cube_volume(leaf.level); ++i) {
      cells.push_back(cell_of({0, first + i}));
      cells.back().label = label;
    }
  });
  return cells;
}

std::vector<HexCell> cells_of_leaves(const std::vector<OCode>& leaves) {
  std::vector<HexCell> cells;
  cells.reserve(leaves.size());
  for (const OCode& leaf : leaves) cells.push_back(cell_of(leaf));
  return cells;
}

/// Balanced leaves, those with a lone quarter halved and balanced again until there are none.
std::vector<OCode> without_lone_quarters(std::vector<OCode> leaves, const RequireBytes& require,
                                         const Progress& watcher) {
  for (;;) {
    const std::vector<HexCell> cells = cells_of_leaves(leaves);
    const HexNodes nodes(cells, watcher);
    require(nodes.memory_bytes() + cells.size() * (sizeof(HexCell) + sizeof(OCode)));
    HexNodes::Near near;
    LeafBalance balance;
    bool has_lone = false;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i].level == 0 || !has_lone_quarter(nodes.points_of(cells[i], near))) {
        balance.add(leaves[i]);
        continue;
      }
      has_lone = true;
      for (const OCode& child : children_of(leaves[i])) balance.add(child);
    }
    if (!has_lone) return leaves;
    require(balance.memory_bytes());
    leaves = balance.finish(watcher);
  }
}

}  // namespace

std::vector<HexCell> hex_cells(const LabelTree& tree, const HexCellOptions& options,
                               const RequireBytes& require) {
  if (options.method == HexMethod::uniform) return voxel_cells(tree, options.within, require);
  LeafBalance balance;
  std::size_t count = 0;
  visit_leaves(tree, options.within, [&](const OCode& leaf, auto) {
    balance.add(leaf);
    constexpr std::size_t kLeavesBetween = 1 << 20;
    if (++count % kLeavesBetween == 0) require(balance.memory_bytes());
  });
  require(balance.memory_bytes() + 2 * count * (sizeof(OCode) + sizeof(HexCell)));
  const NoProgress nobody;
  const Progress& watcher = options.watcher != nullptr ? *options.watcher : nobody;
  std::vector<OCode> leaves = balance.finish(watcher);
  if (options.halves_lone_quarters) {
    leaves = without_lone_quarters(std::move(leaves), require, watcher);
  }
  std::vector<HexCell> cells = cells_of_leaves(leaves);

  // A leaf that fell into smaller ones has left its label to them.
  std::size_t next = 0;
  visit_leaves(tree, options.within, [&](const OCode& leaf, std::uint32_t label) {
    while (next < leaves.size() && contains(leaf, leaves[next])) cells[next++].label = label;
  });
  return cells;
}

}  // namespace octavo
