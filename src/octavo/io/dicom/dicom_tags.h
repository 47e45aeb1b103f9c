// Attributes that several readers of this folder look at.
#pragma once

#include "octavo/io/dicom/dicom_file.h"

namespace octavo {

inline constexpr DicomTag kRescaleIntercept = 0x00281052;
inline constexpr DicomTag kRescaleSlope = 0x00281053;
inline constexpr DicomTag kSegmentColor = 0x0062000d;  // Recommended Display CIELab Value
inline constexpr DicomTag kCardiacSynchronizationSequence = 0x00189118;
inline constexpr DicomTag kTemporalPositionSequence = 0x00209310;
// Unassigned Shared Converted Attributes Sequence, and the one of a frame
inline constexpr DicomTag kSharedConvertedAttributesSequence = 0x00209170;
inline constexpr DicomTag kFrameConvertedAttributesSequence = 0x00209171;
inline constexpr DicomTag kGridFrameOffsets = 0x3004000c;
inline constexpr DicomTag kDoseScaling = 0x3004000e;

}  // namespace octavo
