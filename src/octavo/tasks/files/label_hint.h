// Whether a scan looks like a mask or a label map.
#pragma once

#include <optional>
#include <string>

#include "octavo/core/volume.h"

namespace octavo {

/// Why the source at `path` is taken for labels ("its name contains 'labels'"); nothing when it is
/// not. A word of the name must be one that only label maps bear, and the voxels must be plain
/// integers, and no channel of a color picture.
std::optional<std::string> label_hint(const std::string& path,
                                      const VolumeDescription& description);

}  // namespace octavo
