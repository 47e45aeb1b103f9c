// The axes that headers give, against those that a grid of voxels can have.
#pragma once

#include <cstddef>
#include <string>

#include "octavo/core/geometry.h"

namespace octavo {

/// "x", "y" or "z": an index axis in messages.
const char* axis_name(std::size_t axis);

/// True when all axes have a length and stand upright on one another within kAxisTolerance.
bool is_perpendicular(const Geometry& geometry) noexcept;

/// Rejects axes that are not perpendicular within kAxisTolerance: the volume of a voxel would not
/// be the product of its spacings. Axes without a length are passed over.
/// field   what of the header gave the axes, as "space directions"
/// Throws  Error{source_rejected} naming the field, the two axes and their angle
void reject_shear(const Geometry& geometry, const std::string& field, const std::string& path);

}  // namespace octavo
