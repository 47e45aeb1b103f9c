// Writes a box of one level of a file in the formats other programs read.
#pragma once

#include <optional>
#include <string>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

enum class ExportFormat { raw, nrrd, nifti, nifti_gz, meta_image, meta_image_detached, tiff_stack };

/// By extension: .raw .nrrd .nii .nii.gz .mha .mhd; a name that ends in '/', .tif or .tiff, or an
/// existing folder: a stack. Throws Error{invalid_argument} listing the known extensions.
ExportFormat export_format_of(const std::string& path);

/// Which numbers an export of a grey volume holds.
enum class ExportValues {
  exact,   ///< real values where integers hold them or the format knows a slope, else stored ones
  stored,  ///< those of the file, whatever they stand for
  real,    ///< real values as float32, rounded where it cannot hold them
};

struct ExportOptions {
  std::optional<Box> box;  ///< in samples of `level`; default the whole level
  int level = 0;
  ExportValues values = ExportValues::exact;
  bool overwrite = false;
  int threads = 0;
};

/// Where a format has to say what nobody knows, or cannot keep what is known.
struct ExportLimits {
  bool claims_spacing = false;   ///< a number stands for a spacing that is not known
  bool claims_place = false;     ///< it looks as if it said how a patient lies, which is not known
  bool loses_box_start = false;  ///< nothing says where in its volume the box begins
  bool hides_rescale = false;    ///< real values only for who knows where the rescale is noted
};

/// What has to be reported of an export before it. Throws as export_volume.
ExportLimits export_limits(const FileReader& reader, ExportFormat format,
                           const ExportOptions& options);

struct ExportResult {
  std::vector<std::string> files;  ///< what was written, headers first
  VoxelType type;                  ///< voxel type in the target
  bool real_units = false;         ///< values in the target are real (rescaled)
  std::uint64_t bytes = 0;
};

/// Exports through brick layers in order: memory is that of one layer of bricks, for every target.
/// Exact values: where slope and intercept are integers and the result fits an integer type, that
/// type; where the target knows a slope (NIfTI), stored integers with it; otherwise stored
/// integers, and real_units is false. RAW is stored unless real values are asked for.
/// Where the place of the volume is not known, NIfTI has neither sform nor qform and NRRD no space.
/// Throws  Error{invalid_argument} for a level or box that is not there, and for real values of
///         labels
ExportResult export_volume(const FileReader& reader, Storage& storage, const std::string& path,
                           ExportFormat format, const ExportOptions& options, Progress& progress);

}  // namespace octavo
