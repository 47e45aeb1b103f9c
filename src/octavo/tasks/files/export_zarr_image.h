// A volume with all its levels as an OME-Zarr image.
#pragma once

#include <string>

#include "octavo/core/option_words.h"
#include "octavo/core/volume.h"
#include "octavo/io/zarr/zarr_export.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

constexpr auto option_words(ZarrCompression) {
  using enum ZarrCompression;
  return std::to_array<NamedValue<ZarrCompression>>(
      {{"zstd", zstd}, {"blosc", blosc}, {"none", none}});
}

struct ZarrImageOptions {
  std::string input;  ///< an .8vo file or a URL of one
  Output output;      ///< ends in .ome.zarr, .zarr (folders) or .ozx
  int level = 0;      ///< the finest one that is written
  ZarrCompression compression = ZarrCompression::zstd;
  std::int64_t chunk_side = 64;
  std::int64_t shard_chunks = 4;
};

struct ZarrImageResult {
  VolumeDescription volume;
  ZarrExportResult written;
};

/// Writes stored values; how they become real ones stands in an attribute, and a warning says so.
/// Throws  as open_volume and export_zarr
ZarrImageResult export_zarr_image(const ZarrImageOptions& options, const TaskContext& context);

}  // namespace octavo
