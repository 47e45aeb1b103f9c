// What a file holds, from its header and index alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct InfoOptions {
  std::string input;  ///< an .8vo file or a URL of one
  /// Gets the thumbnail as PNG, made anew where the file has none; nothing where its path is empty.
  Output thumbnail = {};
};

struct LevelInfo {
  Size3 size;
  Point3 spacing_mm{};
  LevelSummary summary;
};

/// A part of the file beside its voxels.
struct PartInfo {
  std::string tag;
  bool is_required = false;
  bool follows_from_voxels = false;
  bool follows_from_rest = false;  ///< from metadata, other parts, coded bytes
  std::uint64_t bytes = 0;
  bool is_known = false;
};

/// An extension of the header that this program does not know.
struct ExtensionInfo {
  std::uint16_t tag = 0;
  std::uint64_t bytes = 0;
};

struct InfoResult {
  std::string name;
  std::string format_version;
  VolumeDescription volume;
  std::vector<LevelInfo> levels;  ///< level 0 first
  std::uint64_t file_bytes = 0;
  std::uint64_t raw_bytes = 0;
  ValueRange range;            ///< as FileReader::range
  bool has_values = true;      ///< false: every voxel is NaN or infinite
  double max_error = 0;        ///< that the file promises, stored units
  double achieved_error = 0;   ///< the largest found when it was built
  int detail_level = 0;        ///< as FileReader::detail_level
  std::optional<DetailErrors> detail_errors;  ///< as the metadata have them, where that is above 0
  Sha256Digest voxel_digest{};  ///< as FileReader::voxel_digest
  bool is_place_known = true;  ///< false: origin and direction say nothing of a patient
  std::uint64_t thumbnail_bytes = 0;  ///< 0: the file has none
  std::vector<PartInfo> parts;        ///< in the order of the file
  std::vector<ExtensionInfo> unknown_extensions;
  std::uint64_t metadata_offset = 0;  ///< where the text of the metadata stands in the file

  /// Whether both ends of the range are values of voxels; otherwise they are bounds.
  bool is_range_exact() const {
    return max_error == 0 && volume.codec_type() != VoxelType::float32;
  }
  double compression_ratio() const {
    return static_cast<double>(raw_bytes) / static_cast<double>(file_bytes);
  }
  double bits_per_voxel() const {
    return static_cast<double>(file_bytes) * 8 / static_cast<double>(volume.size.voxel_count());
  }
};

/// Throws as open_volume; of a thumbnail, what reading and writing throw, and
///        Error{invalid_argument} for a name that ends in .8vo or is that of the input
InfoResult info(const InfoOptions& options, const TaskContext& context);

}  // namespace octavo
