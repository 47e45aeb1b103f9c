// The JSON of zarr v3 arrays, and of OME-Zarr 0.5 groups over the levels of a volume.
//
//     zarr.json          group: axes z, y, x in mm; for each level where its voxels lie
//     0/zarr.json        array of level 0, its chunks in c/ or behind whoever answers for them
//     1/zarr.json        ...
//
// Positions are along the axes of the grid. Where these are the axes of the world they are LPS; the
// whole geometry, real units and the metadata stand beside them, in an attribute of our own, so
// that an import loses nothing.
//
// Source  Zarr core specification 3.0; OME-Zarr 0.5
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/levels.h"
#include "octavo/core/volume.h"
#include "octavo/file/reader.h"

namespace octavo {

enum class ZarrCompression : std::uint8_t { none, zstd, blosc };

/// How the voxels of a level are cut.
struct ZarrGrid {
  Size3 chunk{64, 64, 64};
  /// Chunks of a shard along each axis; nothing: every chunk is a file.
  std::optional<Size3> shard_chunks;
  ZarrCompression compression = ZarrCompression::none;
  /// Each chunk has a checksum: that of zstd, or a CRC-32C behind it. For chunks that are stored.
  bool has_checksums = false;

  /// Of what a file holds, in voxels.
  Size3 file_size() const;
};

/// The text of an array of a level.
std::string zarr_array_text(VoxelType type, const Size3& size, const ZarrGrid& grid);

/// The text of the group over the levels [first_level, end_level) of a file. With level 0 goes the
/// digest of its voxels.
/// name  of the image
std::string ome_group_text(const FileReader& reader, int first_level, int end_level,
                           const std::string& name);

/// The level behind the finest one that is one chunk: coarser ones reach so far beyond the end of
/// the volume that viewers show them there.
int end_of_shown_levels(const Levels& levels, const ZarrGrid& grid);

}  // namespace octavo
