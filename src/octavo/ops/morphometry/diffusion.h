// How much slower than without obstacles something spreads through pores: the diffusive tortuosity.
//
// A concentration of 1 is held before the first plane across an axis, of 0 behind the last one, and
// nothing passes into what is no pore. At rest the concentration c in the pores solves
// div grad c = 0; what flows through every plane then is the same, J. With D the diffusivity in
// free space,
//
//     D_eff / D = J * length / (D * area)        tortuosity = porosity * D / D_eff
//
// Fluxes pass the faces between voxels; the outermost planes are half a voxel from where 1 and 0
// are held. Pores that do not lead from one side to the other hold still, and count for the
// porosity all the same.
//
// J is the sum of conductance * difference^2 over all faces, which is smallest at rest: it is never
// too small, and too large by the square of how far the concentrations are off alone. They come to
// rest by conjugate gradients, preconditioned by a multigrid over clusters of pores, until J is
// known to about kDiffusionError of itself.
//
// Source  M. R. Hestenes, E. Stiefel, Methods of conjugate gradients for solving linear systems,
//         Journal of Research of the National Bureau of Standards 49 (1952); S. J. Cooper et al.,
//         TauFactor, SoftwareX 5 (2016); pore_clusters.h for those of the multigrid
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"

namespace octavo {

/// Where the steps end: an estimate of the share by which D_eff is too large.
constexpr double kDiffusionError = 1e-8;

struct PoreDiffusion {
  double effective = 0;   ///< D_eff / D
  double tortuosity = 1;  ///< porosity * D / D_eff
  int steps = 0;          ///< of conjugate gradients
  /// An estimate of the share by which D_eff is too large; above kDiffusionError where the steps
  /// ran out.
  double error = 0;
};

/// What pore_diffusion announces of itself.
constexpr std::int64_t kDiffusionParts = 1000;

/// Along one axis; nothing where no pore leads through.
/// pores           [z][y][x], not 0 in pores
/// counted_voxels  that the porosity is a share of, pores and others
/// progress        advances by kDiffusionParts in all, as the logarithm of the error falls
/// Uses the threads of the calling task arena; does not depend on them.
/// Throws  Error{limit_exceeded} as PoreNetwork, Error{cancelled}
/// Memory  41 bytes for each voxel of pores that lead through and 4 for each voxel, and for the
///         multigrid 10 to 25 more for each of these pores, in mazes one voxel wide 45, and up to
///         100 where voxels are long as well; while pores are looked for, 5 for each voxel and 8
///         for each of pores: never more than pore_diffusion_bytes
std::optional<PoreDiffusion> pore_diffusion(const std::vector<std::uint8_t>& pores,
                                            const Size3& size, const Point3& spacing_mm, int axis,
                                            double counted_voxels, Progress& progress);

/// What pore_diffusion takes at most, beside `pores`.
/// pore_count  of these voxels, pores
std::uint64_t pore_diffusion_bytes(std::uint64_t voxels, std::uint64_t pore_count);

}  // namespace octavo
