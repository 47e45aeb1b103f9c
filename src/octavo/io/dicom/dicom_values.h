// What the stored values of a DICOM frame stand for.
//
// A header that says so in a way that is not understood is no reason to take the stored values as
// real ones: what is wrong is kept with the frame, and rejected where the frame is taken.
#pragma once

#include <string>

#include "octavo/core/volume.h"
#include "octavo/io/dicom/dicom_file.h"

namespace octavo {

struct DicomValues {
  Rescale rescale;
  std::string unit;   ///< of real values, a known one; else empty
  std::string fault;  ///< why the rescale is not the one meant; empty: it is
};

/// Reads Rescale Slope, Intercept and Type; of RTDOSE Dose Grid Scaling and Dose Units. Without a
/// type CT is in Hounsfield units, PET in its Units.
/// transformation  the frame's Pixel Value Transformation, where the file has functional groups
///                 with one, else null: the data set itself speaks
/// Source          DICOM PS3.3 C.11.1 (Modality LUT), C.7.6.16.2.9, C.8.8.3 (RT Dose)
DicomValues read_dicom_values(const DicomSet& data, const DicomSet* transformation);

}  // namespace octavo
