// Planes to plain voxel files, without a .8vo file between.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

struct PlaneWriteResult {
  std::vector<std::string> files;  ///< what was written, a header first
  std::uint64_t bytes = 0;
};

/// True for .raw and .mhd.
bool is_plain_path(const std::string& path);

/// Writes all planes of `source` as .raw, or as .mhd with a .raw beside it, little-endian, z, y, x.
/// Files take their names when they are complete.
/// Throws Error{io} when a file exists (without `overwrite`) or cannot be written; Error{cancelled}
PlaneWriteResult write_plain_planes(PlaneSource& source, const std::string& path, bool overwrite,
                                    Progress& progress);

}  // namespace octavo
