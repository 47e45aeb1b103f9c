// NRRD: .nrrd with its voxels inside, .nhdr with a data file beside it.
#pragma once

#include <memory>
#include <string>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// Streams the voxels plane by plane; encodings raw and gzip. Spaces named by left/right and so on
/// are turned to LPS; scanner-xyz, 3D-right-handed, 3D-left-handed and a space without a name are
/// kept as they stand, with a warning and "place_known": false in the metadata.
/// Throws Error{source_rejected} for other spaces, sheared axes, other encodings, several data
///        files, cut data; Error{io} when header or data are missing; as choose_component does
std::unique_ptr<PlaneSource> open_nrrd_source(const std::string& path,
                                              const SourceOptions& options);

}  // namespace octavo
