// The segments of a DICOM segmentation (SEG): one of them, or all as the labels of one volume.
#pragma once

#include <string>
#include <vector>

#include "octavo/io/dicom/dicom_slice.h"
#include "octavo/io/source_options.h"

namespace octavo {

/// The frames of the segment that options.segment names by its number or its label, with a blank
/// slice at each place where other segments alone have a frame. Where none is named, those of the
/// only one, or, for BINARY ones, of all: then the frames at one place become one slice, whose
/// voxels have the number of their segment; those of label maps have it as they are stored.
/// Fractions get the rescale that makes a whole voxel 1. Slices of other kinds pass unchanged.
/// Throws Error{source_rejected} where a segment has to be named, or the file says that segments
///        overlap; Error{invalid_argument} where the one named is not there, or this is no SEG
std::vector<DicomSlice> choose_segments(std::vector<DicomSlice> slices,
                                        const SourceOptions& options);

/// Notes the numbers of the segments, or of the one that was taken, for the metadata; nothing for a
/// file of one segment. Labels are free text, which belongs to the identity (dicom_identity.h).
void note_segments(const std::vector<DicomSlice>& slices, const SourceOptions& options,
                   MetadataFacts& noted);

}  // namespace octavo
