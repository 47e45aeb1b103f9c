// Headerless voxels: one file, or one file per plane, as the user describes them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// files  one file with all planes, or layout.size.z files with one plane each, in plane order
/// Throws Error{source_rejected} with both sizes when lengths do not fit the layout, Error{io}
std::unique_ptr<PlaneSource> open_raw_source(const std::vector<std::string>& files,
                                             const RawLayout& layout, const SourceOptions& options);

}  // namespace octavo
