// The stored voxels of one DICOM frame.
#pragma once

#include <cstddef>
#include <span>

#include "octavo/core/voxel_type.h"
#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

/// The voxel type of a layout: 8, 16 or 32 bits allocated, signed or not; uint8 for the 1-bit
/// voxels of a segmentation; float32 for Float and Double Float Pixel Data; that of the colors
/// where one is taken of a palette.
/// Throws Error{source_rejected} naming what cannot be read: compressed color, 1 bit, compressed
/// float, segmentations of other kinds.
VoxelType dicom_voxel_type(const DicomLayout& layout);

/// Fills `plane` with the frame, or the tile of a mosaic, unused bits masked and the sign extended.
/// Native voxels are read where they stand; others go, fragment by fragment, to GDCM's decoders.
/// Requires dicom_voxel_type and check_dicom_pixels to have passed. Thread-safe.
/// Throws Error{source_rejected} when the data cannot be decoded, Error{io}
void read_dicom_frame(const DicomSlice& slice, std::span<std::byte> plane);

}  // namespace octavo
