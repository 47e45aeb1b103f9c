// Planes that are computed when they are asked for: from a mask, from labels, from another volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "octavo/planes/plane_source.h"

namespace octavo {

/// Fills the voxels of a box, [z][y][x] without gaps, of the volume's type.
using FillBox = std::function<void(const Box& box, std::byte* voxels)>;

/// A source whose planes come out of `fill`, so many at a time, in z order. Throws what `fill`
/// throws.
/// Memory  that of so many planes
std::unique_ptr<PlaneSource> make_computed_source(const VolumeDescription& description,
                                                  FillBox fill, std::int64_t planes_at_once = 16);

}  // namespace octavo
