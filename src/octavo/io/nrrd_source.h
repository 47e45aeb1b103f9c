// NRRD: .nrrd with its voxels inside, .nhdr with a data file beside it.
#pragma once

#include <memory>
#include <string>

#include "octavo/io/described_source.h"

namespace octavo {

/// Streams the voxels plane by plane; encodings raw and gzip. Spaces named by left/right and so on
/// are turned to LPS; others are taken as they stand, as ITK does.
/// Throws Error{source_rejected} for axes that are no space (colour, vectors, time), other
/// encodings,
///        several data files, cut data; Error{io} when header or data are missing
std::unique_ptr<PlaneSource> open_nrrd_source(const std::string& path,
                                              const SourceOptions& options);

}  // namespace octavo
