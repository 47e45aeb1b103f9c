// What is known of a volume besides its voxels.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/voxel_type.h"

namespace octavo {

/// The values are those of the file format.
enum class VolumeKind : std::uint8_t {
  grey = 1,    ///< measured intensities: coarse samples are rounded means
  labels = 2,  ///< names of regions: coarse samples are most frequent labels
};

/// real value = slope * stored value + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  bool operator==(const Rescale&) const = default;
  double to_real(double stored) const { return slope * stored + intercept; }
  bool is_identity() const { return slope == 1 && intercept == 0; }
};

struct VolumeDescription {
  VolumeKind kind = VolumeKind::grey;
  VoxelType type = VoxelType::uint8;
  Size3 size;
  Geometry geometry;
  Rescale rescale;
  /// UTF-8 JSON object. Keys of every importer: "source" {"format", "files", ...}, "unit" ("HU",
  /// ...), "spacing_known" (false when the source carries no spacing and 1 mm was assumed), "dicom"
  /// {...}.
  std::string metadata_json = "{}";
};

}  // namespace octavo
