// The formats of ITK and VTK that are loaded whole: VTK structured points, and GIPL by ITK.
#pragma once

#include <memory>
#include <string>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// True when the name is that of a format read here.
bool is_itk_name(const std::string& path);

/// Loads the volume and delivers its planes; resident_bytes() is the volume.
/// Throws Error{limit_exceeded} before loading when it exceeds options.max_memory_bytes;
///        Error{source_rejected} for vectors, color, 4 dimensions, 64-bit voxels, files too short
///        for their header, VTK files of several arrays or of values of cells; Error{io}
std::unique_ptr<PlaneSource> open_itk_source(const std::string& path, const SourceOptions& options);

}  // namespace octavo
