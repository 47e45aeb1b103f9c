// GIPL (Guys Image Processing Lab): a header of 256 bytes, then the voxels; plain or gzip.
//
//       0  dims          4 x uint16    x, y, z, t; 0 or 1 along an axis that is not there
//       8  image type    uint16
//      10  pixdim        4 x float32   mm
//      26  text          80 bytes      about the patient
//     106  matrix        20 x float32  not used: its meaning differs between programs
//     186  orientation   2 x uint8     not used
//     188  min, max      2 x float64   not used
//     204  origin        4 x float64   mm
//     236  offset, scale, slice gap, user value   4 x float32   not used
//     252  magic number  uint32        719555000, or 4026526128 in older files
//     256  voxels        x fastest
//
// All numbers are big-endian. Axes are those of ITK, which reads the same fields: the file's x, y
// and z are left, posterior and superior.
#pragma once

#include <memory>
#include <string>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// Streams the voxels plane by plane; a fourth axis is time.
/// Throws Error{source_rejected} for another magic number, a type without a voxel type (vectors,
///        complex numbers), an axis without length, a geometry that is none, a cut file;
///        Error{limit_exceeded} for more voxels than a volume holds; Error{io}
std::unique_ptr<PlaneSource> open_gipl_source(const std::string& path,
                                              const SourceOptions& options);

}  // namespace octavo
