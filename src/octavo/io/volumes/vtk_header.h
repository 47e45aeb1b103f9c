// The text around the voxels of a legacy VTK file, read line by line and nothing assumed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/volume.h"

namespace octavo {

/// What a file of structured points with one array of one value per point says of it.
struct VtkHeader {
  std::string title;                 ///< the second line, free text
  Size3 size;
  VoxelType type = VoxelType::uint8;
  std::optional<Point3> spacing_mm;  ///< of SPACING or ASPECT_RATIO; absent where neither stands
  Point3 origin_mm{};
  std::uint64_t voxel_offset = 0;    ///< values big-endian, x fastest
  bool has_color_table = false;     ///< behind the voxels
};

/// The header of a file in which one array stands, all its voxels are there, and nothing follows
/// them but blanks, notes (METADATA) and a color table.
/// Throws Error{source_rejected} on text voxels, values of cells, several arrays, several values
///        per point, other types or data sets, counts that contradict each other, a cut file;
///        Error{limit_exceeded} where the voxels pass 64 bits; Error{io}
VtkHeader read_vtk_header(const std::string& path);

}  // namespace octavo
