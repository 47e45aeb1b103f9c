// Whether the pixel data of a DICOM file are those of the frames that its header names, no fewer
// and no more.
#pragma once

#include <cstdint>

#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

/// Rejects pixel data of several frames that have no bit or fragment for each: before these are
/// listed, which takes memory for each.
/// Throws Error{source_rejected} with both counts
void require_part_for_each_frame(const DicomLayout& layout);

/// Proves that the located pixel data hold all frames, and no picture beside them.
/// Throws Error{source_rejected} with both lengths or counts.
void check_dicom_pixels(const DicomLayout& layout);

/// Bytes behind the last frame of native pixel data that are more than padding to a whole word.
/// Requires check_dicom_pixels to have passed.
std::uint64_t surplus_bytes(const DicomLayout& layout);

/// Makes a table of the frames of compressed pixel data that lack one, where each is of several
/// fragments and the marks at the start of its picture tell which of them is its first.
/// Throws Error{io}
void find_frame_starts(DicomLayout& layout);

}  // namespace octavo
