// From a heap of DICOM files to one proven stack of slices.
#pragma once

#include <string>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/io/dicom_slice.h"

namespace octavo {

/// Slices in spatial order, and where they lie.
struct DicomStack {
  std::vector<DicomSlice> slices;
  Geometry geometry;
  bool spacing_known = false;  ///< as is the place; false: slices taken by their numbers
  std::vector<std::string> warnings;
};

/// The slices of one series. series  its SeriesInstanceUID, or empty when there is only one.
/// Throws Error{source_rejected} listing the series when it is not clear which, or `series` is none
/// of them.
std::vector<DicomSlice> choose_series(std::vector<DicomSlice> slices, const std::string& series,
                                      const std::string& source);

/// Sorts the slices along the normal of their common plane and proves that they make a volume: one
/// size, type, orientation, pixel spacing, rescale and photometric interpretation; steps that are
/// even (relative 1e-3 or 0.01 mm) and along the normal. SpacingBetweenSlices is never used.
/// may_lack_geometry  slices without positions are taken by instance number or frame
/// Throws Error{source_rejected} naming both files and both values.
/// Complexity n log n. Requires at least one slice.
DicomStack prove_stack(std::vector<DicomSlice> slices, bool may_lack_geometry);

}  // namespace octavo
