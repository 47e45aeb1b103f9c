// What labs of bone, rock and foam measure of a mask: volumes, surface, thickness and how all of it
// hangs together.
//
// Names and definitions are those of M. L. Bouxsein et al., Guidelines for assessment of bone
// microstructure in rodents using micro-computed tomography, Journal of Bone and Mineral Research
// 25 (2010), where it has them. docs/morphometry.md says how each number is computed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/ops/morphometry/box_counts.h"
#include "octavo/ops/morphometry/diffusion.h"
#include "octavo/ops/morphometry/ellipsoid_factor.h"
#include "octavo/ops/morphometry/euler_number.h"
#include "octavo/ops/morphometry/intercept_lengths.h"
#include "octavo/ops/morphometry/local_thickness.h"
#include "octavo/ops/morphometry/path_lengths.h"
#include "octavo/ops/morphometry/surface_shape.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct MorphometryOptions {
  std::string input;   ///< a label map; every voxel but 0 is in the mask
  std::string region;  ///< a label map on the same grid, to measure within; or nothing
  std::string grey;    ///< the scan on the same grid, for densities; or nothing
  Rescale calibration;  ///< from real values of the scan to densities
  bool has_thickness = true;
  Output thickness_map;  ///< of the mask; no path: none is written
  Output spacing_map;    ///< of what is not in it
  /// Of what is not in the mask, along x, y and z; takes 6 bytes a voxel.
  bool has_tortuosity = false;
  /// Of what is not in the mask, along x, y and z; takes a byte a voxel and what pore_diffusion
  /// does; asks for as much as that may be.
  bool has_diffusion = false;
  Output histogram = {};  ///< a PNG of thickness and separation; no path: none is written
};

/// Grey values of voxels, calibrated.
struct DensityMeasure {
  std::uint64_t voxels = 0;
  double mean = 0;
  double deviation = 0;
};

/// What one plane has of the mask.
struct SliceMeasure {
  std::uint64_t voxels = 0;         ///< of the mask
  std::uint64_t region_voxels = 0;  ///< of what is measured
  double mean_thickness_mm = 0;     ///< local thickness of its voxels; 0 where it was left out
};

struct MorphometryResult {
  VolumeDescription volume;
  std::uint64_t voxels = 0;         ///< of the mask, in the region
  std::uint64_t region_voxels = 0;
  double bone_mm3 = 0;              ///< BV
  double total_mm3 = 0;             ///< TV
  SurfaceShape surface;             ///< area: BS
  std::optional<double> smi;        ///< structure model index, where there is a surface
  EulerNumbers euler;
  double connectivity = 0;          ///< 1 - the share of the Euler number
  std::optional<Anisotropy> anisotropy;
  std::optional<FractalFit> fractal;
  std::optional<FractalFit> surface_fractal;
  std::vector<BoxCount> boxes;
  bool has_thickness = false;  ///< as asked for
  std::optional<ThicknessSummary> thickness;  ///< Tb.Th, where there is a surface
  std::optional<ThicknessSummary> spacing;    ///< Tb.Sp, pore sizes
  std::optional<EllipsoidFactors> ellipsoids;
  /// Of pores along x, y and z; nothing where no way leads through, or not asked for.
  std::array<std::optional<PathLengths>, 3> paths{};
  /// Whether the region is wide enough at both ends along x, y and z for pores to lead from one to
  /// the other; where it is not, they are not measured.
  std::array<bool, 3> has_ends{true, true, true};
  bool has_diffusion = false;  ///< as asked for
  std::array<std::optional<PoreDiffusion>, 3> diffusions{};  ///< as paths
  std::optional<DensityMeasure> tissue;       ///< TMD
  std::optional<DensityMeasure> total;        ///< BMD
  std::vector<SliceMeasure> slices;
  std::array<bool, 6> touches{};  ///< borders of the volume: x low, x high, y low, ...

  /// Porosity and the like.
  double share() const { return static_cast<double>(voxels) / static_cast<double>(region_voxels); }
};

/// Measures a mask. Pores are measured from one end of the region, or of the volume, to the other.
/// Warns where the mask touches the border of the volume, which cuts off what it measures, where
/// nothing but it is in the region, and where pores are not measured since a region tapers.
/// Throws  as open_mask, require_same_grid and build_file; Error{invalid_argument} for a mask
///         without voxels in the region, a mask of unknown spacing, labels in place of the scan,
///         maps of a mask that fills the volume
/// Memory  the masks, 1 GiB for distances (with a limit: half of what the masks leave), 20 bytes
///         for each ball; beyond that scratch files beside the map, or in the folder for these
MorphometryResult morphometry(const MorphometryOptions& options, const TaskContext& context);

}  // namespace octavo
