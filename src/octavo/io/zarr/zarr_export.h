// A volume with all its levels as an OME-Zarr 0.5 image, in shards.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/io/zarr/zarr_output.h"
#include "octavo/io/zarr/zarr_text.h"

namespace octavo {

/// True for the names of OME-Zarr images: .ome.zarr, .zarr, .ozx.
bool is_zarr_path(const std::string& path);

struct ZarrExportOptions {
  int first_level = 0;  ///< becomes array 0; all coarser ones follow
  ZarrCompression compression = ZarrCompression::zstd;
  std::int64_t chunk_side = 64;   ///< voxels, 16 to 256
  std::int64_t shard_chunks = 4;  ///< along each axis, 1 to 16
  bool overwrite = false;
  int threads = 0;
};

struct ZarrExportResult {
  int levels = 0;
  std::uint64_t files = 0;
  std::uint64_t bytes = 0;
};

/// Writes stored values; chunks of voxels that are all 0 are left out.
/// Throws  Error{invalid_argument} for a level that is not there and sides out of range; as
///         make_zarr_folder and read_parallel; Error{cancelled}
/// Memory  a shard as voxels and once more as it is written
ZarrExportResult export_zarr(const FileReader& reader, Storage& storage, const std::string& path,
                             const ZarrExportOptions& options, Progress& progress);

}  // namespace octavo
