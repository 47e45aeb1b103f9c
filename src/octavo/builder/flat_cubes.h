// The region octree of a grey volume: cubes that hardly vary become their mean.
//
// A cube of the octree (up to the root) whose voxels differ by at most `flat` takes their mean,
// halves rounded up; the largest such cubes count. Of a cube at the border of the volume the voxels
// inside count. Written as a grey file, these are the uniform cubes of its octree.
//
// Voxels of type float32 are taken as the numbers that the bricks of the file hold; every voxel
// must be one: so is every mean, and the new file holds them in the same way.
//
// Invariants
//   No voxel differs from its source by more than `flat`.
// Consequences
//   Which cubes above 64^3 are flat follows from the index; only those that are flat, and lossy
//   files, are decoded twice.
//   Memory is that of one layer of 64 planes, and 48 bytes per 64^3 voxels.
//
// Source  thesis 2.4 (Fig. 2.2)
#pragma once

#include <cstdint>
#include <memory>

#include "octavo/file/reader.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// A source of the planes of `reader` with its flat cubes evened out.
/// description  what the source says of itself; size and type are those of the file
/// flat         in the numbers that bricks hold; with 0 the voxels are those of the file
/// threads      0: all cores
/// Throws  Error{invalid_argument} for labels, for float voxels that are not those of their
///         numbers, and on flat < 0 or so large that the
///         mean of the volume's cube is beyond 64-bit sums (flat >= 2^62 / 8^n); what reading
///         throws
std::unique_ptr<PlaneSource> make_flat_cubes(std::shared_ptr<const FileReader> reader,
                                             const VolumeDescription& description,
                                             std::int64_t flat, int threads);

}  // namespace octavo
