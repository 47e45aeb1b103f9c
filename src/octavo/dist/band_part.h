// A part that holds a band: one of several parts that share a group.
//
//   pass over the planes   what it is for
//   1                      checksum, digests, which bricks are uniform; the band, where it fits
//   2                      the 32 bricks that the model of the group learns from
//   3, 4, ..               the band, run by run, where memory does not hold all of it
//
// All parts of a group train on the same bricks, to the same model. The second pass is left out
// where the plan has the model (group 0), and where the bricks were picked up in the first one.
// Each plane is hashed by one of the parts.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/dist/build_plan.h"
#include "octavo/dist/part_place.h"
#include "octavo/dist/parts.h"

namespace octavo {

/// Proves, before a plane is read, that parts of a build can share its groups: these are single
/// layers, no voxel differs from its source, and planes can be read more than once. Whether floats
/// differ their planes decide.
/// Throws  Error{invalid_argument}; as outline_build
void require_bands(const PlaneSource& source, const BuildOptions& options);

/// The same of a plan.
void require_bands(const BuildPlan& plan, const PlaneSource& source);

/// Bytes of the voxels of the largest band of a group that `bands` parts share, at most one part a
/// brick.
std::uint64_t band_share_bytes(const VolumeDescription& volume, std::int64_t bands);

/// Encodes a band into a part file at `path`, as build_part does with groups.
/// Throws  as build_part and require_bands
/// Memory  share_memory_bytes; where that is above the limit, its bricks are encoded in several
///         runs, and planes are read again for each
void build_band(const BuildPlan& plan, PlaneSource& source, const PartPlace& place,
                Storage& storage, const std::string& path, const PartWork& work,
                Progress& progress);

}  // namespace octavo
