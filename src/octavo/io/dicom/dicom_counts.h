// How many pictures the headers say there are, where some of them may not have been copied.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/warning.h"
#include "octavo/io/dicom/dicom_file.h"

namespace octavo {

struct DicomSlice;

/// What the header of a file says of how many there are; 0 where it does not.
struct DicomCounts {
  std::string concatenation;    ///< its UID; empty: the file is no part of one
  std::int64_t part = 0;        ///< In-concatenation Number, counted from 1
  std::int64_t parts = 0;       ///< In-concatenation Total Number
  std::int64_t images = 0;      ///< Images in Acquisition
  std::int64_t slices = 0;      ///< of PET: Number of Slices
  std::int64_t moments = 0;     ///< Number of Temporal Positions
  std::int64_t time_slices = 0; ///< of PET: Number of Time Slices
};

/// Source  DICOM PS3.3 C.7.6.16 (Multi-frame Functional Groups), C.8.9.1 (PET Series)
DicomCounts read_dicom_counts(const DicomSet& data);

/// Throws Error{source_rejected} with both counts where a part of a concatenation is not there.
void require_whole_concatenations(const std::vector<DicomSlice>& slices);

/// Warns where a series has fewer images than its acquisition, which may have made several series.
void tell_of_missing_images(const std::vector<DicomSlice>& slices, std::vector<Warning>& warnings);

/// Warns where a volume has fewer slices, or several moments are fewer, than the header says.
/// slices   of one moment
/// moments  that were found
void tell_of_missing_slices(const std::vector<DicomSlice>& slices, std::int64_t moments,
                            std::vector<Warning>& warnings);

}  // namespace octavo
