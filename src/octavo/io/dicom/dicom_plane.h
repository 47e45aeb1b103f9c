// The voxels of one plane of a DICOM stack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "octavo/io/dicom/dicom_stack.h"

namespace octavo {

/// Fills `plane` with plane z of the stack: a slice as it is stored, or what its PlaneOrigin and
/// the tilt make of one or two of them. Interpolation is linear and rounds to the nearest stored
/// value; where padding takes part, and for labels, the nearest voxel is taken instead.
/// Requires plane.size() to be that of stack.size(), and read_dicom_frame's requirements.
/// Memory  two slices beside `plane`; thread-safe
/// Throws  as read_dicom_frame
void read_stack_plane(const DicomStack& stack, std::int64_t z, std::span<std::byte> plane);

}  // namespace octavo
