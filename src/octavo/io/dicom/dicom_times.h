// Series of several volumes at the same places: moments of one body.
#pragma once

#include <string>
#include <vector>

#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

struct DicomTimes {
  std::vector<std::vector<DicomSlice>> volumes;  ///< in the order of their numbers
  std::string told_by;  ///< "Trigger Time (0018,1060): 0, 40, 80 ms"; empty where there is one
};

/// The volumes of a series in which every place has a slice for each moment, by the first of
/// moment_numbers() that divides the slices so; where none does, by the order of the first that was
/// measured for each slice, and has no value of one moment among those of another. Numbers of a
/// less sure kind are not asked where a surer one tells slices apart. Else one volume.
DicomTimes volumes_in_time(std::vector<DicomSlice> slices);

}  // namespace octavo
