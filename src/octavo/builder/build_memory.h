// What memory a build takes, and what becomes of groups that are too large for it.
#pragma once

#include <cstdint>

#include "octavo/builder/builder.h"
#include "octavo/core/volume.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// Memory build_file needs for a volume where groups have room, bytes.
std::uint64_t build_memory_bytes(const VolumeDescription& description, int threads,
                                 double max_error = 0);

/// The same with bands of so many bytes in their place.
std::uint64_t band_memory_bytes(const VolumeDescription& description, int threads,
                                std::uint64_t band_bytes);

/// Memory of a join, in which of each brick some bytes are held and no voxel.
std::uint64_t join_memory_bytes(const VolumeDescription& description, int threads);

/// Memory for a share of a group's bricks, of so many bytes, that is read in one band.
std::uint64_t share_memory_bytes(const VolumeDescription& description, int threads,
                                 std::uint64_t share_bytes);

/// The bytes of voxels in a band of a share: all where memory holds it.
/// options  as band_bytes_of
/// Throws   Error{limit_exceeded} where bands have no room either; Error{invalid_argument} where
///          the source can only be read from its start on
std::uint64_t share_band_bytes(const PlaneSource& source, const BuildOptions& options,
                               int threads, std::uint64_t share_bytes);

/// The bytes of voxels in a band of a build of `source`, or 0 where whole groups have room.
/// options  kind, max error, details left out, max_memory_bytes and band_bytes count
/// Throws   Error{limit_exceeded} where bands have no room either, or cannot be read;
///          Error{invalid_argument} where bands that cannot be read are asked for
std::uint64_t band_bytes_of(const PlaneSource& source, const BuildOptions& options, int threads);

}  // namespace octavo
