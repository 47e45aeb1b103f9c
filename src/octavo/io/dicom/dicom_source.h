// A DICOM series: one plane per slice or frame, in spatial order.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// files   candidates in any order; those that hold no picture, or are not DICOM, are
///         left out with a warning; companions of scans without one
/// source  the name the user gave, for messages about all of them
/// Every header is read and proven first; voxels stay in the files until their plane is asked for.
/// Throws Error{source_rejected} for a file that is empty or damaged, for values of
///        unknown meaning, and as choose_series, prove_stack, dicom_voxel_type and
///        check_dicom_pixels do; Error{io}
std::unique_ptr<PlaneSource> open_dicom_source(const std::vector<std::string>& files,
                                               const std::string& source,
                                               const SourceOptions& options);

}  // namespace octavo
