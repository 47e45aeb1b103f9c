// MetaImage: .mha with its voxels inside, .mhd with a .raw or .zraw beside it.
#pragma once

#include <memory>
#include <string>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// Streams the voxels plane by plane, plain or compressed. TransformMatrix rows are the axis
/// directions, as ITK reads them; the data file is taken only from beneath the folder of the
/// header.
/// Throws Error{source_rejected} for more than one channel, 4 dimensions, text voxels, LIST files,
/// cut
///        data; Error{io} when header or data are missing
std::unique_ptr<PlaneSource> open_meta_source(const std::string& path,
                                              const SourceOptions& options);

}  // namespace octavo
