// Mosaics of Siemens scanners: the slices of a volume side by side in one picture.
//
// Image Type says that a picture is one; how many slices it holds and which way they are stacked
// stands in the scanner's own header, an element of a private group. The tiles fill a square of
// ceil(sqrt(n)) in a row, the first slice at the top left; each next one lies Spacing Between
// Slices further along the normal that the header gives. Image Position is the place of the whole
// picture as if it were one slice with the center of the first.
//
// Source: the CSA header as nibabel's documentation describes it (nipy.org/nibabel/dicom/)
#pragma once

#include <vector>

#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

/// True where Image Type has the value MOSAIC.
bool is_mosaic(const DicomLayout& layout);

/// The slices of a mosaic in place of the one picture that it is.
/// Throws Error{source_rejected} where its header is not there, damaged or contradicts the picture
std::vector<DicomSlice> unfold_mosaic(const DicomFile& file, const DicomSlice& picture);

}  // namespace octavo
