// PET series, whose slices may have a rescale each: a volume of them holds real values.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "octavo/core/voxel_type.h"
#include "octavo/core/warning.h"
#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

/// Where the slices of a PET series have several rescales, slices whose voxels are real values,
/// float32, and a warning that says so. Other series pass unchanged, and so do those with a Pixel
/// Padding Value, which is a stored one.
std::vector<DicomSlice> take_real_values(std::vector<DicomSlice> slices,
                                         std::vector<Warning>& warnings);

/// Stored values of an integer type as real ones, rounded to float32.
/// Requires  as many values in `real`, of 4 bytes each
/// Throws    Error{source_rejected} for one that is beyond all float32, or so small that it is lost
void make_real(const Rescale& rescale, VoxelType type, std::span<const std::byte> stored,
               std::span<std::byte> real);

}  // namespace octavo
