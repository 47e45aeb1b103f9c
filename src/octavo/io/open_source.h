// Opens whatever a user calls a scan: DICOM folder, TIFF stack, PNG folder, NIfTI, NRRD, MetaImage,
// VTK, GIPL, OME-Zarr, raw.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source_options.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// paths   one file or folder, or the files of one stack in any order
/// Throws  Error{source_rejected} naming the file and both numbers when something does not fit;
///         Error{io} when it cannot be read; Error{invalid_argument} when options do not apply
std::unique_ptr<PlaneSource> open_source(const std::vector<std::string>& paths,
                                         const SourceOptions& options);

/// True when code of others (GDCM, libtiff, libpng, blosc, zstd) may get to see these files: DICOM,
/// TIFF, PNG, OME-Zarr, folders, lists of files. isolated_source.h reads such in another process.
/// Throws Error{io} when the only path cannot be read
bool needs_isolation(const std::vector<std::string>& paths, const SourceOptions& options);

}  // namespace octavo
