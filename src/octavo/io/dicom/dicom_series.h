// From a heap of DICOM files to one proven stack of slices.
#pragma once

#include <string>
#include <vector>

#include "octavo/io/dicom/dicom_slice.h"
#include "octavo/io/dicom/dicom_stack.h"

namespace octavo {

/// The slices of one series. series  its SeriesInstanceUID, or empty when there is only one.
/// Throws Error{source_rejected} listing the series when it is not clear which, or `series` is none
/// of them.
std::vector<DicomSlice> choose_series(std::vector<DicomSlice> slices, const std::string& series,
                                      const std::string& source);

/// Sorts the slices along the normal of their common plane and proves that they make a volume: one
/// size, type, orientation, pixel spacing, rescale and photometric interpretation; one slice at a
/// place; steps that are even (relative 1e-3 or 0.01 mm) and along the normal, or what the options
/// make of them (plan_planes). SpacingBetweenSlices is never used. With options.spacing_mm, slices
/// without positions are taken by instance number or frame.
/// Throws Error{source_rejected} naming both files and both values.
/// Complexity n log n; voxels are only read to compare slices at the same place.
/// Requires at least one slice, and check_dicom_pixels to have passed for all.
DicomStack prove_stack(std::vector<DicomSlice> slices, const SourceOptions& options);

}  // namespace octavo
