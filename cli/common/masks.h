// Masks in and out of .8vo files: what the verbs that work on octrees share.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/context.h"
#include "octavo/builder/builder.h"
#include "octavo/file/reader.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/mask_build.h"

namespace octavo::cli {

/// A mask and the file it came from, whose grid it shares.
struct OpenedMask {
  std::string path;
  std::shared_ptr<const FileReader> reader;
  MaskTree tree;

  const VolumeDescription& volume() const { return reader->description(); }
};

/// Opens the label map `path`; its mask is every voxel that is not 0.
/// Throws what FileReader::open and mask_of_file throw; Error{invalid_argument} for grey volumes
OpenedMask open_mask(const std::string& path, const Context& context);

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
                        const std::string& path, Context& context);

/// mask_of_file with progress, on the threads of `context`.
MaskTree read_mask(const FileReader& reader, int level, const std::vector<ValueWindow>& windows,
                   const Context& context);

/// Runs `work` on the threads of `context`.
void on_threads(const Context& context, const std::function<void()>& work);

/// The description of a label map on the grid of `volume`, with the number type given.
/// made_by  what the metadata say of its origin under "made_by"
VolumeDescription label_description(const VolumeDescription& volume, VoxelType type,
                                    const nlohmann::ordered_json& made_by);

/// Writes a mask as the label map `output`: 1 inside, 0 outside.
BuildResult write_mask(const MaskTree& mask, const VolumeDescription& volume,
                       const nlohmann::ordered_json& made_by, const std::string& output,
                       const Context& context);

/// Builds the label map that `source` gives, with progress.
BuildResult write_labels(PlaneSource& source, const std::string& output, const Context& context);

/// Volume of one voxel, mm3; nothing where the spacing is not known.
std::optional<double> voxel_mm3(const VolumeDescription& volume);

/// The volume of so many voxels, mm3, or null where the spacing is not known.
nlohmann::ordered_json mm3_json(std::uint64_t voxels, const VolumeDescription& volume);

/// Throws Error{invalid_argument} that says how the grids of two volumes differ: in size, or in
/// where their voxels lie. The error is about `path`, the file of `other`.
/// advice  what to do, the end of the message
void require_same_grid(const VolumeDescription& volume, const std::string& name,
                       const VolumeDescription& other, const std::string& path,
                       const char* advice = "both must share one grid");

/// Warns where one of two volumes has a known spacing and the other has not, whose voxels are taken
/// for 1 mm when one is laid over the other.
/// name, other_name  their files
void warn_of_unknown_spacing(const VolumeDescription& volume, const std::string& name,
                             const VolumeDescription& other, const std::string& other_name,
                             Context& context);

/// Throws Error{limit_exceeded} when `bytes` are above --max-memory.
void require_memory(std::uint64_t bytes, const char* what, const Context& context);

/// "1,234,567 voxels, 123.4 cm3", or mm3 where that reads better; voxels alone where the spacing is
/// not known.
std::string volume_text(std::uint64_t voxels, const VolumeDescription& volume);

}  // namespace octavo::cli
