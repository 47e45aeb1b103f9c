#include "octavo/tasks/files/export_zarr_image.h"

#include "octavo/core/path_text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

ZarrImageResult export_zarr_image(const ZarrImageOptions& options, const TaskContext& context) {
  const auto reader = open_volume(options.input, context);
  require_no_input(options.output.path, {options.input});
  require_folder_around(without_end_slashes(options.output.path));
  const VolumeDescription& volume = reader->description();
  if (!volume.rescale.is_identity()) {
    context.warn(options.output.path +
                 ": OME-Zarr has no slope: stored values are written, and slope and intercept "
                 "stand in its attributes");
  }
  if (!is_spacing_known(volume)) {
    context.warn(options.output.path + ": the spacing is not known; 1 is written without a unit");
  }
  const ZarrExportOptions how{options.level,        options.compression, options.chunk_side,
                              options.shard_chunks, options.output.overwrite, context.threads};
  return {volume, export_zarr(*reader, local_storage(), options.output.path, how,
                              context.watcher())};
}

}  // namespace octavo
