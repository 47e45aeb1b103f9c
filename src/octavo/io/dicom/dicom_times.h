// Series of several volumes at the same places: moments of one body.
#pragma once

#include <vector>

#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

/// The volumes of a series in which every place has a slice for each moment, in the order of the
/// numbers that tell them apart: Temporal Position Index or Identifier, else Trigger Time, else
/// Acquisition Number. One volume where no such number divides the slices so.
std::vector<std::vector<DicomSlice>> volumes_in_time(std::vector<DicomSlice> slices);

}  // namespace octavo
