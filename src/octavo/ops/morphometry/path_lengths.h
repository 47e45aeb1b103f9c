// How much longer than straight the shortest ways through pores are: geodesic tortuosity.
//
// Arrival times of a front that starts from all pores in the first plane across an axis and moves
// in pores alone, at the same speed everywhere, are lengths of shortest ways. They solve the
// eikonal equation |grad t| = 1, by fast marching on the grid of voxels, and are exact for fronts
// along an axis. Tortuosity is their mean over the pores of the last plane that the front reaches,
// over the way straight ahead. It is not the diffusive tortuosity, which is larger.
//
// Source  J. A. Sethian, A fast marching level set method for monotonically advancing fronts,
//         Proceedings of the National Academy of Sciences 93 (1996)
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"

namespace octavo {

struct PathLengths {
  double tortuosity = 1;
  double shortest = 1;        ///< of the pore that is reached first, in the same unit
  double reached_share = 0;   ///< of the pores of the last plane
};

/// Along one axis of a volume of two planes or more; nothing where no way leads through.
/// pores     [z][y][x], not 0 in pores
/// progress  advances by the voxels of pores that the front reaches
/// Throws  Error{cancelled}
/// Memory  5 bytes a voxel, and 12 for each of the voxels on the front
std::optional<PathLengths> path_lengths(const std::vector<std::uint8_t>& pores, const Size3& size,
                                        const Point3& spacing_mm, int axis, Progress& progress);

}  // namespace octavo
