// What an export will write, settled before the first voxel is read.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/io/export/export.h"

namespace octavo {

/// How stored integers become the integers that are written: value * factor + offset.
struct IntegerMap {
  std::int64_t factor = 1;
  std::int64_t offset = 0;
  bool is_identity() const { return factor == 1 && offset == 0; }
};

struct ExportPlan {
  VolumeKind kind = VolumeKind::grey;
  int level = 0;
  Box box;            ///< in samples of `level`
  Size3 size;         ///< of the box
  Geometry geometry;  ///< of the box's first voxel
  VoxelType stored_type = VoxelType::uint8;
  VoxelType type = VoxelType::uint8;  ///< in the target
  IntegerMap map;                     ///< from stored_type to type, where both are integers
  Rescale applied;  ///< from stored_type to a type of floats, before they are written
  Rescale rescale;  ///< what a reader of the target still has to apply to reach real units
  bool real_units =
      false;  ///< real values in the target, or a rescale that the format applies itself
  bool spacing_known = true;
  bool place_known = true;  ///< false: origin and direction say nothing of a patient
  std::string unit;         ///< of real values; empty where it is not known
  bool overwrite = false;

  std::uint64_t plane_bytes() const;
  std::uint64_t voxel_bytes() const;
};

/// Throws Error{invalid_argument} when the level does not exist or the box is empty or outside it.
ExportPlan plan_export(const FileReader& reader, ExportFormat format, const ExportOptions& options);

/// Throws Error{io} when `path` is taken and may not be replaced, or is no file.
void require_free(Storage& storage, const std::string& path, bool overwrite);

/// What MetaImage calls a voxel type: "MET_SHORT".
const char* meta_type_name(VoxelType type);

}  // namespace octavo
