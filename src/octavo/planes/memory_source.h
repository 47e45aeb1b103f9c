// Planes out of a volume that is in memory already.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "octavo/planes/plane_source.h"

namespace octavo {

/// A source over `voxels`, [z][y][x], x fastest, of description.type; they must outlive it.
/// Throws  Error{limit_exceeded} on a bad size; Error{invalid_argument} when the number of bytes is
///         not that of the description
std::unique_ptr<PlaneSource> make_memory_source(const VolumeDescription& description,
                                                std::span<const std::byte> voxels);

}  // namespace octavo
