// VTK legacy files of structured points: a header of text lines, then the voxels of one array,
// big-endian or as text. vtk_header.h reads the lines.
#pragma once

#include <memory>
#include <string>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// Streams the voxels plane by plane. What stands behind voxels written as text is examined when
/// the last plane is read.
/// Throws Error{source_rejected} as read_vtk_header, and for a geometry that is none;
///        Error{limit_exceeded} for more voxels than a volume holds; Error{io}
std::unique_ptr<PlaneSource> open_vtk_source(const std::string& path, const SourceOptions& options);

}  // namespace octavo
