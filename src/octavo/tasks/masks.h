// Masks in and out of .8vo files: what the tasks on octrees share.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "octavo/builder/builder.h"
#include "octavo/file/reader.h"
#include "octavo/octree/label_tree.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/mask_build.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// A mask and the file it came from, whose grid it shares.
struct OpenedMask {
  std::string path;
  std::shared_ptr<const FileReader> reader;
  MaskTree tree;

  const VolumeDescription& volume() const { return reader->description(); }
};

/// A mask in memory, and the description that its file would have.
struct ComputedMask {
  MaskTree tree;
  VolumeDescription volume;
};

/// Opens the label map `path`; its mask is every voxel that is not 0.
/// Throws what FileReader::open and mask_of_file throw; Error{invalid_argument} for grey volumes
OpenedMask open_mask(const std::string& path, const TaskContext& context);

/// A mask on the grid of another volume.
struct MaskOnGrid {
  MaskTree tree;
  bool is_resampled = false;  ///< its own grid is another one
};

/// The mask of the label map `path` on the grid of `volume`, the one of the file `name`. Where the
/// grids differ, it is every voxel whose nearest voxel of the label map is not 0; where they do not
/// even meet, it is empty and a warning says so. Warns as well as warn_of_unknown_spacing does.
/// Throws as open_mask
MaskOnGrid open_mask_on(const VolumeDescription& volume, const std::string& name,
                        const std::string& path, const TaskContext& context);

/// What of a label map is in its mask: every label but 0.
std::vector<ValueWindow> any_label();

/// mask_of_file with progress, on the threads of `context`.
MaskTree read_mask(const FileReader& reader, int level, std::span<const ValueWindow> windows,
                   const TaskContext& context);

/// The description of a label map on the grid of `volume`, with the number type given.
/// made_by  what the metadata say of its origin
VolumeDescription label_description(const VolumeDescription& volume, VoxelType type,
                                    const MadeBy& made_by);

/// The description of a volume of mm on the grid of a mask.
/// volume   of the mask
/// type     without a slope
/// made_by  what the metadata say of its origin
VolumeDescription mm_description(const VolumeDescription& volume, VoxelType type,
                                 const MadeBy& made_by);

/// What work may take beside so many bytes: half of what the limit leaves, 1 GiB where there is
/// none.
std::uint64_t bytes_beside(std::uint64_t held, const TaskContext& context);

/// Writes a label map.
/// description  of it, as label_description gives it
/// work         names the progress
BuildResult write_label_tree(const LabelTree& labels, const VolumeDescription& description,
                             const Output& output, const std::string& work,
                             const TaskContext& context);

/// Writes a mask as a label map: 1 inside, 0 outside.
/// work  names the progress
BuildResult write_mask(const MaskTree& mask, const VolumeDescription& volume,
                       const MadeBy& made_by, const Output& output,
                       const std::string& work, const TaskContext& context);

/// The same, with a description of its own: of the size of the mask, and of uint8.
BuildResult write_described_mask(const MaskTree& mask, const VolumeDescription& description,
                                 const Output& output, const std::string& work,
                                 const TaskContext& context);

/// Builds the label map that `source` gives.
BuildResult write_labels(PlaneSource& source, const Output& output, const std::string& work,
                         const TaskContext& context);

/// Throws Error{invalid_argument} that says how the grids of two volumes differ: in size, or in
/// where their voxels lie. The error is about `path`, the file of `other`, and about `field`.
/// name  the file of `volume`
void require_same_grid(const VolumeDescription& volume, const std::string& name,
                       const VolumeDescription& other, const std::string& path,
                       const char* field = "grid");

/// Warns where one of two volumes has a known spacing and the other has not, whose voxels are taken
/// for 1 mm when one is laid over the other.
/// name, other_name  their files
void warn_of_unknown_spacing(const VolumeDescription& volume, const std::string& name,
                             const VolumeDescription& other, const std::string& other_name,
                             const TaskContext& context);

}  // namespace octavo
