// NIfTI-1 and NIfTI-2: .nii, .nii.gz, and .hdr with .img.
#pragma once

#include <memory>
#include <string>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// Streams the stored voxels; scl_slope and scl_inter become the rescale. Exactly the named file is
/// read.
/// Geometry: the sform where it is set, else the qform, turned from RAS to LPS.
/// Throws Error{source_rejected} for complex voxels, Analyze 7.5 (which does not say where left
///        is), as choose_component does, cut or damaged streams; Error{io} when a file is missing
std::unique_ptr<PlaneSource> open_nifti_source(const std::string& path,
                                               const SourceOptions& options);

}  // namespace octavo
