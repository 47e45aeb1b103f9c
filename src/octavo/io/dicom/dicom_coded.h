// Frames of compressed pixel data, decoded by what their pictures say of themselves.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "octavo/io/dicom/dicom_slice.h"
#include "octavo/io/dicom/picture_head.h"

namespace octavo {

/// True for run lengths, whose values are those of uncompressed pixel data.
bool has_run_lengths(const DicomLayout& layout);

/// What the first picture says of itself; nothing where it is none of JPEG, JPEG-LS and JPEG 2000.
/// Throws Error{io}
std::optional<PictureHead> first_picture_head(const DicomLayout& layout);

/// True where the numbers of pictures fit the bits allocated, but have more than are stored; not
/// in plain JPEG of all bits allocated, where those beside the stored ones may hold anything.
bool has_more_bits(const DicomLayout& layout, const PictureHead& head);

/// True where a number of the frame needs more bits than are stored; false where it cannot be
/// decoded. Memory: one frame.
bool has_wide_number(const DicomSlice& slice);

/// Decodes a frame into values of Bits Allocated. Where the picture says how many bits its numbers
/// have, these count: fewer are widened, more than Bits Stored are kept, but in plain JPEG of all
/// bits allocated.
/// Returns false where it does not say, so that unused bits may hold anything.
/// Throws Error{source_rejected} where the picture is damaged, of another size than the header
/// says, or of more bits than are allocated; Error{io}
bool read_coded_frame(const DicomSlice& slice, std::span<std::byte> plane);

}  // namespace octavo
