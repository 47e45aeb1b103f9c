// The text lines of a VTK legacy file of structured points.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/volume.h"
#include "octavo/io/source/stored_type.h"
#include "octavo/io/source/text_voxels.h"

namespace octavo {

/// What a file of structured points with one array of one value per point says of it.
struct VtkHeader {
  std::string title;                 ///< the second line, free text
  Size3 size;
  StoredType type = VoxelType::uint8;
  std::optional<Point3> spacing_mm;  ///< of SPACING or ASPECT_RATIO; absent where neither stands
  Point3 origin_mm{};
  bool is_text = false;              ///< voxels are decimal numbers; else big-endian values
  std::uint64_t voxel_offset = 0;    ///< x fastest
  std::uint64_t bytes_behind = 0;    ///< of what may follow big-endian voxels
  bool has_color_table = false;      ///< among them
};

/// The header of a file in which one array stands. Behind big-endian voxels, which are all there,
/// follow at most blanks, notes (METADATA) and a color table; where voxels written as text end,
/// only reading them tells.
/// Throws Error{source_rejected} on values of cells, several arrays, several values per point,
///        other types or data sets, counts that contradict each other, a cut file;
///        Error{limit_exceeded} where the voxels pass 64 bits; Error{io}
VtkHeader read_vtk_header(const std::string& path);

/// Goes over what follows the last of `voxels`; true where that is a color table.
/// Throws Error{source_rejected} on another array and on what is no part of the format; Error{io}
bool read_behind_vtk_text(TextVoxels& voxels);

}  // namespace octavo
