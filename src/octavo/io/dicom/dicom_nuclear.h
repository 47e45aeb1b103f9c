// The slices of a nuclear medicine picture (NM): all in one file, their place in its detectors.
#pragma once

#include <vector>

#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

/// Orders frames by Slice Vector, and places them along the normal from the position of the
/// detector by Spacing Between Slices, where the file says all of these of a reconstructed volume.
/// Leaves `slices` as they are where it has no Slice Vector.
/// Throws Error{source_rejected} where Slice Vector names a slice twice, as those of gated and of
///        dynamic pictures do, or has another length than there are frames
/// Source: DICOM PS3.3 C.8.4.8 (NM Multi-frame), C.8.4.11 (NM Detector), C.8.4.15 (NM
///         Reconstruction)
void take_nuclear_slices(const DicomSet& data, std::vector<DicomSlice>& slices);

}  // namespace octavo
