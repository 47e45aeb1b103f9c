// The cells of a mesh out of the octree of a label map.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "octavo/mesh/hexahedra/hex_cell.h"
#include "octavo/mesh/hexahedra/hex_mesh.h"
#include "octavo/octree/label_tree.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// Told how many bytes are needed before they are taken; throws where that is too much.
using RequireBytes = std::function<void(std::uint64_t)>;

struct HexCellOptions {
  HexMethod method = HexMethod::uniform;
  /// Only leaves in it, which must have each leaf whole or not at all: a component; null: all.
  const MaskTree* within = nullptr;
  /// Leaves are halved until no single smaller one lies on a face, as MFEM needs it.
  bool halves_lone_quarters = false;
  const Progress* watcher = nullptr;  ///< null: nobody watches
};

/// The leaves of all labels but 0: as voxels for a uniform mesh, balanced for others; in o-code
/// order, with labels as places in tree.labels(). Uses the threads of the calling task arena; the
/// result does not depend on their number.
/// Throws  as require; Error{cancelled}; Error{limit_exceeded} for cells beyond kMostHexNodes
/// Memory  20 bytes per cell, and while they are balanced that of LeafBalance
std::vector<HexCell> hex_cells(const LabelTree& tree, const HexCellOptions& options,
                               const RequireBytes& require);

}  // namespace octavo
